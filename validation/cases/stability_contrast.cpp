// SPDX-License-Identifier: MIT
/// Stiffness and mass over six decades within one network, stepped with automatic substeps.
#include <algorithm>
#include <cmath>
#include <string>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/problem.hpp"
#include "reference/modal.hpp"
#include "validation/cases/stability.hpp"
#include "validation/cases/stability_networks.hpp"
#include "validation/metrics.hpp"

namespace palpate::stability {

namespace {

constexpr int side = 4;
constexpr double tick = 1e-3;       // [s]
constexpr double duration = 0.05;   // [s]
constexpr double amplitude = 1e-8;  // [m] of 5 mm: linear theory holds to 1e-5

enum class Varied { stiffness, mass };

/// Nodes of the inner 2 x 2 x 2 block.
bool is_inner(int node) {
  const int i = node % side;
  const int j = node / side % side;
  const int l = node / (side * side);
  return i % 3 != 0 && j % 3 != 0 && l % 3 != 0;
}

/// Undamped block with springs `ratio` times stiffer, or nodes `ratio` times lighter, inside.
SpringNetwork block(Varied varied, double ratio) {
  SpringNetwork network = cube(side, 0.0);
  if (varied == Varied::stiffness) {
    network.springs.change_each([&](Spring& s) {
      if (is_inner(s.a) && is_inner(s.b)) { s.stiffness *= ratio; }
    });
    return network;
  }
  for (int i = 0; i < network.node_count(); ++i) {
    if (is_inner(i)) { network.mass(i) /= ratio; }
  }
  return network;
}

struct Rung {
  double ratio = 0.0;
  double limit = 0.0;  ///< of the scheme that stepped, from the exact spectrum [s]
  Motion motion{};
  double energy_growth = 0.0;  ///< largest over initial
  double energy_bound = 0.0;   ///< the same, from theory
};

Scene automatic_scene(const std::string& integrator) {
  Scene scene = scene_of(integrator, tick, duration);
  scene.simulation.substeps.reset();
  return scene;
}

Rung climb(const CaseContext& context, const std::string& integrator, Varied varied, double ratio) {
  SpringNetwork network = block(varied, ratio);
  const Spectrum spectrum = spectrum_of(network);
  displace(network, amplitude);
  Rung rung{.ratio = ratio};
  rung.motion = simulate(context, automatic_scene(integrator), &network, {.energy = true});
  // "auto" leaves velocity Verlet for the implicit midpoint rule, which alone passes the limit.
  const IntegratorInfo* scheme =
      find_integrator(integrator == "auto" ? "velocity-verlet" : integrator);
  rung.limit = network_limit(*scheme, spectrum, 0.0).h;
  if (integrator == "auto" && rung.motion.h > rung.limit) {
    scheme = find_integrator("implicit-midpoint");
    rung.limit = unbounded;
  }
  const auto& energy = rung.motion.energy;
  rung.energy_growth =
      rung.motion.diverged ? std::nan("") : *std::ranges::max_element(energy) / energy.front();
  rung.energy_bound = energy_ratio_bound(*scheme, spectrum.omega.maxCoeff() * rung.motion.h);
  return rung;
}

void judge_ladder(const std::string& integrator, const std::vector<Rung>& ladder, Table& table,
                  Outcome& outcome) {
  double worst_growth = 0.0;
  double least_margin = unbounded;
  for (const Rung& rung : ladder) {
    const double growth = rung.energy_growth / rung.energy_bound;
    if (!(growth <= worst_growth)) { worst_growth = growth; }  // a NaN stays
    const double margin = margin_db(rung.limit, rung.motion.h);
    if (!(margin >= least_margin)) { least_margin = margin; }
    table.rows.push_back({integrator, rung.ratio, static_cast<double>(rung.motion.substeps),
                          1e6 * rung.motion.h, margin, rung.energy_growth, rung.energy_bound});
  }
  outcome.judge({.name = integrator + ": largest energy over initial, over theory",
                 .value = worst_growth,
                 .upper = 1.0 + 1e-4,
                 .bound_from = "quadratic form that the scheme keeps exactly; strains of 1e-5"});
  outcome.judge({.name = integrator + ": least margin over the decades",
                 .value = least_margin,
                 .unit = "dB",
                 .lower = 20.0 * std::log10(2.0) - 1e-9,
                 .bound_from = "automatic substeps stay at half of the guaranteed step"});
}

/// Error of a slow push at a modest contrast: the second-order phase error of the modes up to
/// 500 rad/s, which carry the response to a 20 ms half sine.
void judge_accuracy(const CaseContext& context, Varied varied, Outcome& outcome) {
  const SpringNetwork network = block(varied, 100.0);
  Scene scene = automatic_scene("velocity-verlet");
  scene.loads = {{.face = Face::z_min,
                  .force = {0.0, 0.0, 1e-6},
                  .start = 0.0,
                  .end = 0.02,
                  .profile = Profile::half_sine}};
  const Motion motion = simulate(context, scene, &network);
  const NetworkProblem problem(network, resolve_loads(scene, network));
  const reference::Solution exact = reference::modal_solution<double>(problem, motion.time);
  constexpr double omega = 500.0;
  outcome.judge(
      {.name = "velocity-verlet: error of a slow push at ratio 100",
       .value =
           trajectory_error(motion.position, exact.position, problem.initial_position()).maximum,
       .upper = std::pow(omega * motion.h, 2) / 24.0 * omega * duration,
       .bound_from = "modal superposition; (h w)^2 / 24 w T at w = 500 rad/s"});
}

void measure(const CaseContext& context, Varied varied, Outcome& outcome) {
  const char* what = varied == Varied::stiffness ? "stiffness contrast" : "mass ratio";
  Table table{.id = "ladder",
              .title = "Automatic substeps over six decades",
              .caption =
                  "Margin is 20 log10 of the true limit over the step taken; it is infinite "
                  "where the implicit midpoint rule was chosen.",
              .columns = {"integrator", std::string(what) + " (1)", "substeps (1)", "step (us)",
                          "margin (dB)", "largest energy / initial (1)", "theory (1)"}};
  Figure figure{.id = "step",
                .title = std::string("Step over ") + what,
                .caption =
                    "Steps that automatic substeps take in a tick of 1 ms, and the limit "
                    "from the exact spectrum.",
                .x = {.label = std::string(what) + " (1)", .logarithmic = true},
                .y = {.label = "step (s)", .logarithmic = true}};
  for (const char* integrator : {"euler-cromer", "velocity-verlet", "auto"}) {
    std::vector<Rung> ladder;
    Series steps{.label = integrator, .style = Series::Style::line_and_points};
    for (int decade = 0; decade <= 6; decade += context.quick ? 2 : 1) {
      ladder.push_back(climb(context, integrator, varied, std::pow(10.0, decade)));
      steps.x.push_back(ladder.back().ratio);
      steps.y.push_back(ladder.back().motion.h);
    }
    judge_ladder(integrator, ladder, table, outcome);
    if (figure.series.empty()) {
      Series limit{.label = "true limit", .style = Series::Style::dashed, .x = steps.x};
      for (const Rung& rung : ladder) { limit.y.push_back(rung.limit); }
      figure.series.push_back(std::move(limit));
    }
    figure.series.push_back(std::move(steps));
  }
  judge_accuracy(context, varied, outcome);
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

Case contrast_case(const char* name, Varied varied) {
  return {.name = name,
          .suite = "stability",
          .claim = "automatic substeps keep a run bounded over six decades of " +
                   std::string(varied == Varied::stiffness ? "stiffness" : "mass"),
          .measure = [varied](const CaseContext& context,
                              Outcome& outcome) { measure(context, varied, outcome); },
          .weight = 2.0};
}

}  // namespace

void add_contrast_cases(std::vector<Case>& cases) {
  cases.push_back(contrast_case("stability/stiffness-contrast", Varied::stiffness));
  cases.push_back(contrast_case("stability/mass-ratio", Varied::mass));
}

}  // namespace palpate::stability

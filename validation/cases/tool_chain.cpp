// SPDX-License-Identifier: MIT
/// A chain of springs under the needle: without inertia and friction the force over the depth is a
/// curve of straight stretches and known bends, whatever the integrator.
#include <cmath>

#include "validation/cases/tool_setting.hpp"

namespace palpate::tools {

namespace {

/// Depth [m] and F_c [N] of the three layers; borders on a node and between two nodes.
struct Stratum {
  double begin;
  double end;
  double cutting_force;
};
constexpr std::array strata{Stratum{0.0, 0.004, 0.1}, Stratum{0.004, 0.0093, 0.16},
                            Stratum{0.0093, 1.0, 0.05}};

/// c(d) of a chain that hangs from its last node, d between nodes by hat functions.
double compliance(const Chain& chain, double depth) {
  const double at = depth / chain.spacing;
  const double node = std::floor(at);
  const double share = at - node;
  const double low = (chain.springs - node) / chain.stiffness;
  const double high = (chain.springs - node - 1.0) / chain.stiffness;
  return (1.0 - share) * (1.0 - share) * low + (2.0 - share) * share * high;
}

/// Force at the tool's place s, by walking the curve: stick to F_c, cut to the next border, stick.
double exact_force(const Chain& chain, double s) {
  for (std::size_t n = 0; n < strata.size(); ++n) {
    const Stratum& here = strata[n];
    const double sticking = compliance(chain, here.begin);
    if (s <= here.begin + here.cutting_force * sticking) {
      return (s - here.begin) / sticking;  // negative only where the next layer is the weaker
    }
    if (n + 1 == strata.size() || s <= here.end + here.cutting_force * compliance(chain, here.end)) {
      return here.cutting_force;
    }
  }
  return 0.0;
}

Scene scene_of_chain(const Chain& chain, double speed) {
  Scene scene = chain_scene(chain);
  const char* names[] = {"first", "second", "third"};
  for (std::size_t n = 0; n < strata.size(); ++n) {
    scene.materials.push_back(tissue_of(names[n], 1.0, strata[n].cutting_force, 0.0));
    scene.tissue.layers.push_back({names[n], names[n], strata[n].end - strata[n].begin});
  }
  scene.drive->speed = speed;
  scene.simulation.duration = 0.0155 / speed;
  scene.simulation.step = 1e-5 / speed;  // 10 um of path a tick
  scene.simulation.integrator = "velocity-verlet";
  return scene;
}

void measure_chain(const CaseContext& context, Outcome& outcome) {
  const Chain chain;
  const double speed = 4e-3;
  const Insertion fast = insert_tool(context, scene_of_chain(chain, speed));
  const Insertion slow = insert_tool(context, scene_of_chain(chain, 0.5 * speed));
  const double peak = strata[1].cutting_force;
  // Bends ring for a while; there neither run is at rest.
  const double bends[] = {0.0,
                          0.1 * compliance(chain, 0.0),
                          0.004 + 0.1 * compliance(chain, 0.004),
                          0.004 + 0.16 * compliance(chain, 0.004),
                          0.0093 + 0.16 * compliance(chain, 0.0093)};
  const double ringing = 0.4e-3;
  double worst = 0.0;
  double largest = 0.0;
  std::vector<double> depth;
  std::vector<double> measured;
  std::vector<double> exact;
  const std::size_t samples = std::min(fast.tool.size(), slow.tool.size());
  for (std::size_t n = 0; n < samples; ++n) {
    const double s = fast.tool[n].place;
    const double limit = 2.0 * slow.tool[n].forces.total - fast.tool[n].forces.total;
    const double truth = exact_force(chain, s);
    depth.push_back(1e3 * s);
    measured.push_back(slow.tool[n].forces.total);
    exact.push_back(truth);
    largest = std::fmax(largest, slow.tool[n].forces.total);
    bool rings = false;
    for (const double bend : bends) { rings = rings || (s >= bend - 1e-5 && s < bend + ringing); }
    // Set free by a weaker layer, the tissue swings past the tip and sticks to it deeper down: the
    // curve is the exact one again once that layer is being cut.
    rings = rings || (s >= bends[4] - 1e-5 && s < bends[4] + 3.0 * ringing);
    if (!rings) { worst = std::isnan(limit) ? limit : std::max(worst, std::abs(limit - truth)); }
  }
  const std::string quasi =
      "theory: straight stretches; speeds of 4 and 2 mm/s extrapolated to none, 0.4 mm of "
      "ringing behind each bend left out";
  outcome.judge({.name = "largest_error_over_peak",
                 .value = samples == 0 ? std::nan("") : worst / peak,
                 .upper = 1e-6,
                 .bound_from = quasi});
  outcome.judge({.name = "peak_force",
                 .value = largest,
                 .unit = "N",
                 .lower = peak * (1.0 - 1e-12),
                 .upper = peak * (1.0 + 1e-12),
                 .bound_from = "law: the tip never pushes harder than the cutting force"});
  outcome.judge({.name = "punctures",
                 .value = static_cast<double>(slow.count("puncture")),
                 .lower = 3.0,
                 .upper = 3.0,
                 .bound_from = "one for each layer"});
  Figure figure{.id = "chain",
                .title = "Force over depth of a chain",
                .caption = "Sticking and cutting through three layers: the run at 2 mm/s and the "
                           "exact curve without inertia.",
                .x = {.label = "depth of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series.push_back(curve("2 mm/s", depth, measured));
  figure.series.push_back(curve("exact", depth, exact, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> chain_cases() {
  return {{.name = "needle/chain",
           .suite = "accuracy",
           .claim = "Under a slow needle a chain of springs answers with the exact force: straight "
                    "lines of the static compliance up to each cutting force.",
           .measure = measure_chain,
           .weight = 2.0}};
}

}  // namespace palpate::tools

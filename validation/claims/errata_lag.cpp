// SPDX-License-Identifier: MIT
/// Eq. 9: the extension rate from the previous displacement lags by half a step.

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/tissue/network_builder.hpp"
#include "reference/modal.hpp"
#include "validation/claims/errata_fixture.hpp"
#include "validation/signal.hpp"

namespace palpate::errata {

namespace {

constexpr double span = 0.02;  ///< [s] of the ladder
constexpr long sample_count_of_ladder = 20;
constexpr double relaxation = 0.02 / 50.0;  ///< c / k of every spring [s]

struct Variant {
  std::string name;
  std::string scheme;
  bool lagged;
  int order;
};

/// A pressed lattice over `span`, sampled at 20 instants.
Eigen::MatrixXd run_variant(const CaseContext& context, const Variant& variant, long ticks) {
  Scene scene = pressed_scene(span / static_cast<double>(ticks), span);
  scene.simulation.integrator = variant.scheme;
  scene.simulation.printed.lagged_velocity = variant.lagged;
  const SpringNetwork network = build_network(scene);
  const Trace motion = roll_out(context, scene, &network,
                                {.every = ticks / sample_count_of_ladder, .position = true});
  if (motion.position.cols() == 0) { return {}; }
  const Eigen::VectorXd rest = motion.position.col(0);
  return motion.position.colwise() - rest;
}

std::vector<double> ladder_times() {
  std::vector<double> times;
  for (long n = 0; n <= sample_count_of_ladder; ++n) {
    times.push_back(span * static_cast<double>(n) / static_cast<double>(sample_count_of_ladder));
  }
  return times;
}

ObservedOrder climb(const CaseContext& context, const Variant& variant,
                    const Eigen::MatrixXd& truth, Figure& figure) {
  std::vector<double> h;
  std::vector<double> error;
  for (int rung = 0; rung < (context.quick ? 5 : 6); ++rung) {
    const double coarsest = variant.order == 1 ? 800.0 : 240.0;
    const long ticks =
        sample_count_of_ladder *
        std::lround(coarsest * std::pow(1.37, rung) / static_cast<double>(sample_count_of_ladder));
    h.push_back(span / static_cast<double>(ticks));
    error.push_back(distance(run_variant(context, variant, ticks), truth));
  }
  figure.series.push_back(
      {.label = variant.name, .style = Series::Style::line_and_points, .x = h, .y = error});
  return observed_order(h, error, 1e-9);  // ARKODE at 1e-11 is far below
}

/// Stable step of kick and drift: damping centred, 2 / omega; lagging by h/2,
/// 2 (sqrt(1 + S^2) - S) / omega of the worst mode. C = (c/k) K, so each mode has its own S.
double predicted_limit(bool lagged) {
  const Linear linear = linearise(build_network(lattice_scene(step, step)), {});
  const Eigen::VectorXd squares = reference::symmetric_eigenvalues(linear.stiffness);
  double limit = std::numeric_limits<double>::infinity();
  for (const double square : squares) {
    const double omega = std::sqrt(square);
    const double s = lagged ? 0.5 * relaxation * omega : 0.0;
    limit = std::min(limit, 2.0 / (omega * (std::sqrt(1.0 + s * s) + s)));
  }
  return limit;
}

/// Returns true if a displacement of 1e-9 m, in all modes, grows a hundredfold in 3000 steps.
bool grows(const CaseContext& context, const Variant& variant, double h) {
  const long ticks = 3000;
  Scene scene = lattice_scene(h, static_cast<double>(ticks) * h, variant.scheme);
  scene.simulation.printed.lagged_velocity = variant.lagged;
  SpringNetwork network = build_network(scene);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (Eigen::Index i = 0; i < network.initial_displacement.size(); ++i) {
    network.initial_displacement(i) = 1e-9 * std::cos(1.0 + 12.9898 * static_cast<double>(i));
  }
  for (int node = 0; node < network.node_count(); ++node) {
    if (network.is_fixed(node)) { network.initial_displacement.col(node).setZero(); }
  }
  const Trace motion = roll_out(context, scene, &network, {.every = 50, .position = true});
  if (motion.diverged || !motion.position.allFinite()) { return true; }
  const Eigen::VectorXd start = motion.position.col(0);
  const auto moved = (motion.position.colwise() - start).cwiseAbs().maxCoeff();
  return moved > 1e-7;
}

double found_limit(const CaseContext& context, const Variant& variant) {
  double good = 2e-3;
  double bad = 3.2e-3;
  if (grows(context, variant, good)) { return 0.0; }
  while (bad - good > 2e-3 * bad) {
    const double middle = std::sqrt(good * bad);
    (grows(context, variant, middle) ? bad : good) = middle;
  }
  return 0.5 * (good + bad);
}

void judge_limit(const CaseContext& context, Outcome& outcome, const Variant& variant,
                 Table& table) {
  const double theory = predicted_limit(variant.lagged);
  const double found = found_limit(context, variant);
  outcome.judge({.name = variant.name + ": stable step over theory",
                 .value = found / theory,
                 .lower = 0.995,
                 .upper = 1.005,
                 .bound_from = "eigenvalues of the linearised lattice; 0.2 % of the search, 3000 "
                               "steps to grow in"});
  table.rows.push_back({variant.name, found, theory});
}

/// Along a spring the last displacement of Euler-Cromer is h times the velocity it has now.
void judge_no_lag(const CaseContext& context, Outcome& outcome) {
  const Eigen::MatrixXd plain = run_pressed(context, {}, 500).displacement;
  const Eigen::MatrixXd lagged = run_pressed(context, {.lagged_velocity = true}, 500).displacement;
  const double strain = plain.size() == 0 ? 0.0 : plain.cwiseAbs().maxCoeff() / 0.005;
  outcome.judge({.name = "Euler-Cromer with the lag less without",
                 .value = distance(lagged, plain),
                 .upper = strain,
                 .bound_from = "x(n) - x(n-1) = h v(n); springs turn by no more than the strain"});
}

/// Explicit Euler with the lag uses the velocity of a whole step ago. The fastest mode q obeys
/// q(n+1) = 2 q(n) - q(n-1) - h^2 w^2 q(n-1) - h (c/k) w^2 (q(n-1) - q(n-2)), q before 0 as at 0.
void judge_recurrence(const CaseContext& context, Outcome& outcome) {
  const long steps = 100;
  Scene scene = lattice_scene(step, static_cast<double>(steps) * step, "euler");
  scene.simulation.printed.lagged_velocity = true;
  SpringNetwork network = build_network(scene);
  const reference::SymmetricModes modes =
      reference::symmetric_modes(linearise(network, {}).stiffness);
  const Eigen::VectorXd shape = modes.vectors.rightCols(1);
  const double square = modes.values.maxCoeff();
  const double amplitude = 1e-9;
  // Nodes are numbered layer by layer and the fixed layer is the last, so free nodes come first.
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement.leftCols(shape.size() / 3) =
      amplitude * Eigen::Map<const NodeVectors>(shape.data(), 3, shape.size() / 3);
  const Trace motion = roll_out(context, scene, &network, {.position = true});
  double error = motion.position.cols() == steps + 1 ? 0.0 : std::nan("");
  double q[3] = {amplitude, amplitude, amplitude};  // q(n), q(n-1), q(n-2)
  for (Eigen::Index n = 1; n < motion.position.cols() && error >= 0.0; ++n) {
    const double drift = n == 1 ? q[0]  // at rest before the first step
                                : 2.0 * q[0] - q[1] - step * step * square * q[1] -
                                      step * relaxation * square * (q[1] - q[2]);
    q[2] = q[1];
    q[1] = q[0];
    q[0] = drift;
    const double found = shape.dot(motion.position.col(n) - motion.position.col(0)) + amplitude;
    error = std::max(std::abs(found - q[0]), error);
    if (!std::isfinite(found)) { error = std::nan(""); }
  }
  outcome.judge({.name = "Euler with the lag less its recurrence",
                 .value = error / amplitude,
                 .upper = 1e-5,
                 .bound_from = "strains of 1e-6; 100 steps of 1e-18 m of rounding in 1e-9 m"});
}

const std::array<Variant, 4>& variants() {
  static const std::array<Variant, 4> all{
      Variant{"leapfrog, rate at the instant", "leapfrog", false, 2},
      Variant{"half-step start, rate of h/2 ago", "feynman-newton", false, 1},
      Variant{"half-step start, lagged as printed", "feynman-newton", true, 1},
      Variant{"Euler, lagged as printed", "euler", true, 1}};
  return all;
}

double judge_orders(const CaseContext& context, Outcome& outcome) {
  const Eigen::MatrixXd truth = solve_pressed(ladder_times(), {});
  Figure figure{.id = "order",
                .title = "What the lag of Eq. 9 costs",
                .caption =
                    "With the rate at the instant of the position the same kick and drift "
                    "has order 2; with the printed rate it has order 1.",
                .x = {.label = "step h (s)", .logarithmic = true},
                .y = {.label = "largest error over peak (1)", .logarithmic = true}};
  std::array<double, 4> slopes{};
  for (std::size_t i = 0; i < variants().size(); ++i) {
    const ObservedOrder order = climb(context, variants()[i], truth, figure);
    slopes[i] = order.slope;
    const double p = variants()[i].order;
    outcome.judge({.name = "order: " + variants()[i].name,
                   .value = order.slope,
                   .lower = p - 0.15,
                   .upper = p + 0.15,
                   .bound_from = variants()[i].order == 2 ? "centred differences"
                                                          : "a rate that lags is wrong by O(h)"});
  }
  outcome.figures.push_back(std::move(figure));
  outcome.judge({.name = "order lost",
                 .value = slopes[0] - slopes[2],
                 .lower = 0.7,
                 .upper = 1.3,
                 .bound_from = "one, from two slopes known to 0.15"});
  return slopes[0] - slopes[2];
}

}  // namespace

Finding measure_lagged_velocity(const CaseContext& context, Outcome& outcome) {
  const double lost = judge_orders(context, outcome);
  Table limits{.id = "limits",
               .title = "Stable steps of the lattice",
               .caption = "Found by bisection on runs, and predicted from its modes.",
               .columns = {"scheme", "found (s)", "theory (s)"}};
  if (!context.quick) { judge_limit(context, outcome, variants()[0], limits); }
  judge_limit(context, outcome, variants()[2], limits);
  outcome.tables.push_back(std::move(limits));
  judge_no_lag(context, outcome);
  judge_recurrence(context, outcome);
  compare_pressed(context, outcome, {.lagged_velocity = true}, "lagged-velocity");
  outcome.notes.emplace_back(
      "In Euler-Cromer the last displacement is the step times the velocity it has now, so the lag "
      "of Eq. 9 changes nothing there; it is in a scheme of second order that it costs an order.");
  return {"lagged velocity", "Eq. 9", "one order of accuracy and some of the stable step",
          "order lost (1)",  lost,    1.0};
}

}  // namespace palpate::errata

// SPDX-License-Identifier: MIT
/// Any simulator under test: accuracy of its trajectories with its own integrator, laws of
/// conservation, static and continuum solutions, and audits against caches and wrong units
/// (docs/subjects.md, "How a subject is judged"). Palpate's model is one of the subjects.

#include "validation/subject/subject.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "model/tissue/network_builder.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/signal.hpp"

namespace palpate::subjects {

namespace {

using networks::text;

/// The model is judged with the simplest scheme, one step a tick, as the other simulators are.
constexpr const char* simplest_scheme = "euler-cromer";

// Single precision keeps 2^-24 = 6e-8 of a coordinate; a displacement of a hundredth of the body
// keeps 6e-6 of itself, and a run of some hundred steps a hundred times that.
constexpr double single_precision = 1e-3;
constexpr const char* why_single =
    "single precision of coordinates over some hundred steps: 2^-24 of the body's size a step";

/// Skips the case if the subject lacks a capability beyond those of its scene.
void require(const CaseContext& context, Capabilities needed) {
  const SubjectFacts facts = context.make_subject()->facts();
  if (const Capabilities lacking = needed & ~facts.capabilities; lacking != 0) {
    throw CannotDo("the subject does not declare: " + names_of(lacking));
  }
}

/// A run that diverges fails the case: its trace ends before the bad state.
void must_end(const Trace& trace, Outcome& outcome) {
  const bool known = std::ranges::count(outcome.quantities, "every_run_ends", &Quantity::name) > 0;
  if (!trace.diverged || known) { return; }
  outcome.judge_true("every_run_ends", false,
                     "the subject diverged, or answered a number that is not finite");
}

/// Fails a subject whose first state is not that of the scene, by its relative error: one that
/// answers zero keeps momentum and energy too.
void must_begin_there(double error, Outcome& outcome) {
  constexpr double rounding = 1e-4;  // of single precision
  if (error <= rounding) { return; }
  outcome.judge_true("begins_as_given", false, "the first state is not that of the scene");
}

/// Runs the subject to the end of the scene.
template <class... Arguments>
Trace run_whole(Outcome& outcome, const CaseContext& context, Arguments&&... arguments) {
  Trace trace = roll_out(context, std::forward<Arguments>(arguments)...);
  must_end(trace, outcome);
  return trace;
}

Scene s26_scene(int nodes, double step, double duration) {
  Scene scene = palpate::s26_scene(nodes);
  scene.simulation.step = step;
  scene.simulation.duration = duration;
  return scene;
}

int pulled_node(int nodes) { return palpate::s26_scene(nodes).loads.front().nodes.front(); }

/// Path of the node "tip" [m], 3 x rows.
NodeVectors path_of(const Trace& trace) {
  NodeVectors path(3, static_cast<Eigen::Index>(trace.rows()));
  for (const auto& [axis, column] : {std::pair(0, "tip.x_m"), {1, "tip.y_m"}, {2, "tip.z_m"}}) {
    path.row(axis) = Eigen::Map<const Eigen::RowVectorXd>(trace.values(column).data(),
                                                          static_cast<Eigen::Index>(trace.rows()));
  }
  return path;
}

/// The same at multiples of an interval [s]; NaN where the trace has no row.
NodeVectors path_at(const Trace& trace, double interval, Eigen::Index count) {
  const NodeVectors all = path_of(trace);
  NodeVectors path = NodeVectors::Constant(3, count, std::nan(""));
  std::size_t row = 0;
  for (Eigen::Index n = 0; n < count; ++n) {
    const double t = static_cast<double>(n) * interval;
    while (row + 1 < trace.rows() && trace.time[row] < t - 1e-9) { ++row; }
    const bool reached = row < trace.rows() && trace.time[row] > t - 1e-9;
    if (reached) { path.col(n) = all.col(static_cast<Eigen::Index>(row)); }
  }
  return path;
}

/// Path of a node in a reference solution.
NodeVectors path_in(const Trace& reference, const NetworkProblem& problem, int node) {
  return reference.position.middleRows<3>(problem.coordinate(node));
}

/// Largest distance, column by column, over the largest size of the truth, which is measured from
/// its first column if `from_start`.
double largest_distance(const Eigen::MatrixXd& values, const Eigen::MatrixXd& truth,
                        bool from_start) {
  if (values.cols() != truth.cols()) { return std::nan(""); }
  Largest error;
  Largest size;
  for (Eigen::Index n = 0; n < truth.cols(); ++n) {
    error.add((values.col(n) - truth.col(n)).norm());
    size.add((from_start ? Eigen::VectorXd(truth.col(n) - truth.col(0)) : truth.col(n)).norm());
  }
  return error.value() / size.value();
}

/// The same of a path, from its start. A coordinate that is NaN from end to end is one that a trace
/// of another simulator does not have; one at least is needed.
double largest_error(NodeVectors path, const NodeVectors& truth) {
  int known = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!path.row(axis).array().isNaN().all()) {
      ++known;
    } else if (path.cols() == truth.cols()) {
      path.row(axis) = truth.row(axis);
    }
  }
  return known > 0 ? largest_distance(path, truth, true) : std::nan("");
}

struct Run {
  NodeVectors tip{};
  double error = 0.0;         ///< along the trajectory [1]
  double last = 0.0;          ///< at the end, relative, signed [1]
  double step_seconds = 0.0;  ///< mean time of a step [s]
  double slowest = 0.0;       ///< [s]
};

void measure_s26(const CaseContext& context, Outcome& outcome) {
  constexpr int nodes = 10;
  constexpr double interval = 1e-3;
  constexpr double duration = 0.1;
  constexpr Eigen::Index samples = 101;
  const Scene first = s26_scene(nodes, interval, duration);
  const SpringNetwork network = build_network(first);
  const NetworkProblem problem = networks::problem_of(first, network);
  std::vector<double> times;
  for (Eigen::Index n = 0; n < samples; ++n) { times.push_back(static_cast<double>(n) * interval); }
  const networks::TruthSettings settings{.tolerance = {.relative = 1e-11}, .demanded_digits = 7.0};
  const networks::Truth truth = networks::find_truth(context, problem, times, settings);
  networks::judge_truth(truth, settings, outcome);
  const NodeVectors exact = path_in(truth.solution, problem, pulled_node(nodes));

  const bool replayed = context.make_subject()->facts().replayed;
  const std::vector<double> steps =
      replayed ? std::vector{1e-3} : std::vector{1e-3, 0.5e-3, 0.25e-3};
  const auto run_at = [&](const CaseContext& with, double step) {
    const Trace trace = run_whole(outcome, with, s26_scene(nodes, step, duration), SampleOptions{});
    Run run{.tip = path_at(trace, interval, samples)};
    run.error = largest_error(run.tip, exact);
    run.last =
        (run.tip(2, samples - 1) - exact(2, samples - 1)) / (exact(2, samples - 1) - exact(2, 0));
    run.step_seconds = trace.seconds / static_cast<double>(std::max(1L, trace.ticks));
    run.slowest = trace.slowest_tick;
    return run;
  };
  Table& table = outcome.table(
      "s26", "S26, 10 nodes a side",
      "Displacement of the pulled node, against a reference on which two solvers agree. Euler: the "
      "simplest scheme, semi-implicit Euler, at the same step. Real time: simulated over computed.",
      {"step (ms)", "largest error (1)", "of Euler (1)", "error at 0.1 s (1)", "order", "us a step",
       "real time (1)"});
  Figure& figure = outcome.plot("tip", "Pulled node of S26",
                                "Displacement of the pulled node over time, and its reference.",
                                {"time (ms)"}, {"displacement (mm)"});
  const auto draw = [&](std::string label, const NodeVectors& path, Series::Style style) {
    Series& series = figure.add(std::move(label), style);
    for (Eigen::Index n = 0; n < path.cols(); ++n) {
      series.add(1e3 * times[static_cast<std::size_t>(n)], 1e3 * (path(2, n) - exact(2, 0)));
    }
  };
  std::vector<Run> runs;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    runs.push_back(run_at(context, steps[n]));
    const Run& run = runs.back();
    const double simplest = run_at({}, steps[n]).error;
    const double order = n == 0 ? std::nan("") : std::log2(runs[n - 1].error / run.error);
    const std::string tag = "_at_" + text(1e3 * steps[n]) + "_ms";
    outcome.judge_at_most("largest_error" + tag, run.error, 2.0 * simplest,
                          "twice the error of semi-implicit Euler at the same step");
    outcome.report("error_at_100_ms" + tag, run.last);
    table.rows.push_back({1e3 * steps[n], run.error, simplest, run.last,
                          n == 0 ? Cell("-") : Cell(order), 1e6 * run.step_seconds,
                          run.step_seconds > 0.0 ? Cell(steps[n] / run.step_seconds) : Cell("-")});
    outcome.timings.push_back(
        {.name = "step" + tag, .value = 1e6 * run.step_seconds, .unit = "us"});
    draw("subject, " + text(1e3 * steps[n]) + " ms", run.tip, Series::Style::line);
  }
  draw("reference", exact, Series::Style::dashed);
  if (runs.size() > 1) {
    const double floor = single_precision;
    const double order = std::log2(runs[runs.size() - 2].error / runs.back().error);
    const bool at_floor = runs.back().error < floor;
    outcome.judge_at_least("observed_order_or_1_at_the_floor", at_floor ? 1.0 : order, 0.7,
                           "theory: a consistent scheme is of order one at least; from 0.5 to 0.25 "
                           "ms, unless the error is below that of single precision");
    outcome.report("observed_order", order);
  }
  outcome.timings.push_back(
      {.name = "slowest step", .value = 1e6 * runs.front().slowest, .unit = "us"});
  const std::unique_ptr<Subject> subject = context.make_subject();
  std::vector<double> empty;
  for (int n = 0; n < 200; ++n) { empty.push_back(subject->round_trip()); }
  if (const double median = comparison::quantile(empty, 0.5); median > 0.0) {
    outcome.timings.push_back({.name = "empty call", .value = 1e6 * median, .unit = "us"});
  }
}

/// The first step shows when a load acts, in which unit, and on which mass.
void measure_first_step(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE);
  constexpr double h = 1e-3;
  const Scene scene = s26_scene(5, h, h);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem = networks::problem_of(scene, network);
  const int node = pulled_node(5);
  const Eigen::Index z = problem.coordinate(node) + 2;
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem.jacobian(problem.initial_position(), Eigen::VectorXd::Zero(problem.dof()), stiffness,
                   damping);
  const double mass = network.mass(node);
  const double free = 0.1 * h / mass;
  const double held = 0.1 * h / (mass + h * damping.coeff(z, z) + h * h * stiffness.coeff(z, z));
  const Trace trace =
      run_whole(outcome, context, scene, SampleOptions{.position = true, .velocity = true});
  outcome.judge_between("velocity_after_one_step", trace.velocity(z, trace.velocity.cols() - 1),
                        0.9 * held, 1.1 * free,
                        "theory: F h / m of a free node, and of one that its springs and dampers "
                        "hold (implicit Euler with neighbours at rest), 10 % wider",
                        "m/s");
  Largest moved;
  for (const int other : problem.free_nodes()) {
    const Eigen::Index row = problem.coordinate(other);
    moved.add((trace.position.col(trace.position.cols() - 1) - problem.initial_position())
                  .segment<3>(row)
                  .norm());
  }
  outcome.judge_at_most("distance_of_a_node_after_one_step", moved.value(), 1.1 * free * h,
                        "theory: the path of a free node at its velocity after the step, 10 % more",
                        "m");
  Eigen::VectorXd others = trace.velocity.col(0);
  outcome.judge_at_most("velocity_before_it", others.cwiseAbs().maxCoeff(), 0.0,
                        "the scene starts at rest", "m/s");
}

void measure_static(const CaseContext& context, Outcome& outcome) {
  Scene scene = s26_scene(5, 1e-3, context.quick ? 1.5 : 3.0);
  scene.tissue.lattice.viscosity = 0.1;
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem = networks::problem_of(scene, network);
  const reference::Equilibrium rest = reference::static_equilibrium(problem);
  const Eigen::Index z = problem.coordinate(pulled_node(5)) + 2;
  const double expected = rest.position(z) - problem.initial_position()(z);
  const Trace trace = run_whole(outcome, context, scene, SampleOptions{.every = 100});
  const std::vector<double>& tip = trace.values("tip.z_m");
  NodeVectors end(3, 2);  // the truth begins where the scene does
  end << problem.initial_position().segment<3>(z - 2), rest.position.segment<3>(z - 2);
  const NodeVectors path = path_of(trace);
  NodeVectors seen(3, 2);
  seen << path.col(0), path.col(path.cols() - 1);
  outcome.judge_at_most("distance_from_static_solution", largest_error(seen, end), 5e-3,
                        "the same, of the whole place over the deflection");
  outcome.judge_near("deflection_over_static_solution", (tip.back() - tip.front()) / expected, 1.0,
                     5e-3,
                     "static equilibrium of the same springs; what has not decayed is below 0.1 %");
  outcome.report("deflection", tip.back() - tip.front(), "m");
}

/// Block whose surface is displaced by an affine map while its inside starts at rest.
void measure_patch(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE);
  constexpr int nodes = 5;
  Scene scene = s26_scene(nodes, 1e-3, context.quick ? 1.0 : 2.0);
  scene.loads.clear();
  scene.tissue.lattice.viscosity = 0.1;
  scene.tissue.fixed = {Face::x_min, Face::x_max, Face::y_min,
                        Face::y_max, Face::z_min, Face::z_max};
  SpringNetwork network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  Eigen::Matrix3d gradient;
  gradient << 0.02, 0.01, -0.005, 0.0, -0.01, 0.015, 0.01, 0.0, 0.015;
  const NodeVectors affine = gradient * network.rest_position;
  network.initial_displacement.setZero(3, network.node_count());
  for (int n = 0; n < network.node_count(); ++n) {
    if (network.is_fixed(n)) { network.initial_displacement.col(n) = affine.col(n); }
  }
  const Trace trace =
      run_whole(outcome, context, scene, &network, SampleOptions{.every = 100, .position = true});
  const NetworkProblem problem = networks::problem_of(scene, network);
  Largest error;
  Largest peak;
  for (const int node : problem.free_nodes()) {
    const Eigen::Vector3d exact = network.rest_position.col(node) + affine.col(node);
    const Eigen::Vector3d found =
        trace.position.rightCols(1).col(0).segment<3>(problem.coordinate(node));
    error.add((found - exact).norm());
    peak.add(affine.col(node).norm());
  }
  outcome.judge_at_most("distance_from_the_affine_map", error.value() / peak.value(),
                        single_precision,
                        "theory: every inner node is a centre of symmetry of its springs, so the "
                        "affine map is the equilibrium; single precision of 40 mm over 0.4 mm");
}

/// Fixed-free chain along z, displaced by 1 mm in its first longitudinal mode.
struct Chain {
  static constexpr double spacing = 0.01;  ///< [m]
  SpringNetwork network{};
  double omega = 0.0;  ///< of the mode without damping [rad/s]
};

Chain chain_in_first_mode(int masses, double damping_ratio) {
  constexpr double k = 200.0;
  constexpr double m = 1e-3;
  constexpr double amplitude = 1e-3;
  const double angle = std::numbers::pi / (2.0 * (2.0 * masses + 1.0));
  Chain chain{.omega = 2.0 * std::sqrt(k / m) * std::sin(angle)};
  SpringNetwork& network = chain.network;
  network.rest_position.setZero(3, masses + 1);
  network.initial_displacement.setZero(3, masses + 1);
  network.mass.setConstant(masses + 1, m);
  network.fixed.assign(static_cast<std::size_t>(masses) + 1, 0);
  network.fixed.front() = 1;
  const double viscosity = 2.0 * damping_ratio / chain.omega * k;
  for (int n = 1; n <= masses; ++n) {
    network.rest_position(2, n) = n * Chain::spacing;
    network.initial_displacement(2, n) = amplitude * std::sin(2.0 * angle * n);
    network.springs.push_back({n - 1, n, k, viscosity, Chain::spacing});
  }
  return chain;
}

void measure_chain(const CaseContext& context, Outcome& outcome) {
  constexpr int masses = 10;
  const Chain chain = chain_in_first_mode(masses, 0.0);
  const SpringNetwork& network = chain.network;
  const double omega = chain.omega;
  const double period = 2.0 * std::numbers::pi / omega;
  constexpr long steps = 200;
  const double h = period / static_cast<double>(steps);
  Scene scene = scene_of(simplest_scheme, h, period);
  scene.records = {{.name = "end", .where = masses}};
  const Trace trace = run_whole(outcome, context, scene, &network, SampleOptions{});
  Largest error;
  const double peak = network.initial_displacement(2, masses);
  Figure& figure = outcome.plot("mode", "First mode of a chain",
                                "Free end of a chain of ten masses over one period.",
                                {"time over period"}, {"displacement (mm)"});
  Series& measured = figure.add("subject");
  Series& formula = figure.add("cos(omega t)", Series::Style::dashed);
  for (std::size_t n = 0; n < trace.rows(); ++n) {
    const double z = trace.values("end.z_m")[n] - masses * Chain::spacing;
    const double exact = peak * std::cos(omega * trace.time[n]);
    error.add(std::abs(z - exact) / peak);
    measured.add(trace.time[n] / period, 1e3 * z);
    formula.add(trace.time[n] / period, 1e3 * exact);
  }
  const double loss = 1.0 - std::exp(-std::numbers::pi * omega * h);
  outcome.judge_at_most("largest_error", error.value(), 1.25 * loss,
                        "closed form; implicit Euler at this step loses " + text(loss) +
                            " of the amplitude in a period, more than any other scheme");
}

/// Share of its amplitude that a damped oscillation, which starts at rest, keeps over half a
/// period.
double kept_amplitude(const std::vector<double>& z) {
  const auto lowest = std::ranges::min_element(z) - z.begin();
  if (lowest < 1 || lowest + 1 >= static_cast<std::ptrdiff_t>(z.size())) { return std::nan(""); }
  // Vertex of the parabola through the three lowest points.
  const auto at = [&](std::ptrdiff_t n) { return z[static_cast<std::size_t>(lowest + n)]; };
  const double slope = 0.5 * (at(1) - at(-1));
  const double bend = at(1) - 2.0 * at(0) + at(-1);
  return -(at(0) - 0.5 * slope * slope / bend) / z.front();
}

/// A wrong viscosity changes the decay of a mode. What the scheme adds falls with the step and is
/// removed by Richardson's extrapolation from two steps.
void measure_damping(const CaseContext& context, Outcome& outcome) {
  if (context.make_subject()->facts().replayed) { throw CannotDo("a trace has one step"); }
  constexpr int masses = 5;
  constexpr double ratio = 0.1;
  const Chain chain = chain_in_first_mode(masses, ratio);
  const double period = 2.0 * std::numbers::pi / chain.omega / std::sqrt(1.0 - ratio * ratio);
  std::array<double, 2> decay{};
  for (const std::size_t finer : {0U, 1U}) {
    const double h = period / (finer == 0 ? 1000.0 : 2000.0);
    Scene scene = scene_of(simplest_scheme, h, 0.6 * period);
    scene.records = {{.name = "end",
                      .where = masses,
                      .quantities = {RecordedQuantity::position, RecordedQuantity::velocity}}};
    const Trace trace = run_whole(outcome, context, scene, &chain.network, SampleOptions{});
    Largest rate;
    Largest reported;
    for (std::size_t n = 1; n < trace.rows(); ++n) {
      const std::vector<double>& place = trace.values("end.z_m");
      rate.add(std::abs(place[n] - place[n - 1]) / h);
      reported.add(std::abs(trace.values("end.vz_m_per_s")[n]));
    }
    outcome.judge_near(finer == 0 ? "velocity_over_change_of_place"
                                  : "velocity_over_change_of_place_at_half_the_step",
                       reported.value() / rate.value(), 1.0, 0.01,
                       "definition: of their largest values, at a thousand steps a period");
    std::vector<double> z = trace.values("end.z_m");
    for (double& each : z) { each -= masses * Chain::spacing; }
    decay[finer] = -std::log(kept_amplitude(z));
  }
  const double exact = std::numbers::pi * ratio / std::sqrt(1.0 - ratio * ratio);
  outcome.judge_near(
      "decay_over_exact", (2.0 * decay[1] - decay[0]) / exact, 1.0, 5e-3,
      "closed form of a mode with a damping ratio of 0.1; what steps of a thousandth "
      "and half of it add to the second order is below 0.1 %");
  outcome.report("decay_over_exact_at_the_larger_step", decay[0] / exact);
}

/// Fixed nodes on a face and within the block, in another order.
void measure_fixed_nodes(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE | PALPATE_CAN_FIXED_NODES);
  Scene scene = s26_scene(5, 1e-3, 0.05);
  SpringNetwork network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  for (const std::size_t node : {62U, 77U, 88U}) { network.fixed[node] = 1; }
  (void)renumber(network, scene, 13);
  const std::unique_ptr<Subject> subject = context.make_subject();
  subject->load(scene, network, context.skip);
  Largest distance;
  Largest speed;
  const auto look = [&] {
    const Eigen::Vector2d motion = subject->fixed_motion();
    distance.add(motion.x());
    speed.add(motion.y());
  };
  look();
  StepStatus status = StepStatus::ok;
  while (subject->ticks() < subject->tick_count() && status == StepStatus::ok) {
    status = subject->step({});
    if (const std::string failure = subject->failure(); !failure.empty()) {
      throw SubjectFailure(failure);
    }
    look();
  }
  outcome.judge_true("every_run_ends", status == StepStatus::ok && subject->has_finite_state(),
                     "the subject diverged, or answered a number that is not finite");
  outcome.judge_at_most("distance_of_a_fixed_node_from_its_place", distance.value(), 1e-8,
                        "law: it never moves; single precision of a coordinate of 40 mm keeps 2 nm",
                        "m");
  outcome.judge_at_most("speed_of_a_fixed_node", speed.value(), 0.0, "law: it never moves", "m/s");
}

/// Block without supports, with random velocities.
SpringNetwork free_block(double viscosity, double speed) {
  networks::Block block{.nodes = {4, 4, 4}, .spacing = 0.01};
  SpringNetwork network = networks::block_network(block);
  network.springs.change_each([&](Spring& s) { s.viscosity = viscosity; });
  Random random(7);
  network.initial_velocity.resize(3, network.node_count());
  for (Eigen::Index n = 0; n < network.node_count(); ++n) {
    network.initial_velocity.col(n) = random.vector(3, speed);
  }
  return network;
}

void measure_momentum(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE);
  const SpringNetwork network = free_block(0.02, 0.05);
  const Scene scene = scene_of(simplest_scheme, 2e-4, 0.1);
  const Trace trace =
      run_whole(outcome, context, scene, &network, SampleOptions{.every = 50, .velocity = true});
  const auto momentum = [&](Eigen::Index row) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index n = 0; n < network.node_count(); ++n) {
      sum += network.mass(n) * trace.velocity.col(row).segment<3>(3 * n);
    }
    return sum;
  };
  const Eigen::VectorXd given = network.initial_velocity.reshaped();
  must_begin_there((trace.velocity.col(0) - given).norm() / given.norm(), outcome);
  double scale = 0.0;
  for (Eigen::Index n = 0; n < network.node_count(); ++n) {
    scale += network.mass(n) * network.initial_velocity.col(n).norm();
  }
  Largest drift;
  for (Eigen::Index row = 0; row < trace.velocity.cols(); ++row) {
    drift.add((momentum(row) - momentum(0)).norm() / scale);
  }
  outcome.judge_at_most("momentum_drift", drift.value(), 1e-4,
                        "law: inner forces sum to zero; single precision over 500 steps");
}

void measure_energy(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE);
  const SpringNetwork network = free_block(0.0, 0.02);
  Scene scene = scene_of(simplest_scheme, 0.0, 0.0);
  const double omega = networks::highest_frequency(networks::problem_of(scene, network));
  scene.simulation.step = 0.2 / omega;
  scene.simulation.duration = 1000.0 * scene.simulation.step;
  const Trace trace =
      run_whole(outcome, context, scene, &network, SampleOptions{.every = 10, .energy = true});
  const std::vector<double>& energy = trace.values("energy_j");
  const NetworkProblem problem = networks::problem_of(scene, network);
  const double given = problem.energy(problem.initial_position(), problem.initial_velocity());
  must_begin_there(std::abs(energy.front() / given - 1.0), outcome);
  Largest largest;
  for (const double one : energy) { largest.add(one / energy.front()); }
  outcome.judge_at_most("largest_energy_over_initial", largest.value(), 1.2,
                        "theory: a symplectic scheme of order one oscillates by omega h / 2 = 0.1; "
                        "no scheme may add energy");
  outcome.report("final_energy_over_initial", energy.back() / energy.front());
}

/// Compares the energies that the subject reports with those of its own state.
void measure_reported_energy(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE | PALPATE_CAN_ENERGY);
  const Scene scene = s26_scene(5, 1e-3, 0.05);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem = networks::problem_of(scene, network);
  const std::unique_ptr<Subject> subject = context.make_subject();
  subject->load(scene, network, context.skip);
  must_end(roll_out(*subject, scene), outcome);
  Eigen::VectorXd q(problem.dof());
  Eigen::VectorXd v(problem.dof());
  subject->coordinates(q);
  subject->velocities(v);
  const double all = problem.energy(q, v);
  const double kinetic = 0.5 * v.dot(problem.mass().cwiseProduct(v));
  const Eigen::Vector3d reported = subject->reported_energy();
  const std::string from = "energy of the state that the subject returns; single precision";
  if (!std::isnan(reported(0))) {
    outcome.judge_near("kinetic_over_that_of_its_state", reported(0) / kinetic, 1.0,
                       10.0 * single_precision, from);
  }
  if (!std::isnan(reported(1))) {
    outcome.judge_near("elastic_over_that_of_its_state", reported(1) / (all - kinetic), 1.0,
                       10.0 * single_precision, from);
  }
  if (reported.hasNaN()) {
    outcome.notes.emplace_back("No balance: not all of kinetic, elastic, dissipated are reported.");
    return;
  }
  outcome.judge_at_least("dissipated", reported(2), 0.0, "law: dampers only take energy", "J");
  // A constant load works by its way, and springs, dampers and masses take the work.
  const Load& load = scene.loads.front();
  const Eigen::Vector3d way =
      (q - problem.initial_position()).segment<3>(problem.coordinate(pulled_node(5)));
  outcome.judge_near("sum_over_work_of_the_load", reported.sum() / load.force.dot(way), 1.0, 0.1,
                     "law: kinetic + elastic + dissipated = work; a scheme of order one at steps "
                     "of 1 ms errs by some omega h / 2 of the modes that the load drives");

  const SpringNetwork free = free_block(0.02, 0.05);
  Scene closed = scene_of(simplest_scheme, 0.0, 0.0);
  closed.simulation.step = 0.1 / networks::highest_frequency(networks::problem_of(closed, free));
  closed.simulation.duration = 500.0 * closed.simulation.step;
  subject->load(closed, free, context.skip);
  const double before = subject->reported_energy().sum();
  must_end(roll_out(*subject, closed), outcome);
  const Eigen::Vector3d after = subject->reported_energy();
  outcome.judge_near("free_vibration_sum_over_initial", after.sum() / before, 1.0, 0.1,
                     "law: a closed body keeps kinetic + elastic + dissipated; twice the omega h / "
                     "2 by which a scheme of order one errs");
  outcome.report("share_that_is_dissipated", after(2) / before);
}

/// Puts a state into a network as its start.
void start_from(SpringNetwork& network, const NodeVectors& position, const NodeVectors& velocity) {
  network.initial_displacement = position - network.rest_position;
  network.initial_velocity = velocity;
}

/// Sets the state of the reference in the middle of a run, and compares what follows with the
/// reference. Then it continues a run of the subject from its own state.
void measure_set_state(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE | PALPATE_CAN_SET_STATE);
  constexpr double interval = 1e-3;
  constexpr Eigen::Index middle = 5;  // the nodes are still fast
  // A quarter of it, so that a wrong velocity is seen beside the error of semi-implicit Euler.
  const Scene scene = s26_scene(5, 0.25 * interval, 2.0 * static_cast<double>(middle) * interval);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem = networks::problem_of(scene, network);
  Scene half = scene;
  half.simulation.duration *= 0.5;
  const SampleOptions whole_state{.every = 4, .position = true, .velocity = true};
  const auto set_and_run = [&](const Eigen::MatrixXd& q, const Eigen::MatrixXd& v,
                               Eigen::Index column, bool foreign) {
    NodeVectors position = network.rest_position;
    NodeVectors velocity = NodeVectors::Zero(3, network.node_count());
    for (const int node : problem.free_nodes()) {
      const Eigen::Index c = problem.coordinate(node);
      position.col(node) = q.col(column).segment<3>(c);
      velocity.col(node) = v.col(column).segment<3>(c);
    }
    Trace trace;
    if (foreign) {
      const std::unique_ptr<Subject> subject = context.make_subject();
      subject->load(half, network, context.skip);
      subject->set_state(position, velocity);
      trace = roll_out(*subject, half, whole_state);
      must_end(trace, outcome);
    } else {
      Scene again = half;
      again.tissue.source = Source::network;
      again.tissue.fixed = std::vector<Face>{};
      again.records[0].where = pulled_node(5);
      SpringNetwork started = network;
      start_from(started, position, velocity);
      trace = roll_out({}, again, &started, whole_state);
    }
    return trace.position;
  };

  std::vector<double> times;
  for (Eigen::Index n = 0; n <= 2 * middle; ++n) {
    times.push_back(static_cast<double>(n) * interval);
  }
  const networks::TruthSettings settings{.tolerance = {.relative = 1e-11}, .demanded_digits = 7.0};
  const networks::Truth truth = networks::find_truth(context, problem, times, settings);
  networks::judge_truth(truth, settings, outcome);
  const Trace& exact = truth.solution;
  const Eigen::MatrixXd second = exact.position.rightCols(middle + 1);
  const auto error_from = [&](bool foreign) {
    return largest_distance(set_and_run(exact.position, exact.velocity, middle, foreign), second,
                            true);
  };
  const double error = error_from(true);
  const double simplest = error_from(false);
  outcome.judge_at_most("error_from_the_state_of_the_reference", error,
                        std::max(2.0 * simplest, single_precision),
                        "twice the error of semi-implicit Euler from the same state, or single "
                        "precision");

  const Trace whole = run_whole(outcome, context, scene, &network, whole_state);
  if (whole.position.cols() <= 2 * middle) { return; }  // it diverged, which fails the case
  outcome.judge_at_most("difference_from_the_whole_run",
                        largest_distance(set_and_run(whole.position, whole.velocity, middle, true),
                                         whole.position.rightCols(middle + 1), true),
                        10.0 * single_precision,
                        "law: the motion depends on the state alone; single precision");
}

void measure_invariance(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_STATE);
  SpringNetwork network = free_block(0.02, 0.05);
  const Scene scene = scene_of(simplest_scheme, 2e-4, 0.04);
  const SampleOptions samples{.every = 20, .position = true};
  const Trace first = run_whole(outcome, context, scene, &network, samples);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(0.03, -0.02, 0.05);
  network.rest_position = (turn * network.rest_position).colwise() + shift;
  network.initial_velocity = turn * network.initial_velocity;
  const Trace second = run_whole(outcome, context, scene, &network, samples);
  Largest difference;
  Largest travel;
  for (Eigen::Index row = 0; row < first.position.cols(); ++row) {
    for (Eigen::Index n = 0; n < network.node_count(); ++n) {
      const Eigen::Vector3d turned = turn * first.position.col(row).segment<3>(3 * n) + shift;
      difference.add((second.position.col(row).segment<3>(3 * n) - turned).norm());
      travel.add((first.position.col(row) - first.position.col(0)).segment<3>(3 * n).norm());
    }
  }
  outcome.judge_at_most("difference_after_turning_back", difference.value() / travel.value(),
                        single_precision, why_single);
}

void measure_rest(const CaseContext& context, Outcome& outcome) {
  Scene scene = s26_scene(5, 1e-3, context.quick ? 0.5 : 2.0);
  scene.loads.clear();
  const Trace trace = run_whole(outcome, context, scene, SampleOptions{.every = 10});
  const Eigen::Vector3d place = build_network(scene).rest_position.col(pulled_node(5));
  Largest motion;
  motion.add((path_of(trace).colwise() - place).colwise().norm().maxCoeff<Eigen::PropagateNaN>());
  outcome.judge_at_most("motion_at_rest", motion.value(), 1e-6,
                        "law: without load nothing moves; some hundred roundings of a coordinate "
                        "of 40 mm in single precision",
                        "m");
}

/// Doubles the step until the subject diverges; then runs the sound scene again.
void measure_stability(const CaseContext& context, Outcome& outcome) {
  if (context.make_subject()->facts().replayed) { throw CannotDo("a trace has one step"); }
  double stable = 0.0;
  for (double step = 1e-3; step < 0.1; step *= 2.0) {
    const Scene scene = s26_scene(5, step, 100.0 * step);
    const Trace trace = roll_out(context, scene, {});
    Largest reach;
    reach.add(path_of(trace).cwiseAbs().maxCoeff<Eigen::PropagateNaN>());
    if (trace.diverged || !(reach.value() < 1.0)) { break; }
    stable = step;
  }
  outcome.judge_at_least("largest_stable_step", stable, 1e-3, "the step of a haptic loop at 1 kHz",
                         "s");
  const Trace again = roll_out(context, s26_scene(5, 1e-3, 0.02), {});
  const NodeVectors path = path_of(again);
  const Eigen::Vector3d begin =
      build_network(s26_scene(5, 1e-3, 0.02)).initial_place(pulled_node(5));
  must_begin_there((path.leftCols<1>() - begin).norm() / begin.norm(), outcome);
  outcome.judge_true("runs_again_after_divergence",
                     !again.diverged && std::isfinite(again.values("tip.z_m").back()) &&
                         path.leftCols<1>() != path.rightCols<1>(),
                     "divergence of one scene does not damage the next");
}

// Audits: what a subject could do to pass without computing.

void measure_renumbered(const CaseContext& context, Outcome& outcome) {
  Scene scene = s26_scene(5, 1e-3, 0.05);
  SpringNetwork network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  const Trace first = run_whole(outcome, context, scene, &network, SampleOptions{});
  const std::vector<int> node_of = renumber(network, scene, 11);
  scene.records[0].where = node_of[static_cast<std::size_t>(pulled_node(5))];
  const Trace second = run_whole(outcome, context, scene, &network, SampleOptions{});
  outcome.judge_at_most(
      "difference_of_order", largest_error(path_of(second), path_of(first)),
      10.0 * single_precision,
      "the order of nodes and springs changes rounding, and for solvers that visit constraints in "
      "order their iterations: a hundredth");
}

/// A scene that no subject has seen: stiffness, viscosity and rest length of every spring, initial
/// state, loaded nodes, loads over time, gravity and order of nodes are drawn. The reference is
/// computed after the subject has run.
void measure_drawn(const CaseContext& context, Outcome& outcome) {
  if (context.make_subject()->facts().replayed) { throw CannotDo("a trace has one scene"); }
  constexpr double interval = 1e-3;
  constexpr std::size_t samples = 51;
  const std::uint64_t seed = context.seed != 0 ? context.seed : std::random_device{}() + 1ULL;
  outcome.notes.push_back("Seed of the scene: " + std::to_string(seed) + "; --seed " +
                          std::to_string(seed) + " repeats it.");
  Random random(seed);
  // Steps at which semi-implicit Euler is one to three per cent off.
  Scene scene = s26_scene(5, 0.125 * interval, 0.05);
  SpringNetwork network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  const double all = std::exp2(std::copysign(random(0.5, 1.0), random(-1.0, 1.0)));
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= all * std::exp2(random(-1.0, 1.0));
    s.viscosity *= std::exp2(random(-1.0, 1.0));
    s.rest_length *= 1.0 + random(-0.02, 0.02);
  });
  const Capabilities can = context.make_subject()->facts().capabilities;
  std::vector<int> free;
  NodeVectors displaced = NodeVectors::Zero(3, network.node_count());
  NodeVectors moving = displaced;
  for (int n = 0; n < network.node_count(); ++n) {
    if (network.is_fixed(n)) { continue; }
    free.push_back(n);
    displaced.col(n) = random.vector(3, 1e-3);
    moving.col(n) = random.vector(3, 0.5);
  }
  if ((can & PALPATE_CAN_INITIAL_STATE) != 0) {
    network.initial_displacement = displaced;
    network.initial_velocity = moving;
  }
  random.shuffle(free);
  // A load that grows, then another, and one on two nodes that ends; gravity where the subject
  // declares it.
  constexpr double change = 0.02;
  const auto draw_force = [&] {
    Eigen::Vector3d force;
    for (double& each : force) { each = std::copysign(random(0.1, 0.2), random(-1.0, 1.0)); }
    return force;
  };
  Load& grows = scene.loads.front();
  grows.nodes = {free.front()};
  grows.force = draw_force();
  grows.profile = Profile::ramp;
  grows.end = change;
  Load later = grows;
  later.force = 2.0 * draw_force();
  later.profile = Profile::constant;
  later.start = change;
  later.end = std::numeric_limits<double>::infinity();
  scene.loads.push_back(later);
  Load passing = later;
  passing.nodes = {free[1], free[2]};
  passing.force = 2.0 * draw_force();
  passing.start = 0.25 * change;
  passing.end = 1.5 * change;
  scene.loads.push_back(passing);
  const Eigen::Vector3d gravity(random(-5.0, 5.0), random(-5.0, 5.0), random(5.0, 15.0));
  if ((can & PALPATE_CAN_GRAVITY) != 0) { scene.tissue.gravity = gravity; }
  const std::vector<int> node_of = renumber(network, scene, seed);
  const int node = node_of[static_cast<std::size_t>(free.front())];
  scene.records[0].where = node;
  const SampleOptions whole_state{.every = 8, .position = true, .velocity = true};
  const Trace found = run_whole(outcome, context, scene, &network, whole_state);

  const NetworkProblem problem = networks::problem_of(scene, network);
  std::vector<double> times;
  for (std::size_t n = 0; n < samples; ++n) { times.push_back(static_cast<double>(n) * interval); }
  const networks::TruthSettings settings{.tolerance = {.relative = 1e-11}, .demanded_digits = 7.0};
  const networks::Truth truth = networks::find_truth({}, problem, times, settings);
  const Trace euler = roll_out({}, scene, &network, whole_state);
  outcome.judge_true("reference_trustworthy", truth.trustworthy, "two families of solvers agree");
  // The numbers differ from seed to seed, so a gate must not compare them.
  const auto judge = [&](const char* name, const std::string& of, double error, double simplest,
                         bool others) {
    outcome.judge_true(name, others && error <= 2.0 * simplest,
                       "at most twice the error of semi-implicit Euler at the same step");
    outcome.notes.push_back("Largest error of the " + of + " of all nodes " + text(error) +
                            "; semi-implicit Euler at the same step " + text(simplest) + ".");
    outcome.timings.push_back({.name = "largest error of the " + of, .value = error, .unit = "1"});
    outcome.timings.push_back(
        {.name = "of semi-implicit Euler, " + of, .value = simplest, .unit = "1"});
  };
  const Trace& exact = truth.solution;
  const auto recorded = [&](const Trace& trace) {
    return largest_error(path_at(trace, interval, samples), path_in(exact, problem, node));
  };
  judge("follows_its_reference", "places", largest_distance(found.position, exact.position, true),
        largest_distance(euler.position, exact.position, true),
        recorded(found) <= 2.0 * recorded(euler));
  if (found.velocity.rows() == 0) { return; }
  judge("velocities_follow_their_reference", "velocities",
        largest_distance(found.velocity, exact.velocity, false),
        largest_distance(euler.velocity, exact.velocity, false), true);
}

void measure_sensitivity(const CaseContext& context, Outcome& outcome) {
  if (context.make_subject()->facts().replayed) { throw CannotDo("a trace has one stiffness"); }
  constexpr double change = 1e-3;
  const auto tips = [&](const CaseContext& with, Subject* subject, bool fine) {
    std::array<std::vector<double>, 2> found;
    for (const bool stiffer : {false, true}) {
      Scene scene = s26_scene(5, 1e-3, 0.05);
      scene.tissue.lattice.stiffness *= stiffer ? 1.0 + change : 1.0;
      if (fine) {
        scene.simulation.integrator = "rk4";
        scene.simulation.substeps = 16;
      }
      SpringNetwork network = build_network(scene);
      if (with.mutation != nullptr && with.mutation->model) {
        with.mutation->model(scene, network);
      }
      Trace trace;
      if (subject != nullptr) {
        subject->load(scene, network, with.skip);
        trace = roll_out(*subject, scene);
        must_end(trace, outcome);
        if (with.mutation != nullptr && with.mutation->trace) { with.mutation->trace(trace); }
      } else {
        trace = roll_out(with, scene, &network, {});
      }
      found[stiffer ? 1 : 0] = trace.values("tip.z_m");
    }
    return found;
  };
  const std::unique_ptr<Subject> subject = context.make_subject();
  const auto seen = tips(context, subject.get(), false);
  const auto exact = tips({}, nullptr, true);
  double scale = 0.0;
  double along = 0.0;
  for (std::size_t n = 0; n < exact[0].size(); ++n) {
    const double wanted = exact[1][n] - exact[0][n];
    scale += wanted * wanted;
    along += wanted * (seen[1][n] - seen[0][n]);
  }
  outcome.judge_near("response_to_stiffness_over_exact", along / scale, 1.0, 0.5,
                     "change of the trajectory for 0.1 % more stiffness, projected on that of RK4; "
                     "a subject that ignores it or answers from a cache gives 0");
}

/// Block whose loads change and, if the subject can, whose nodes move at the start. A reset that
/// leaves anything behind changes its motion.
Scene changing_scene(Capabilities can, SpringNetwork& network) {
  Scene scene = s26_scene(5, 1e-3, 0.1);
  network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  Load later = scene.loads.front();
  const int pulled = later.nodes.front();
  later.nodes = {pulled > 0 && !network.is_fixed(pulled - 1) ? pulled - 1 : pulled + 1};
  later.start = 0.06;
  scene.loads.push_back(later);
  if ((can & PALPATE_CAN_INITIAL_STATE) != 0) {
    Random random(7);
    network.initial_velocity.setZero(3, network.node_count());
    for (int n = 0; n < network.node_count(); ++n) {
      if (!network.is_fixed(n)) { network.initial_velocity.col(n) = random.vector(3, 0.02); }
    }
  }
  return scene;
}

void measure_repeat(const CaseContext& context, Outcome& outcome) {
  const std::unique_ptr<Subject> subject = context.make_subject();
  const SubjectFacts facts = subject->facts();
  if (facts.replayed) { throw CannotDo("a trace cannot be computed again"); }
  SpringNetwork network;
  const Scene scene = changing_scene(facts.capabilities, network);
  const auto again = [&] {
    if (!subject->reset()) { subject->load(scene, network, context.skip); }
  };
  Eigen::Vector3d energy = Eigen::Vector3d::Zero();
  const auto run = [&] {
    Trace trace = roll_out(*subject, scene);
    must_end(trace, outcome);
    if (context.mutation != nullptr && context.mutation->trace) { context.mutation->trace(trace); }
    if ((facts.capabilities & PALPATE_CAN_ENERGY) != 0) { energy = subject->reported_energy(); }
    return trace;
  };
  subject->load(scene, network, context.skip);
  const Trace first = run();
  const Eigen::Vector3d first_energy = energy;
  const bool exact = (facts.capabilities & PALPATE_CAN_REPEAT) != 0;
  const auto judge = [&](const char* name) {
    again();
    const Trace trace = run();
    Largest difference;
    difference.add(largest_error(path_of(trace), path_of(first)));
    Largest whole;
    for (const double part : first_energy) {
      if (!std::isnan(part)) { whole.add(std::abs(part)); }
    }
    for (int n = 0; n < 3; ++n) {
      if (std::isnan(first_energy(n)) && std::isnan(energy(n))) { continue; }  // not accounted for
      const double change = std::abs(energy(n) - first_energy(n));
      if (change != 0.0) { difference.add(change / whole.value()); }
    }
    outcome.judge_at_most(
        name, difference.value(), exact ? 0.0 : single_precision,
        exact ? "the subject declares that reset gives the same bits" : why_single);
    return trace.seconds;
  };
  const double second = judge("difference_after_reset");
  // Reset within a run, while both loads act.
  again();
  for (int n = 0; n < 80; ++n) { (void)subject->step({}); }
  judge("difference_after_reset_within_a_run");
  outcome.timings.push_back(
      {.name = "second run over first", .value = second / first.seconds, .unit = "1"});
}

/// More integration steps within a step bring the motion closer to the reference.
void measure_substeps(const CaseContext& context, Outcome& outcome) {
  const SubjectFacts facts = context.make_subject()->facts();
  if (!has_parameter(facts, "substeps")) {
    throw CannotDo("the subject has no parameter \"substeps\"");
  }
  constexpr double interval = 1e-3;
  constexpr std::size_t samples = 51;
  constexpr int substeps = 4;
  Scene scene = s26_scene(5, interval, 0.05);
  const auto error_with = [&](const CaseContext& with, const Scene& of, const NodeVectors& exact) {
    return largest_error(path_at(run_whole(outcome, with, of, SampleOptions{}), interval, samples),
                         exact);
  };
  Scene fine = scene;
  fine.simulation.integrator = "rk4";
  fine.simulation.substeps = 16;
  const NodeVectors exact = path_at(roll_out({}, fine, SampleOptions{}), interval, samples);
  const double one = error_with(context, scene, exact);
  scene.simulation.substeps = substeps;
  const double several = error_with(context, scene, exact);
  const double order = std::log2(one / several) / std::log2(substeps);
  const bool at_floor = one < single_precision && several != one;
  outcome.judge_at_least("observed_order_or_1_at_the_floor", at_floor ? 1.0 : order, 0.7,
                         "theory: a consistent scheme is of order one at least; from 1 to 4 "
                         "substeps, unless the error is below that of single precision and "
                         "changes with the substeps");
  outcome.report("largest_error_with_1_substep", one);
  outcome.report("largest_error_with_4_substeps", several);
}

void measure_memory(const CaseContext& context, Outcome& outcome) {
  const std::unique_ptr<Subject> subject = context.make_subject();
  if (subject->resident_bytes() == 0) { throw CannotDo("the subject has no process of its own"); }
  const Scene scene = s26_scene(3, 1e-3, 0.5);
  const SpringNetwork network = build_network(scene);
  constexpr int rounds = 16;
  std::vector<double> resident;
  for (int round = 0; round < rounds; ++round) {
    subject->load(scene, network, context.skip);
    (void)roll_out(*subject, scene, {.every = 100});
    resident.push_back(static_cast<double>(subject->resident_bytes()));
  }
  constexpr double mib = 1048576.0;
  const double growth = resident.back() - resident[rounds / 2 - 1];
  // The numbers differ from run to run, so a gate must not compare them.
  outcome.judge_true("no_growth_in_the_last_half", growth <= 8.0 * mib,
                     "at most 8 MiB, once caches and heaps are full, in 8 rounds of loading 27 "
                     "nodes and 500 steps; heaps of interpreters differ by some MiB");
  outcome.notes.push_back("Grows by " + text(growth / mib) + " MiB to " +
                          text(resident.back() / mib) + " MiB in the last half.");
  outcome.timings.push_back({.name = "growth", .value = growth / mib, .unit = "MiB"});
  outcome.timings.push_back({.name = "resident", .value = resident.back() / mib, .unit = "MiB"});
}

// Tools, against the continuum. They hold for any discretisation.

/// Block of gel on a rigid base with free sides.
struct GelBlock {
  double spacing = 0.005;     ///< [m]
  double half_width = 0.045;  ///< [m]
  double thickness = 0.045;   ///< [m]
};
constexpr double gel_modulus = 1e4;  // [Pa]

Material gel(const char* name, double modulus) {
  Material material = tools::tissue_of(name, modulus, 50.0, 10.0);
  material.damping_ratio = 0.0;
  material.retardation_time = 2e-3;
  return material;
}

int cells(double length, double spacing) { return static_cast<int>(std::lround(length / spacing)); }

/// Gel, pressed to a depth in steps that end at rest.
Scene gel_scene(const GelBlock& block) {
  const int across = 2 * cells(block.half_width, block.spacing) + 1;
  Scene scene;
  scene.tissue.source = Source::lattice;
  scene.tissue.fixed = {Face::z_max};
  scene.tissue.lattice = {.nodes = {across, across, cells(block.thickness, block.spacing) + 1},
                          .spacing = block.spacing,
                          .material = "gel"};
  scene.materials = {gel("gel", gel_modulus)};
  scene.simulation = {.duration = 0.6, .step = 1e-3, .integrator = "implicit-euler"};
  return scene;
}

/// Force of a tool at rest over its depth.
struct ToolReference {
  double stiffness = 0.0;    ///< [N/m]
  double uncertainty = 0.0;  ///< expanded, relative [1]
  std::string from{};
};

/// Force over depth of the tool at rest, by the model of this project [N/m].
double model_stiffness(Scene scene, double depth) {
  scene.drive = Drive{.speed = depth / 0.1, .depth = depth, .hold = 1.0};
  // Steps that are long against the periods of the gel: each reduces the motion to a hundredth.
  scene.simulation = {.duration = 0.4, .step = 0.1, .integrator = "implicit-euler"};
  return roll_out({}, scene, SampleOptions{}).values("tool.force_n").back() / depth;
}

/// Rigid flat punch of radius a on a layer, and the effect of the free sides of the block: twice
/// the change with two thirds more width, on a coarse grid.
template <class Press>
ToolReference continuum(const GelBlock& block, double radius, double depth, Press press) {
  constexpr double poisson = 0.25;
  const double spacing = block.thickness / 5.0;
  const auto on = [&](double half_width) {
    Scene scene =
        gel_scene({.spacing = spacing, .half_width = half_width, .thickness = block.thickness});
    press(scene);
    return model_stiffness(scene, depth);
  };
  const double sides = on(5.0 / 3.0 * block.half_width) / on(block.half_width) - 1.0;
  const reference::PunchFactor factor =
      reference::punch_on_layer(radius / block.thickness, poisson);
  return {.stiffness = factor.kappa * 2.0 * gel_modulus * radius / (1.0 - poisson * poisson),
          .uncertainty = factor.uncertainty / factor.kappa + 2.0 * std::abs(sides),
          .from =
              "closed form: rigid flat punch, 2 E a / (1 - nu^2), on a layer (Hayes et al. "
              "1972), for a block with free sides"};
}

/// Judges the force of a tool at rest over its depth.
void judge_tool(Outcome& outcome, const std::string& name, double stiffness,
                const ToolReference& reference) {
  outcome.report(name + "_uncertainty_of_the_reference", reference.uncertainty);
  outcome.judge_near(
      name + "_over_reference", stiffness / reference.stiffness, 1.0, 0.1 + reference.uncertainty,
      "a finger resolves a tenth of stiffness; and the uncertainty of the reference, " +
          text(reference.uncertainty) + ": " + reference.from);
}

/// Mean force over the last tenth of a run [N].
double last_force(const Trace& trace) {
  const std::vector<double>& force = trace.values("tool.force_n");
  const std::size_t count = std::max<std::size_t>(1, force.size() / 10);
  double sum = 0.0;
  for (std::size_t n = force.size() - count; n < force.size(); ++n) { sum += force[n]; }
  return sum / static_cast<double>(count);
}

/// Judges what a tool on the axis of a block tells beside its force, as far as the subject has it.
/// The tool moves at a constant velocity or rests from `from` to `to` [s].
void judge_outputs(Outcome& outcome, const std::string& name, const Trace& trace, double from,
                   double to) {
  const std::vector<double>& force = trace.values("tool.force_n");
  Largest peak;
  for (const double each : force) { peak.add(std::abs(each)); }
  const auto judge = [&](const std::string& what, double scale, const std::string& why,
                         const auto& off) {
    Largest largest;
    for (std::size_t n = 1; n < trace.rows(); ++n) {
      if (trace.time[n] >= from && trace.time[n] <= to) { largest.add(std::abs(off(n))); }
    }
    outcome.judge_at_most(name + what, largest.value() / scale, 0.02, why);
  };
  const auto has = [&](const char* column) {
    return std::ranges::any_of(trace.values(column), [](double v) { return std::isfinite(v); });
  };
  if (has("tool.lateral_n")) {
    judge("_lateral_force_over_peak", peak.value(), "symmetry: none on the axis of a block; 2 %",
          [&](std::size_t n) { return trace.values("tool.lateral_n")[n]; });
  }
  judge("_applied_force_off", peak.value(),
        "law: what holds a tool that does not accelerate is the force on it; 2 %",
        [&](std::size_t n) { return trace.values("tool.applied_n")[n] - force[n]; });
  const std::vector<double>& place = trace.values("tool.insertion_m");
  const double speed = std::abs(place.back() - place.front()) / (trace.time.back() - trace.time[0]);
  judge("_velocity_off", speed, "definition: change of the place over time; 2 % of the mean",
        [&](std::size_t n) {
          return trace.values("tool.velocity_m_per_s")[n] -
                 (place[n] - place[n - 1]) / (trace.time[n] - trace.time[n - 1]);
        });
}

void measure_needle(const CaseContext& context, Outcome& outcome) {
  const GelBlock block{.half_width = 0.04, .thickness = 0.04};
  const auto press = [](Scene& scene) { scene.needle = Needle{.diameter = 2.1e-3}; };
  Scene scene = gel_scene(block);
  press(scene);
  constexpr double depth = 0.5e-3;
  scene.drive = Drive{.speed = 0.005, .depth = depth, .hold = 10.0};
  const Trace pressed = run_whole(outcome, context, scene, SampleOptions{});
  const ToolReference punch = continuum(block, 1.05e-3, depth, press);
  judge_tool(outcome, "stiffness_before_puncture", last_force(pressed) / depth, punch);

  // Cut at a constant force, with friction along the shaft in the tissue, then drawn back.
  constexpr double cutting = 0.01;  // [N]
  constexpr double friction = 0.5;  // [N/m]
  scene.materials[0].cutting_force = cutting;
  scene.materials[0].friction = friction;
  scene.drive = Drive{.speed = 0.02, .depth = 0.015, .hold = 0.05, .withdraw_speed = 0.02};
  scene.simulation.duration = 1.25;
  const Trace cut = run_whole(outcome, context, scene, SampleOptions{.tool = true});
  judge_outputs(outcome, "cutting", cut, 0.5, 0.74);
  Largest error;
  const auto& force = cut.values("tool.force_n");
  const auto& depths = cut.values("tool.depth_m");
  for (std::size_t n = 0; n < cut.rows(); ++n) {
    if (cut.time[n] < 0.5 || cut.time[n] > 0.74) { continue; }
    error.add(std::abs(force[n] / (cutting + friction * depths[n]) - 1.0));
  }
  const double dragged = friction / punch.stiffness;
  outcome.judge_at_most(
      "error_of_cutting_and_friction", error.value(), dragged + 0.02,
      "law: a needle that cuts feels its cutting force and its friction times "
      "its length. The force F drags the tissue by at most F over the stiffness "
      "before the puncture, which shortens that length: friction over stiffness, " +
          text(dragged) + ", and 2 % for simulators that regularise the law");
  Largest back;
  for (std::size_t n = 0; n < cut.rows(); ++n) {
    if (cut.time[n] < 1.0 || cut.time[n] > 1.25) { continue; }
    back.add(std::abs(force[n] / (friction * depths[n]) + 1.0));
  }
  outcome.judge_at_most("error_of_friction_drawn_back", back.value(), dragged + 0.02,
                        "law: friction times the length of the shaft in the tissue, against the "
                        "motion; the dragged tissue and 2 %, as above");
  const auto& cut_to = cut.values("tool.cut_m");
  if (std::ranges::none_of(cut_to, [](double v) { return std::isfinite(v); })) { return; }
  Largest fall;
  double deepest = 0.0;
  for (const double to : cut_to) {
    if (!std::isfinite(to)) { continue; }
    deepest = std::max(deepest, to);
    fall.add(deepest - to);
  }
  outcome.judge_at_most("fall_of_the_cut", fall.value(), 1e-6,
                        "definition: the largest insertion to which the tissue was cut so far",
                        "m");
  Largest ahead;
  Smallest behind;
  for (std::size_t n = 0; n < cut.rows(); ++n) {
    if (cut.time[n] < 0.5 || cut.time[n] > 0.74) { continue; }
    const double dent = depths[n] - cut_to[n];
    ahead.add(dent * punch.stiffness / force[n]);
    behind.add(dent);
  }
  outcome.judge_at_most("dent_over_that_of_its_force", ahead.value(), 1.25,
                        "law: the tip is ahead of the cut by the dent of the tissue, at most that "
                        "of the whole force on the surface; a quarter more");
  outcome.judge_at_least("dent_of_the_tissue", behind.value(), -1e-6,
                         "law: the tissue is not cut in front of the tip", "m");
}

void measure_probe(const CaseContext& context, Outcome& outcome) {
  const GelBlock block;
  const auto press = [](Scene& scene) { scene.probe = Probe{.size = {0.01, 0.01}}; };
  Scene scene = gel_scene(block);
  press(scene);
  constexpr double depth = 0.3e-3;
  scene.drive = Drive{.speed = 0.005, .depth = depth, .hold = 10.0};
  const Trace trace = run_whole(outcome, context, scene, SampleOptions{.tool = true});
  judge_outputs(outcome, "resting", trace, 0.5, 0.6);
  judge_tool(outcome, "stiffness", last_force(trace) / depth,
             continuum(block, 0.005, depth, press));
}

/// Disc that a force pushes, and disc that a hand holds through a spring and damper. Force and hand
/// move evenly for 0.3 s, then rest.
void measure_moved(const CaseContext& context, Outcome& outcome) {
  require(context, PALPATE_CAN_PROBE);
  const GelBlock block;
  const auto press = [](Scene& scene) { scene.probe = Probe{.size = {0.01, 0.01}, .mass = 0.01}; };
  const ToolReference reference = continuum(block, 0.005, 0.3e-3, press);
  Scene scene = gel_scene(block);
  press(scene);
  const auto judge = [&](const std::string& name) {
    const Trace trace = run_whole(outcome, context, scene, SampleOptions{.tool = true});
    judge_outputs(outcome, name + "_and_moving", trace, 0.2, 0.29);
    judge_outputs(outcome, name + "_and_resting", trace, 0.5, 0.6);
    judge_tool(outcome, name + "_stiffness",
               last_force(trace) / trace.values("tool.insertion_m").back(), reference);
    return trace.values("tool.applied_n").back();
  };
  constexpr double pushing = 0.03;  // [N]
  scene.drive = Drive{.kind = Drive::Kind::force,
                      .hold = 10.0,
                      .force = pushing,
                      .rise = 0.3,
                      .hand_viscosity = 0.2};
  outcome.judge_near("applied_over_pushing", judge("pushed") / pushing, 1.0, 0.02,
                     "law: at rest the hand's viscosity takes nothing from its force; 2 %");
  constexpr double way = 0.4e-3;  // [m]
  scene.drive = Drive{.kind = Drive::Kind::recorded,
                      .grip = std::make_shared<const std::vector<GripSample>>(
                          std::vector<GripSample>{{0.0, 0.0, way / 0.3}, {0.3, way, way / 0.3}})};
  scene.falcon = FalconDrive{.coupling_stiffness = 200.0, .coupling_viscosity = 2.0};
  const double series = 1.0 / (1.0 / 200.0 + 1.0 / reference.stiffness);
  outcome.judge_near("applied_over_that_of_two_springs", judge("held") / (way * series), 1.0,
                     0.1 + reference.uncertainty,
                     "law: the spring of the hand and the gel in series; as the stiffness");
}

/// Disc on a stiff layer over a soft one, for which there is no closed form.
Scene layered_scene(double spacing) {
  const int across = 2 * cells(0.03, spacing) + 1;
  Scene scene = gel_scene({});
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {across, across}, .spacing = spacing, .connectivity = 26};
  scene.materials = {gel("firm", 3.0 * gel_modulus), gel("soft", gel_modulus)};
  scene.tissue.layers = {{"firm", "firm", 0.01}, {"soft", "soft", 0.02}};
  scene.probe = Probe{.size = {0.015, 0.015}};
  return scene;
}

void measure_layered(const CaseContext& context, Outcome& outcome) {
  constexpr double depth = 0.3e-3;
  Scene scene = layered_scene(0.005);
  scene.drive = Drive{.speed = 0.005, .depth = depth, .hold = 10.0};
  const double found = last_force(run_whole(outcome, context, scene, SampleOptions{})) / depth;
  const std::vector<double> spacings{0.01, 0.01 / 2.0, 0.01 / 3.0};
  std::vector<double> stiffness;
  Table& table =
      outcome.table("grids", "Reference: stiffness on three grids",
                    "Disc of 15 mm on 10 mm of 30 kPa over 20 mm of 10 kPa, by the model "
                    "of this project at rest.",
                    {"spacing (mm)", "stiffness (N/m)"});
  for (const double spacing : spacings) {
    stiffness.push_back(model_stiffness(layered_scene(spacing), depth));
    table.rows.push_back({1e3 * spacing, stiffness.back()});
  }
  judge_tool(outcome, "stiffness", found,
             {.stiffness = stiffness.back(),
              .uncertainty = grid_convergence(spacings, stiffness).index,
              .from = "the model on three grids, grid convergence index (Roache 1998)"});
}

/// Times of the steps of one run; empty if the subject diverges at once, or ends with a state that
/// is not finite [s].
struct StepTimes {
  std::vector<double> steps{};
  std::vector<double> empty{};  ///< round trips of empty calls
};

StepTimes time_steps(Subject& subject) {
  StepTimes times;
  for (long n = 0; n < subject.tick_count(); ++n) {
    const auto begin = std::chrono::steady_clock::now();
    const StepStatus status = subject.step({});
    const double around =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (const std::string failure = subject.failure(); !failure.empty()) {
      throw SubjectFailure(failure);
    }
    if (status == StepStatus::diverged) { break; }
    times.steps.push_back(subject.step_seconds().value_or(around));
    times.empty.push_back(subject.round_trip());
  }
  if (!subject.has_finite_state()) { return {}; }
  return times;
}

/// Time of a step of S26 blocks, as the subject's host measures it. The block is loaded several
/// times, because its place in memory changes the time; the run with the least median counts.
void measure_cost(const CaseContext& context, Outcome& outcome) {
  constexpr int runs = 9;
  constexpr double enough = 2.0;  // seconds for the runs of a block
  Table& table = outcome.table(
      "cost", "Time of a step",
      "S26 blocks at steps of 1 ms: time of each step, of the run with the least median of up to " +
          std::to_string(runs) +
          ". Over a pipe it includes the round trip, of which the empty call is a control.",
      {"nodes", "springs", "median (us)", "99 % (us)", "slowest (us)", "ns a spring",
       "empty call (us)"});
  table.timing = true;
  Smallest steps;
  for (const int nodes : context.quick ? std::vector{5, 10} : std::vector{5, 10, 20}) {
    const Scene scene = s26_scene(nodes, 1e-3, 0.2);
    const SpringNetwork network = build_network(scene);
    StepTimes best;
    double median = std::numeric_limits<double>::infinity();
    try {
      double spent = 0.0;
      for (int run = 0; run < runs && spent < enough; ++run) {
        const std::unique_ptr<Subject> subject = context.make_subject();
        subject->load(scene, network, context.skip);
        StepTimes times = time_steps(*subject);
        steps.add(static_cast<double>(times.steps.size()));
        if (times.steps.empty()) { continue; }
        spent += std::accumulate(times.steps.begin(), times.steps.end(), 0.0);
        const double middle = comparison::quantile(times.steps, 0.5);
        if (middle >= median) { continue; }
        median = middle;
        best = std::move(times);
      }
    } catch (const CannotDo& reason) {
      outcome.notes.push_back(std::to_string(nodes) + " nodes a side: " + reason.what());
      continue;
    }
    if (best.steps.empty()) { continue; }
    const auto springs = static_cast<double>(network.springs.size());
    table.rows.push_back({nodes * nodes * nodes, springs, 1e6 * median,
                          1e6 * comparison::quantile(best.steps, 0.99),
                          1e6 * *std::ranges::max_element(best.steps), 1e9 * median / springs,
                          1e6 * comparison::quantile(best.empty, 0.5)});
    outcome.timings.push_back(
        {.name = "step_of_" + std::to_string(nodes * nodes * nodes) + "_nodes",
         .value = 1e6 * median,
         .unit = "us"});
  }
  outcome.judge_at_least("steps_taken", steps.value(), 200.0,
                         "every step of every block is taken, none diverges");
}

Case any(std::string name, std::string suite, std::string claim,
         void (*measure)(const CaseContext&, Outcome&), double weight) {
  return {.name = "subject/" + std::move(name),
          .suite = std::move(suite),
          .claim = std::move(claim),
          .measure = measure,
          .weight = weight,
          .any_subject = true};
}

/// Never kept: it draws another scene in every run.
Case drawn() {
  Case one = any("audit/drawn", "accuracy",
                 "A scene that is made up at run time is simulated like the known ones.",
                 measure_drawn, 0.5);
  one.keeps = false;
  return one;
}

}  // namespace

Case cost_case() {
  return {.name = "bench/subject",
          .suite = "timing",
          .claim = "Time of a step of the simulator under test, on blocks of springs.",
          .measure = measure_cost,
          .any_subject = true};
}

std::vector<Case> cases() {
  return {
      any("s26", "accuracy",
          "The pulled node of the agreed block of 1000 masses follows the reference, and a smaller "
          "step brings it closer.",
          measure_s26, 3.0),
      any("first-step", "accuracy", "A load acts in the first step, on the mass of its node.",
          measure_first_step, 0.1),
      any("static", "accuracy",
          "A damped block under a constant load rests at its static solution.", measure_static,
          0.5),
      any("patch", "accuracy",
          "The inside of a block follows an affine displacement of its surface (patch test).",
          measure_patch, 0.3),
      any("chain", "accuracy", "A fixed-free chain oscillates in its first mode as in closed form.",
          measure_chain, 0.1),
      any("damping", "accuracy",
          "A damped chain loses the amplitude of its first mode as in closed form.",
          measure_damping, 0.1),
      any("fixed-nodes", "accuracy", "Fixed nodes never move, wherever they are in the list.",
          measure_fixed_nodes, 0.1),
      any("momentum", "accuracy", "Springs and dampers between free masses keep their momentum.",
          measure_momentum, 0.2),
      any("energy", "stability", "An undamped block gains no energy in a thousand steps.",
          measure_energy, 0.2),
      any("energy-report", "accuracy",
          "The energies that a subject reports are those of its state, and nothing is lost.",
          measure_reported_energy, 0.1),
      any("set-state", "accuracy",
          "From the state of the reference, and from its own, a run goes on as it did.",
          measure_set_state, 0.4),
      any("invariance", "accuracy", "A block that is turned and moved behaves the same.",
          measure_invariance, 0.2),
      any("rest", "stability", "Tissue without load stays where it is.", measure_rest, 0.2),
      any("stability", "stability",
          "Steps of 1 ms are stable, and a diverged scene does not damage the next.",
          measure_stability, 0.3),
      any("audit/renumbered", "accuracy", "The order of nodes and springs changes nothing.",
          measure_renumbered, 0.2),
      any("audit/stiffness", "accuracy", "A stiffness that is changed by 0.1 % changes the motion.",
          measure_sensitivity, 0.3),
      drawn(),
      any("audit/repeat", "stability",
          "The same scene again gives the same answer, computed again.", measure_repeat, 0.2),
      any("audit/substeps", "accuracy",
          "Integration steps within a step bring the motion closer to the reference.",
          measure_substeps, 0.2),
      any("audit/memory", "stability", "Loading and stepping again and again takes no more memory.",
          measure_memory, 0.3),
      any("needle", "haptics",
          "A needle on gel feels a rigid punch before it cuts, then its cutting force and "
          "friction.",
          measure_needle, 3.0),
      any("probe", "haptics", "A rigid disc on gel feels the force of the continuum.",
          measure_probe, 3.0),
      any("moved", "haptics",
          "A disc that a force pushes or a hand holds comes to rest where gel and hand balance.",
          measure_moved, 4.0),
      any("layered", "haptics",
          "A rigid disc on a firm layer over a soft one feels the force of the refined model.",
          measure_layered, 8.0)};
}

}  // namespace palpate::subjects

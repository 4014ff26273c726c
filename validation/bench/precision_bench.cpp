// SPDX-License-Identifier: MIT
/// A scene computed by the model, and by solvers of other libraries.

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "model/kernels/list_network.hpp"
#include "model/problem/problem.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/exact_problems.hpp"
#include "reference/insertion.hpp"
#include "reference/solution.hpp"
#include "reference/solvers.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/timing.hpp"
#include "validation/bench/work_precision.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

namespace palpate::bench {

namespace {

/// Network problem whose forces come from the list kernel of the model, for a fair run time.
class QuickProblem final : public reference::DerivedProblem {
 public:
  explicit QuickProblem(const NetworkProblem& plain)
      : DerivedProblem(plain),
        system_(plain, {}, 1.0, true),
        q_(plain.dof()),
        v_(plain.dof()),
        f_(plain.dof()) {}
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    q_ = q;
    v_ = v;
    system_.force(t, gate, q_, v_, f_);
    f = f_;
  }

 private:
  mutable ListNetwork<double> system_;
  mutable Eigen::VectorXd q_, v_, f_;
};

/// Instants of the ticks, the first 0 [s].
std::vector<double> instants_of(const Scene& scene) {
  const double step = scene.simulation.step;
  return tick_times(step, std::lround(scene.simulation.duration / step));
}

/// Solver of a scene without a tool. The time of a solution is the wall time of the integration, or
/// less if other processes used the processor. A solver that fails gives a diverged trace.
class PointSolver {
 public:
  explicit PointSolver(const Scene& scene)
      : plain_(make_problem(scene)), instants_(instants_of(scene)) {
    network_ = dynamic_cast<const NetworkProblem*>(plain_.get());
    if (network_ != nullptr) { quick_ = std::make_unique<QuickProblem>(*network_); }
  }

  /// Returns the position of a node, or of the mass of an oscillator.
  [[nodiscard]] Signal signal_of(int node) const {
    return network_ != nullptr ? Signal{network_->coordinate(node), 3} : Signal{0, 1};
  }

  [[nodiscard]] Trace solve(const std::string& solver,
                            const reference::Tolerance& tolerance) const {
    try {
      const Problem& problem = quick_ ? *quick_ : *plain_;
      const double begin = seconds_on(Clock::processor);
      Trace run = reference::solver_named(solver).solve(problem, instants_, tolerance);
      run.seconds = std::min(seconds_on(Clock::processor) - begin, run.seconds);
      Column energy{.name = "energy_j", .unit = "J"};
      for (Eigen::Index n = 0; n < run.position.cols(); ++n) {
        energy.values.push_back(plain_->energy(run.position.col(n), run.velocity.col(n)));
      }
      run.columns.push_back(std::move(energy));
      return run;
    } catch (const reference::SolverError&) { return {.diverged = true}; }
  }

 private:
  std::unique_ptr<Problem> plain_;
  const NetworkProblem* network_ = nullptr;  ///< nullptr for an oscillator
  std::unique_ptr<Problem> quick_{};         ///< networks only
  std::vector<double> instants_;
};

/// Solves a scene with a needle with CVODE and root finding for events. The events of the trace are
/// those at which the force jumps.
Trace solve_needle(const Scene& scene, double tolerance) {
  const SpringNetwork network = build_network(scene);
  const double begin = seconds_on(Clock::processor);
  Trace run =
      reference::solve_insertion(scene, network, instants_of(scene), {.relative = tolerance});
  run.seconds = std::min(seconds_on(Clock::processor) - begin, run.seconds);
  std::erase_if(run.events, [](const Event& event) { return event.kind == "knot-passed"; });
  return run;
}

/// Ticks within two of an event.
std::vector<bool> jumps_of(const Trace& run, double step) {
  std::vector<bool> jumps;
  for (const double time : run.time) {
    jumps.push_back(std::ranges::any_of(
        run.events, [&](const Event& event) { return std::abs(time - event.time) <= 2.0 * step; }));
  }
  return jumps;
}

/// Adds the truth and the solvers of a scene without a tool. The two references share no method.
void observe_point(Study& study, int node, const std::array<const char*, 2>& references) {
  const auto point = std::make_shared<PointSolver>(study.scene);
  const reference::Tolerance tight{
      .relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  study.truth = truth_of(point->solve(references[0], tight), point->solve(references[1], tight),
                         point->signal_of(node));
  study.there = [point, travel = study.truth.travel, duration = study.scene.simulation.duration](
                    const std::string& solver, double tolerance) {
    return point->solve(
        solver,
        {.relative = tolerance, .position_scale = travel, .velocity_scale = travel / duration});
  };
}

/// Adds the truth and the solver of a scene with a needle; ticks at jumps of the force are left
/// out.
void observe_needle(Study& study, double finest) {
  Trace truth = solve_needle(study.scene, finest);
  std::vector<bool> jumps = jumps_of(truth, study.scene.simulation.step);
  study.truth = truth_of(std::move(truth), solve_needle(study.scene, 1e-8), {}, std::move(jumps));
  study.there = [scene = study.scene](const std::string&, double tolerance) {
    return solve_needle(scene, tolerance);
  };
}

/// The paper's lightest damping (its Figs. 6-10): m = k = 1, c = 0.1, some four periods.
Study oscillator_study() {
  Study study;
  study.tool = "the mass";
  study.scene.simulation = {.duration = 25.0, .step = 0.25};
  study.scene.tissue.source = Source::oscillator;
  observe_point(study, 0, {"modal", "arkode-fehlberg-7-8"});
  return study;
}

/// A cube with 26 neighbours and one pulled node; not stiff, so solvers with matrices have no part
/// in it.
Study cube_study(int nodes_a_side) {
  Study study;
  study.scene = s26_scene(nodes_a_side);
  study.tool = "the pulled node";
  observe_point(study, study.scene.loads.front().nodes.front(),
                {"arkode-fehlberg-7-8", "cvode-adams"});
  return study;
}

/// Seven layers with moduli that explicit schemes can follow, at 20 mm/s.
Study needle_study(double duration, double finest) {
  Study study;
  study.scene = tools::seven_soft_layers();
  study.tool = "the force on the hand, but within two ticks of an event";
  study.scene.simulation = {.duration = duration, .step = 1e-3};
  observe_needle(study, finest);
  return study;
}

Quantity floor_of(const Study& study) {
  return {.name = "floor_of_the_reference",
          .value = study.truth.floor,
          .upper = 1e-5,
          .bound_from = "a tenth of the smallest error that is required"};
}

// Error against run time on four scenes: one spring, a soft cube, seven layers under a needle, a
// stiff ligament.

/// All schemes except the printed Feynman-Newton, which is an erratum.
const std::vector<std::string> all_schemes{"euler",          "euler-cromer",     "feynman-newton",
                                           "leapfrog",       "velocity-verlet",  "rk4",
                                           "implicit-euler", "implicit-midpoint"};
const std::vector<std::string> explicit_solvers{"cvode-adams", "arkode-dormand-prince-5-4",
                                                "gsl-rk8pd", "odeint-dormand-prince-5-4"};

/// Allowed error at the tool, relative to the peak (docs/scenes.md).
constexpr double automatic_promise = 0.02;

/// Requirements for one scene.
struct Demand {
  double times_cheaper = 0.0;  ///< than others at a thousandth of the peak; 0: nothing
  /// At the end of S26: what semi-implicit Euler of any engine has (5.7338e-4 m for 5.7313e-4 m),
  /// to two digits.
  double error_at_end = unbounded;
};

/// Errors of "auto", and of semi-implicit Euler with one step per tick, the setting of the kernel
/// timings.
void judge_end(const std::vector<Point>& points, double most, Outcome& outcome) {
  for (const Point& p : points) {
    const bool timed = p.method.starts_with("euler-cromer") && p.setting == "1 substep";
    if (p.far_field) { continue; }
    if (!timed && p.kind != Point::Kind::automatic) { continue; }
    outcome.judge_at_most(
        "error_at_end_" + std::string(p.kind == Point::Kind::automatic  ? "auto"
                                      : p.kind == Point::Kind::in_float ? "float"
                                                                        : "double"),
        p.errors.tool_at_end, most,
        "what semi-implicit Euler of other engines has after 0.1 s, 4.3e-4");
  }
}

void judge(const CaseContext& context, const Study& study, const Demand& demand, Outcome& outcome) {
  const std::vector<Point> points =
      measure_points(context, study, context.quick ? 0.1 : 0.6, context.quick ? 2 : 5);
  outcome.judge(floor_of(study));
  outcome.judge_at_most("auto_over_quickest_as_accurate", automatic_over_best(points),
                        noise_of(points),
                        "integrator = \"auto\" is on the frontier: the least of its run times over "
                        "the median of any setting in double that is as near, apart by no more "
                        "than least and median of one setting are in this table, or a tenth");
  outcome.judge_at_most("error_of_auto", largest_error_of_automatic(points), automatic_promise,
                        "what docs/scenes.md promises of integrator = \"auto\"");
  if (demand.times_cheaper > 0.0) {
    const Point* here = cheapest(points, 1e-3, true);
    const Point* there = cheapest(points, 1e-3, false);
    outcome.judge_at_least(
        "elsewhere_over_here_at_1e-3",
        here != nullptr && there != nullptr ? there->seconds / here->seconds : std::nan(""),
        demand.times_cheaper,
        "asked of the project: so many times cheaper than the best of SUNDIALS, GSL and odeint");
  }
  if (std::isfinite(demand.error_at_end)) { judge_end(points, demand.error_at_end, outcome); }
  add_tables(points, study, outcome);
  add_figures(points, study, outcome);
}

void measure_oscillator(const CaseContext& context, Outcome& outcome) {
  Study study = oscillator_study();
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = 256;
  judge(context, study, {}, outcome);
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  Study study = cube_study(10);
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = context.quick ? 4 : 64;
  study.scene.simulation.substeps.reset();
  // Two and a half spacings; what its shapes lack is then half of what RK4 is off with one substep.
  study.reduction = {.near_radius = 0.025, .far_modes = 24};
  study.schemes_of_reduction = {"euler-cromer", "velocity-verlet", "rk4"};
  judge(context, study, {.times_cheaper = 20.0, .error_at_end = 4.35e-4}, outcome);
}

/// A block of ligament with its published modulus: explicit schemes take some ten microseconds a
/// step.
void measure_ligament(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.tool = "the pushed node";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.solvers.emplace_back("cvode-bdf");
  if (!context.quick) { study.solvers.emplace_back("arkode-esdirk-5-4"); }
  study.most_substeps = context.quick ? 128 : 512;
  study.scene.simulation = {.duration = 0.02, .step = 1e-3};
  study.scene.tissue.lattice = {
      .nodes = {6, 6, 6}, .spacing = 0.002, .material = "interspinous-ligament"};
  study.scene.materials = {{.name = "interspinous-ligament",
                            .youngs_modulus = 10e6,
                            .density = 1130.0,
                            .damping_ratio = 0.5}};
  constexpr int node = 3 * 6 + 3;
  study.scene.loads = {
      {.nodes = {node}, .force = {0.0, 0.0, 0.5}, .end = 0.015, .profile = Profile::half_sine}};
  observe_point(study, node, {"arkode-fehlberg-7-8", "cvode-bdf"});
  judge(context, study, {}, outcome);
}

void measure_needle(const CaseContext& context, Outcome& outcome) {
  Study study = needle_study(context.quick ? 0.15 : 0.45, 1e-10);
  study.schemes = all_schemes;
  // They have velocities at half steps, which a tool cannot use.
  std::erase(study.schemes, "leapfrog");
  std::erase(study.schemes, "feynman-newton");
  study.solvers = {"cvode-adams with events as roots"};
  study.most_substeps = context.quick ? 64 : 256;
  judge(context, study, {}, outcome);
}

// Cost of accuracy in force evaluations, which are the same on every machine, so that a gate can
// compare them.

/// Points of four explicit schemes with 1, 2, 4 ... substeps, without run times.
std::vector<Point> count_points(const CaseContext& context, const Study& study) {
  std::vector<Point> points;
  for (const char* scheme : {"euler", "euler-cromer", "velocity-verlet", "rk4"}) {
    for (int substeps = study.least_substeps; substeps <= study.most_substeps; substeps *= 2) {
      Scene scene = study.scene;
      scene.simulation.integrator = scheme;
      scene.simulation.substeps = substeps;
      const Trace run = run_here(context, scene);
      const Errors errors = errors_of(run, study.truth);
      if (!(errors.tool < 1.0)) { continue; }
      points.push_back({.method = scheme, .evaluations = run.evaluations, .errors = errors});
      if (errors.tool < 10.0 * study.truth.floor) { break; }
    }
  }
  return points;
}

/// `costs` are the numbers of evaluations for which digits are reported.
void count(const CaseContext& context, const Study& study, const std::vector<double>& costs,
           Outcome& outcome) {
  const std::vector<Point> points = count_points(context, study);
  outcome.judge(floor_of(study));
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    outcome.report("evaluations_at_" + plain_number(error) + "_of_the_peak", cost_at(points, error),
                   "evaluations");
  }
  for (const double cost : costs) {
    outcome.report("digits_after_" + plain_number(cost, 6) + "_evaluations",
                   digits_at(points, cost), "digits");
  }
  Table& table = outcome.tables.emplace_back(
      Table{.id = "efforts",
            .title = "Evaluations and errors",
            .caption = "The largest error at the tool over its peak.",
            .columns = {"scheme", "evaluations of the force", "error"}});
  for (const Point& each : points) {
    table.rows.push_back({each.method, static_cast<double>(each.evaluations), each.errors.tool});
  }
}

}  // namespace

std::vector<Case> precision_cases() {
  const auto named = [](const std::string& scene, const std::string& claim,
                        void (*measure)(const CaseContext&, Outcome&)) {
    return Case{"bench/precision/" + scene, "timing", claim, measure, 60.0};
  };
  return {
      named(
          "oscillator",
          "On one spring, nothing in double is both quicker and nearer than what \"auto\" chooses.",
          measure_oscillator),
      named("cube",
            "The pulled cube of 1000 nodes is computed to a thousandth of its peak at a small part "
            "of what the best solver of another library takes for it, and \"auto\" is on the "
            "frontier.",
            measure_cube),
      named("needle",
            "Of seven layers under a needle, nothing in double is both quicker and nearer than "
            "what \"auto\" chooses.",
            measure_needle),
      named("ligament",
            "Of a stiff ligament, nothing in double is both quicker and nearer than what \"auto\" "
            "chooses.",
            measure_ligament)};
}

std::vector<Case> frontier_cases() {
  const auto named = [](const std::string& scene, void (*measure)(const CaseContext&, Outcome&)) {
    return Case{"bench/frontier/" + scene, "timing",
                "What an error costs in evaluations of the force, and what they buy, is known to a "
                "tenth of the smallest error that is asked for.",
                measure, 10.0};
  };
  return {named("oscillator",
                [](const CaseContext& context, Outcome& outcome) {
                  count(context, oscillator_study(), {400.0, 1600.0}, outcome);
                }),
          named("cube",
                [](const CaseContext& context, Outcome& outcome) {
                  count(context, cube_study(6), {400.0, 1600.0}, outcome);
                }),
          named("needle", [](const CaseContext& context, Outcome& outcome) {
            Study study = needle_study(0.15, 1e-9);
            study.least_substeps = 8;
            count(context, study, {2400.0, 9600.0}, outcome);
          })};
}

}  // namespace palpate::bench

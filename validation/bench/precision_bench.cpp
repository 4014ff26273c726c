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
#include "model/stepping/integrator.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/insertion.hpp"
#include "reference/solution.hpp"
#include "reference/solvers.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/timing.hpp"
#include "validation/bench/work_precision.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/roll_out.hpp"

namespace palpate::bench {

/// Instants of the ticks, the first 0 [s].
std::vector<double> instants_of(const Scene& scene);

/// Scene without a tool: the observed signal is the position of one point.
class PointScene {
 public:
  /// `node` of a network; an oscillator has one coordinate.
  PointScene(const CaseContext& context, const Scene& scene, int node);
  ~PointScene();
  [[nodiscard]] MethodRun here(const Scene& scene) const;
  /// Solves networks with forces from the list kernel of the model, for a fair run time. The time
  /// is the wall time of the integration, or less if other processes used the processor. A solver
  /// that gives up is a failed run.
  [[nodiscard]] MethodRun there(const std::string& solver,
                                const reference::Tolerance& tolerance) const;

 private:
  const CaseContext& context_;
  std::unique_ptr<Problem> plain_;
  std::unique_ptr<Problem> quick_;  ///< empty: the plain one is quick enough
  std::vector<double> instants_;
  Eigen::Index first_ = 0;  ///< coordinate of the point
  Eigen::Index count_ = 1;
};

/// Scene with a needle: the observed signal is the force on the hand.
MethodRun needle_here(const CaseContext& context, const Scene& scene);

/// Solves with CVODE and root finding for events.
struct NeedleReference {
  MethodRun run{};
  std::vector<bool> jumps{};  ///< ticks within two of an event
};
NeedleReference needle_there(const Scene& scene, double tolerance);

namespace {

class QuickProblem final : public Problem {
 public:
  explicit QuickProblem(const NetworkProblem& plain)
      : plain_(plain),
        system_(plain, {}, 1.0, true),
        q_(plain.dof()),
        v_(plain.dof()),
        f_(plain.dof()) {}
  [[nodiscard]] Eigen::Index dof() const override { return plain_.dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return plain_.mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override {
    return plain_.initial_position();
  }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override {
    return plain_.initial_velocity();
  }
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    q_ = q;
    v_ = v;
    system_.force(t, gate, q_, v_, f_);
    f = f_;
  }
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q,
                const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::SparseMatrix<double>& stiffness,
                Eigen::SparseMatrix<double>& damping) const override {
    plain_.jacobian(q, v, stiffness, damping);
  }
  [[nodiscard]] std::vector<double> breaks() const override { return plain_.breaks(); }
  [[nodiscard]] double shortest_feature() const override { return plain_.shortest_feature(); }
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override {
    return plain_.energy(q, v);
  }

 private:
  const NetworkProblem& plain_;
  mutable ListNetwork<double> system_;
  mutable Eigen::VectorXd q_, v_, f_;
};

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Implicit schemes evaluate once an iteration at least.
long evaluations_of(std::string_view scheme, long steps) {
  return steps * find_integrator(scheme)->evaluations;
}

}  // namespace

std::vector<double> instants_of(const Scene& scene) {
  std::vector<double> times;
  const long count = std::lround(scene.simulation.duration / scene.simulation.step);
  for (long n = 0; n <= count; ++n) {
    times.push_back(static_cast<double>(n) * scene.simulation.step);
  }
  return times;
}

PointScene::PointScene(const CaseContext& context, const Scene& scene, int node)
    : context_(context), plain_(make_problem(scene)), instants_(instants_of(scene)) {
  const auto* network = dynamic_cast<const NetworkProblem*>(plain_.get());
  if (network == nullptr) { return; }
  quick_ = std::make_unique<QuickProblem>(*network);
  first_ = network->coordinate(node);
  count_ = 3;
}

PointScene::~PointScene() = default;

MethodRun PointScene::here(const Scene& scene) const {
  const Trace motion = roll_out(context_, scene, {.position = true, .energy = true});
  const std::string scheme(Simulation(scene).plan().integrator->name);
  return {.tool = motion.position.middleRows(first_, count_),
          .position = motion.position,
          .energy = vector_of(motion.values("energy_j")),
          .seconds = motion.seconds,
          .evaluations = evaluations_of(scheme, motion.steps),
          .failed = motion.diverged};
}

MethodRun PointScene::there(const std::string& solver,
                            const reference::Tolerance& tolerance) const {
  MethodRun run;
  try {
    const double begin = seconds_on(Clock::processor);
    const auto solution =
        reference::solver_named(solver).solve(quick_ ? *quick_ : *plain_, instants_, tolerance);
    const double busy = seconds_on(Clock::processor) - begin;
    run = {.tool = solution.position.middleRows(first_, count_),
           .position = solution.position,
           .seconds = std::min(busy, solution.seconds),
           .evaluations = solution.evaluations};
    run.energy.resize(solution.position.cols());
    for (Eigen::Index n = 0; n < run.energy.size(); ++n) {
      run.energy(n) = plain_->energy(solution.position.col(n), solution.velocity.col(n));
    }
  } catch (const reference::SolverError&) { run.failed = true; }
  return run;
}

MethodRun needle_here(const CaseContext& context, const Scene& scene) {
  const Trace insertion = roll_out(context, scene, {.position = true, .energy = true});
  MethodRun run{.tool = vector_of(insertion.values("tool.force_n")).transpose(),
                .position = insertion.position,
                .energy = vector_of(insertion.values("energy_j")),
                .seconds = insertion.seconds,
                .failed = insertion.diverged};
  const long ticks = static_cast<long>(insertion.rows()) - 1;
  run.evaluations = evaluations_of(insertion.method, ticks * insertion.substeps);
  return run;
}

NeedleReference needle_there(const Scene& scene, double tolerance) {
  const std::vector<double> times = instants_of(scene);
  const SpringNetwork network = build_network(scene);
  const double begin = seconds_on(Clock::processor);
  const reference::Insertion solved =
      reference::solve_insertion(scene, network, times, {.relative = tolerance});
  const double busy = seconds_on(Clock::processor) - begin;
  const auto count = static_cast<Eigen::Index>(times.size());
  NeedleReference found;
  found.run = {.tool = Eigen::MatrixXd(1, count),
               .position = Eigen::MatrixXd(solved.instants.front().position.size(), count),
               .energy = Eigen::VectorXd(count),
               .seconds = std::min(busy, solved.seconds),
               .evaluations = solved.evaluations};
  for (Eigen::Index n = 0; n < count; ++n) {
    const reference::InsertionInstant& instant = solved.instants[static_cast<std::size_t>(n)];
    found.run.tool(0, n) = instant.total;
    found.run.position.col(n) = instant.position;
    found.run.energy(n) = instant.energy.stored;
    found.jumps.push_back(
        std::ranges::any_of(solved.events, [&](const reference::InsertionEvent& event) {
          return event.kind != reference::InsertionEvent::Kind::knot_passed &&
                 std::abs(instant.time - event.time) <= 2.0 * scene.simulation.step;
        }));
  }
  return found;
}

// Error against run time on four scenes: one spring, a soft cube, seven layers under a needle, a
// stiff ligament.

namespace {

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
    outcome.judge(
        {.name = "error_at_end_" + std::string(p.kind == Point::Kind::automatic  ? "auto"
                                               : p.kind == Point::Kind::in_float ? "float"
                                                                                 : "double"),
         .value = p.errors.tool_at_end,
         .upper = most,
         .bound_from = "what semi-implicit Euler of other engines has after 0.1 s, 4.3e-4"});
  }
}

void judge(const CaseContext& context, const Study& study, const Demand& demand, Outcome& outcome) {
  const std::vector<Point> points =
      measure_points(study, context.quick ? 0.1 : 0.6, context.quick ? 2 : 5);
  outcome.judge({.name = "floor_of_the_reference",
                 .value = study.truth.floor,
                 .upper = 1e-5,
                 .bound_from = "a tenth of the smallest error that is asked for"});
  outcome.judge(
      {.name = "auto_over_quickest_as_accurate",
       .value = automatic_over_best(points),
       .upper = noise_of(points),
       .bound_from =
           "integrator = \"auto\" is on the frontier: the least of its run times over the median "
           "of any setting in double that is as near, apart by no more than least and median "
           "of one setting are in this table, or a tenth"});
  outcome.judge({.name = "error_of_auto",
                 .value = largest_error_of_automatic(points),
                 .upper = automatic_promise,
                 .bound_from = "what docs/scenes.md promises of integrator = \"auto\""});
  if (demand.times_cheaper > 0.0) {
    const Point* here = cheapest(points, 1e-3, true);
    const Point* there = cheapest(points, 1e-3, false);
    outcome.judge(
        {.name = "elsewhere_over_here_at_1e-3",
         .value =
             here != nullptr && there != nullptr ? there->seconds / here->seconds : std::nan(""),
         .lower = demand.times_cheaper,
         .bound_from =
             "asked of the project: so many times cheaper than the best of SUNDIALS, GSL and "
             "odeint"});
  }
  if (std::isfinite(demand.error_at_end)) { judge_end(points, demand.error_at_end, outcome); }
  add_tables(points, study, outcome);
  add_figures(points, study, outcome);
}

/// A scene without a tool, against two solvers that share no method.
void judge_point(const CaseContext& context, Study study, int node,
                 const std::array<const char*, 2>& references, const Demand& demand,
                 Outcome& outcome) {
  const PointScene point(context, study.scene, node);
  const reference::Tolerance tight{
      .relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  study.truth = truth_of(point.there(references[0], tight), point.there(references[1], tight));
  const reference::Tolerance scales{
      .position_scale = study.truth.travel,
      .velocity_scale = study.truth.travel / study.scene.simulation.duration};
  study.here = [&](const Scene& scene) { return point.here(scene); };
  study.there = [&](const std::string& solver, double tolerance) {
    reference::Tolerance wanted = scales;
    wanted.relative = tolerance;
    return point.there(solver, wanted);
  };
  judge(context, study, demand, outcome);
}

/// The paper's lightest damping (its Figs. 6-10): m = k = 1, c = 0.1, some four periods.
void measure_oscillator(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.tool = "the mass";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = 256;
  study.scene.simulation = {.duration = 25.0, .step = 0.25};
  study.scene.tissue.source = Source::oscillator;
  judge_point(context, study, 0, {"modal", "arkode-fehlberg-7-8"}, {}, outcome);
}

/// 1000 nodes, 26 neighbours, one pulled; not stiff, so solvers with matrices have no part in it.
void measure_cube(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.scene = s26_scene(10);
  study.tool = "the pulled node";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = context.quick ? 4 : 64;
  study.scene.simulation.substeps.reset();
  // Two and a half spacings; what its shapes lack is then half of what RK4 is off with one substep.
  study.reduction = {.near_radius = 0.025, .far_modes = 24};
  study.schemes_of_reduction = {"euler-cromer", "velocity-verlet", "rk4"};
  const int node = study.scene.loads.front().nodes.front();
  judge_point(context, study, node, {"arkode-fehlberg-7-8", "cvode-adams"},
              {.times_cheaper = 20.0, .error_at_end = 4.35e-4}, outcome);
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
  judge_point(context, study, node, {"arkode-fehlberg-7-8", "cvode-bdf"}, {}, outcome);
}

/// Seven layers with moduli that explicit schemes can follow, at 20 mm/s; force at ticks that no
/// jump is near.
void measure_needle(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.scene = tools::seven_soft_layers();
  study.schemes = all_schemes;
  // They keep velocities of half steps, which no tool can be felt with.
  std::erase(study.schemes, "leapfrog");
  std::erase(study.schemes, "feynman-newton");
  study.tool = "the force on the hand, but within two ticks of an event";
  study.solvers = {"cvode-adams with events as roots"};
  study.most_substeps = context.quick ? 64 : 256;
  study.scene.simulation = {.duration = context.quick ? 0.15 : 0.45, .step = 1e-3};
  const NeedleReference finest = needle_there(study.scene, 1e-10);
  study.truth = truth_of(finest.run, needle_there(study.scene, 1e-8).run, finest.jumps);
  study.here = [&](const Scene& scene) { return needle_here(context, scene); };
  study.there = [&](const std::string&, double tolerance) {
    return needle_there(study.scene, tolerance).run;
  };
  judge(context, study, {}, outcome);
}

Case precision_case(const std::string& scene, const std::string& claim,
                    void (*measure)(const CaseContext&, Outcome&)) {
  return {.name = "bench/precision/" + scene,
          .suite = "timing",
          .claim = claim,
          .measure = measure,
          .weight = 60.0};
}

}  // namespace

std::vector<Case> precision_cases() {
  return {
      precision_case(
          "oscillator",
          "On one spring, nothing in double is both quicker and nearer than what \"auto\" chooses.",
          measure_oscillator),
      precision_case(
          "cube",
          "The pulled cube of 1000 nodes is computed to a thousandth of its peak at a small part "
          "of "
          "what the best solver of another library takes for it, and \"auto\" is on the frontier.",
          measure_cube),
      precision_case(
          "needle",
          "Of seven layers under a needle, nothing in double is both quicker and nearer than what "
          "\"auto\" chooses.",
          measure_needle),
      precision_case(
          "ligament",
          "Of a stiff ligament, nothing in double is both quicker and nearer than what \"auto\" "
          "chooses.",
          measure_ligament)};
}

// Cost of accuracy in force evaluations, which are the same on every machine, so that a gate can
// compare them.

namespace {

/// A scene whose explicit schemes are compared, each with 1, 2, 4 ... substeps.
struct Frontier {
  Scene scene{};
  std::vector<std::string> schemes{"euler", "euler-cromer", "velocity-verlet", "rk4"};
  int least_substeps = 1;
  int most_substeps = 64;
  std::vector<double> costs{};  ///< numbers of evaluations for which digits are reported
  Truth truth{};
  std::function<MethodRun(const Scene&)> here{};
};

std::vector<Effort> efforts_of(const Frontier& frontier) {
  std::vector<Effort> efforts;
  for (const std::string& scheme : frontier.schemes) {
    for (int substeps = frontier.least_substeps; substeps <= frontier.most_substeps;
         substeps *= 2) {
      Scene scene = frontier.scene;
      scene.simulation.integrator = scheme;
      scene.simulation.substeps = substeps;
      const MethodRun run = frontier.here(scene);
      if (run.failed) { continue; }
      const double error = errors_of(run, frontier.truth).tool;
      if (!(error < 1.0)) { continue; }
      efforts.push_back(
          {.method = scheme, .cost = static_cast<double>(run.evaluations), .error = error});
      if (error < 10.0 * frontier.truth.floor) { break; }
    }
  }
  return efforts;
}

Table table_of(const std::vector<Effort>& efforts) {
  Table table{.id = "efforts",
              .title = "Evaluations and errors",
              .caption = "The largest error at the tool over its peak.",
              .columns = {"scheme", "evaluations of the force", "error"}};
  for (const Effort& each : efforts) { table.rows.push_back({each.method, each.cost, each.error}); }
  return table;
}

void judge(const Frontier& frontier, Outcome& outcome) {
  const std::vector<Effort> efforts = efforts_of(frontier);
  outcome.judge({.name = "floor_of_the_reference",
                 .value = frontier.truth.floor,
                 .upper = 1e-5,
                 .bound_from = "a tenth of the smallest error that is asked for"});
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    outcome.judge({.name = "evaluations_at_" + plain_number(error) + "_of_the_peak",
                   .value = cost_at(efforts, error),
                   .unit = "evaluations"});
  }
  for (const double cost : frontier.costs) {
    outcome.judge({.name = "digits_after_" + plain_number(cost, 6) + "_evaluations",
                   .value = digits_at(efforts, cost),
                   .unit = "digits"});
  }
  outcome.tables.push_back(table_of(efforts));
}

void judge_point(const CaseContext& context, Frontier frontier, int node,
                 const std::array<const char*, 2>& references, Outcome& outcome) {
  const PointScene point(context, frontier.scene, node);
  const reference::Tolerance tight{
      .relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  frontier.truth = truth_of(point.there(references[0], tight), point.there(references[1], tight));
  frontier.here = [&](const Scene& scene) { return point.here(scene); };
  judge(frontier, outcome);
}

void count_oscillator(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.costs = {400.0, 1600.0};
  frontier.scene.simulation = {.duration = 25.0, .step = 0.25};
  frontier.scene.tissue.source = Source::oscillator;
  judge_point(context, frontier, 0, {"modal", "arkode-fehlberg-7-8"}, outcome);
}

void count_cube(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.scene = s26_scene(6);
  frontier.costs = {400.0, 1600.0};
  judge_point(context, frontier, frontier.scene.loads.front().nodes.front(),
              {"arkode-fehlberg-7-8", "cvode-adams"}, outcome);
}

/// The force on the hand, but within two ticks of an event, where it jumps.
void count_needle(const CaseContext& context, Outcome& outcome) {
  Frontier frontier;
  frontier.scene = tools::seven_soft_layers();
  frontier.least_substeps = 8;
  frontier.costs = {2400.0, 9600.0};
  frontier.scene.simulation = {.duration = 0.15, .step = 1e-3};
  const NeedleReference finest = needle_there(frontier.scene, 1e-9);
  frontier.truth = truth_of(finest.run, needle_there(frontier.scene, 1e-8).run, finest.jumps);
  frontier.here = [&](const Scene& scene) { return needle_here(context, scene); };
  judge(frontier, outcome);
}

Case frontier_case(const std::string& scene, void (*measure)(const CaseContext&, Outcome&)) {
  return {.name = "bench/frontier/" + scene,
          .suite = "timing",
          .claim =
              "What an error costs in evaluations of the force, and what they buy, is known to a "
              "tenth of the smallest "
              "error that is asked for.",
          .measure = measure,
          .weight = 10.0};
}

}  // namespace

std::vector<Case> frontier_cases() {
  return {frontier_case("oscillator", count_oscillator), frontier_case("cube", count_cube),
          frontier_case("needle", count_needle)};
}

}  // namespace palpate::bench

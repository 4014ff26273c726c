// SPDX-License-Identifier: MIT
/// Block of tissue whose motion is compared with a reference.

#include "model/kernels/list_network.hpp"
#include "model/stepping/stability.hpp"
#include "reference/exact_problems.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::networks {

namespace {

struct BlockStudy {
  Scene scene{};  ///< loads, tick and duration; scheme and substeps are set per run
  SpringNetwork network{};
  LatticeShape shape{};
  int probe = 0;  ///< node that is drawn
  TruthSettings settings{};
  int implicit_rungs = 2;     ///< of one tick and halves of it; 0: none
  int implicit_substeps = 1;  ///< of the first
  std::string what{};         ///< "the cube", in captions
};

/// The problem of table 2.3 of other programs: 10 x 10 x 10 nodes, 26 neighbours (paper, Fig. 13).
BlockStudy cube_study(bool quick) {
  BlockStudy study{.what = "the cube"};
  study.shape = {{10, 10, 10}, 0.01, 26};
  study.network = uniform_lattice(study.shape, 50.0, 0.05, 1e-3);
  hold(study.network, Face::z_min);
  study.probe = 955;
  study.scene = scene_of("rk4", 1e-3, 0.1);
  study.scene.loads = {{.nodes = {study.probe}, .force = {0.0, 0.0, 0.1}}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-11;
  study.implicit_rungs = quick ? 0 : 2;
  return study;
}

/// Skin to dura, soft enough for explicit steps (paper, Fig. 14). Published orders of magnitude;
/// ligaments and dura a hundredth, for stable steps of some 10 us.
BlockStudy seven_layer_study(bool quick) {
  const int side = quick ? 4 : 5;
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {side, side}, .spacing = 2e-3};
  const auto made = [](const char* name, double youngs_modulus, double density) {
    return Material{
        .name = name, .youngs_modulus = youngs_modulus, .density = density, .damping_ratio = 0.5};
  };
  scene.materials = {made("skin", 60e3, 1100.0),         made("fat", 5e3, 950.0),
                     made("supraspinous", 80e3, 1130.0), made("interspinous", 100e3, 1130.0),
                     made("flavum", 150e3, 1130.0),      made("epidural", 2e3, 950.0),
                     made("dura", 122e3, 1174.0)};
  scene.tissue.layers = {{"skin", "skin", 0.002},
                         {"subcutaneous fat", "fat", 0.0048},
                         {"supraspinous ligament", "supraspinous", 0.003},
                         {"interspinous ligament", "interspinous", 0.0261},
                         {"ligamentum flavum", "flavum", 0.0034},
                         {"epidural space", "epidural", 0.006},
                         {"dura", "dura", 0.0007}};
  BlockStudy study{.what = "the seven layers"};
  study.network = build_network(scene);
  const int planes = static_cast<int>(study.network.node_count()) / (side * side);
  study.shape = {{side, side, planes}, 2e-3, 26};
  study.probe = study.shape.index(side / 2, side / 2, 0);
  study.scene = scene_of("rk4", 1e-3, quick ? 0.012 : 0.03);
  study.scene.loads = {{.nodes = {study.probe},
                        .force = {0.0, 0.0, 0.03},
                        .end = quick ? 0.01 : 0.02,
                        .profile = Profile::half_sine}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-13;
  study.implicit_substeps = 4;
  study.implicit_rungs = quick ? 0 : 2;
  return study;
}

/// Every spring and every node differs (paper, Fig. 15).
BlockStudy heterogeneous_study(bool quick) {
  const int side = quick ? 6 : 8;
  const Block block{.nodes = {side, side, side}};
  BlockStudy study{.shape = block.shape(), .what = "the heterogeneous block"};
  study.network = block_network(block);
  Random random(51);
  for (double& mass : study.network.mass) { mass *= random(0.6, 1.6); }
  study.network.springs.change_each([&](Spring& s) {
    s.stiffness *= std::pow(10.0, random(-0.7, 0.7));
    const double a = study.network.mass(s.a);
    const double b = study.network.mass(s.b);
    s.viscosity = 2.0 * random(0.1, 0.5) * std::sqrt(s.stiffness * a * b / (a + b));
  });
  hold(study.network, Face::z_max);
  study.probe = study.shape.index(side / 2, side / 2, 0);
  study.scene = scene_of("rk4", 1e-3, quick ? 0.03 : 0.06);
  study.scene.loads = {{.face = Face::z_min,
                        .force = {1e-3, 0.0, 3e-3},
                        .end = quick ? 0.02 : 0.04,
                        .profile = Profile::half_sine}};
  study.settings.rungs = quick ? 2 : 4;
  study.settings.tolerance.relative = 1e-11;
  study.implicit_substeps = 2;
  return study;
}

// The paper's Figs. 13-15: every scheme against references of two families of solvers.

using Eigen::Index;

/// Coarsest substeps whose step is below half of the scheme's limit (an eighth where it takes the
/// whole limit to lose the energy that it makes), then halves.
std::vector<int> ladder(const CaseContext& context, const BlockStudy& study,
                        const IntegratorInfo& scheme, const SpectralBounds& bounds) {
  int first = study.implicit_substeps;
  int rungs = study.implicit_rungs;
  if (!scheme.implicit) {
    const double share = scheme.name == "euler" ? 0.125 : 0.5;
    const double wanted = study.scene.simulation.step / (share * stable_step(scheme, bounds));
    first = 1;
    while (first < wanted) { first *= 2; }
    rungs = context.quick ? 2 : 3;
  }
  std::vector<int> substeps;
  for (int rung = 0; rung < rungs; ++rung) { substeps.push_back(first << rung); }
  return substeps;
}

struct SchemeErrors {
  std::vector<double> steps{};  ///< [s]
  std::vector<double> maximum{};
  std::vector<double> l2{};
};

/// Every rung of one scheme.
SchemeErrors run_scheme(const CaseContext& context, const BlockStudy& study, const Truth& truth,
                        const IntegratorInfo& scheme, const std::vector<int>& rungs, Table& table,
                        Outcome& outcome) {
  SchemeErrors errors;
  for (const int substeps : rungs) {
    Scene scene = study.scene;
    scene.simulation.integrator = std::string(scheme.name);
    scene.simulation.substeps = substeps;
    const Trace motion = roll_out(context, scene, &study.network, {.position = true});
    const TrajectoryError error = distance(motion, truth.solution);
    errors.steps.push_back(scene.simulation.step / substeps);
    errors.maximum.push_back(error.maximum);
    errors.l2.push_back(error.l2);
    table.rows.push_back({scheme.name, 1e3 * errors.steps.back(), error.maximum, error.l2,
                          error.final, motion.steps * scheme.evaluations});
    outcome.timings.push_back(
        {.name = std::string(scheme.name) + " at " + text(1e3 * errors.steps.back()) + " ms",
         .value = motion.seconds});
  }
  return errors;
}

/// Order over the finest halving with both errors a hundred times the floor; NaN without one.
double resolved_order(const std::vector<double>& errors, double floor) {
  for (std::size_t n = errors.size(); n > 1; --n) {
    const double coarse = errors[n - 2];
    const double fine = errors[n - 1];
    if (std::isnan(fine) || fine > 100.0 * floor) { return std::log2(coarse / fine); }
  }
  return std::nan("");
}

void judge_scheme(const IntegratorInfo& scheme, const SchemeErrors& errors, const Truth& truth,
                  Outcome& outcome) {
  const std::string name(scheme.name);
  const auto order = static_cast<double>(scheme.order_damped);
  const std::string why =
      "theory: halving the step divides the error by 2^order, to the next term of the expansion";
  outcome.judge_near("order_maximum_" + name, resolved_order(errors.maximum, truth.worst_floor),
                     order, 0.3, why);
  outcome.judge_near("order_l2_" + name, resolved_order(errors.l2, truth.l2_floor), order, 0.3,
                     why);
  outcome.report("maximum_error_" + name, errors.maximum.back());
  outcome.report("l2_error_" + name, errors.l2.back());
}

void judge_schemes(const CaseContext& context, const BlockStudy& study, const Truth& truth,
                   const SpectralBounds& bounds, Outcome& outcome) {
  Table& table =
      outcome.table("errors", "Errors on " + study.what,
                    "Error of every scheme at its steps, over the peak displacement (largest, "
                    "last) and over the root mean square of the motion; implicit schemes evaluate "
                    "forces once per Newton iteration, counted as one a step.",
                    {"scheme", "step (ms)", "largest error (1)", "L2 error (1)",
                     "error at the end (1)", "force evaluations"});
  Figure& figure =
      outcome.plot("error", "Error against step on " + study.what,
                   "Every scheme falls with its order towards the floor of the reference (dashed).",
                   logarithmic("step (s)"), logarithmic("largest error / peak"));
  double coarsest = 0.0;
  double finest = study.scene.simulation.step;
  for (const IntegratorInfo* scheme : integrators()) {
    const std::vector<int> rungs = ladder(context, study, *scheme, bounds);
    if (rungs.empty()) {
      outcome.notes.push_back("Quick form: " + std::string(scheme->name) + " not run here.");
      continue;
    }
    const SchemeErrors errors = run_scheme(context, study, truth, *scheme, rungs, table, outcome);
    judge_scheme(*scheme, errors, truth, outcome);
    coarsest = std::max(coarsest, errors.steps.front());
    finest = std::min(finest, errors.steps.back());
    figure.add(std::string(scheme->name), errors.steps, errors.maximum,
               Series::Style::line_and_points);
  }
  figure.add("floor of the reference", {finest, coarsest}, {truth.worst_floor, truth.worst_floor},
             Series::Style::dashed);
}

Figure motion_figure(const CaseContext& context, const BlockStudy& study,
                     const NetworkProblem& problem, const Truth& truth) {
  Figure figure = plot("displacement", "Displacement of the loaded node of " + study.what,
                       "Depth of the node under the load over time: the reference, and schemes at "
                       "the tick length divided so that each is stable.",
                       {"time (ms)"}, {"displacement along z (mm)"});
  const Index c = problem.coordinate(study.probe) + 2;
  const auto shown = [&](const std::vector<double>& time, const Eigen::MatrixXd& position,
                         const std::string& label, Series::Style style) {
    Series& series = figure.add(label, style);
    for (std::size_t n = 0; n < time.size(); ++n) {
      series.add(1e3 * time[n], 1e3 * (position(c, static_cast<Index>(n)) - position(c, 0)));
    }
  };
  shown(truth.solution.time, truth.solution.position, "reference", Series::Style::dashed);
  const SpectralBounds bounds = spectral_bounds(problem);
  for (const char* name : {"euler-cromer", "velocity-verlet"}) {
    Scene scene = study.scene;
    scene.simulation.integrator = name;
    scene.simulation.substeps = ladder(context, study, *find_integrator(name), bounds).front();
    const Trace motion = roll_out(context, scene, &study.network, {.position = true});
    shown(motion.time, motion.position, name, Series::Style::line);
  }
  return figure;
}

/// Size of the displacement in the middle plane when the probe is furthest away.
Figure section_figure(const BlockStudy& study, const NetworkProblem& problem, const Truth& truth) {
  const Eigen::MatrixXd& q = truth.solution.position;
  const Index c = problem.coordinate(study.probe) + 2;
  Index peak = 0;
  (q.row(c).array() - q(c, 0)).abs().maxCoeff(&peak);
  HeatMap map{.label = "displacement (mm)"};
  const auto& nodes = study.shape.nodes;
  for (int i = 0; i < nodes[0]; ++i) { map.x.push_back(1e3 * study.shape.position(i, 0, 0).x()); }
  for (int l = 0; l < nodes[2]; ++l) {
    map.y.push_back(1e3 * study.shape.position(0, 0, l).z());
    for (int i = 0; i < nodes[0]; ++i) {
      const Index first = problem.coordinate(study.shape.index(i, nodes[1] / 2, l));
      const double moved =
          first < 0 ? 0.0 : (q.col(peak).segment<3>(first) - q.col(0).segment<3>(first)).norm();
      map.z.push_back(1e3 * moved);
    }
  }
  Figure figure =
      plot("section", "Middle section of " + study.what,
           "Displacement in the middle plane at the peak of the loaded node, reference.",
           {"x (mm)"}, {"z (mm)"});
  figure.square = true;
  figure.heat_map = std::move(map);
  return figure;
}

/// Judges references and every scheme at its steps, adds table and figures, returns the truth.
Truth judge_block(const CaseContext& context, const BlockStudy& study, Outcome& outcome) {
  const NetworkProblem problem = problem_of(study.scene, study.network);
  const double tick = study.scene.simulation.step;
  const long ticks = std::lround(study.scene.simulation.duration / tick);
  const Truth truth = find_truth(context, problem, tick_times(tick, ticks), study.settings);
  judge_truth(truth, study.settings, outcome);
  judge_schemes(context, study, truth, spectral_bounds(problem), outcome);
  outcome.figures.push_back(motion_figure(context, study, problem, truth));
  outcome.figures.push_back(section_figure(study, problem, truth));
  return truth;
}

template <BlockStudy (*study)(bool quick)>
void measure_block(const CaseContext& context, Outcome& outcome) {
  judge_block(context, study(context.quick), outcome);
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  const BlockStudy study = cube_study(context.quick);
  const Truth truth = judge_block(context, study, outcome);
  const NetworkProblem problem = problem_of(study.scene, study.network);
  const Index c = problem.coordinate(study.probe) + 2;
  const Eigen::MatrixXd& q = truth.solution.position;
  outcome.judge_between("reference_tip", q(c, q.cols() - 1) - q(c, 0), 5.7313150e-4 * (1.0 - 2e-8),
                        5.7313150e-4 * (1.0 + 2e-8),
                        "four outside solvers: 5.7313150e-4 m, to 1e-8 and its own rounding", "m");
  const auto tip = [&](const char* scheme, double expected, const char* who) {
    Scene scene = study.scene;
    scene.simulation.integrator = scheme;
    const Trace motion = roll_out(context, scene, &study.network, {.position = true});
    const Index last = motion.position.cols() - 1;
    outcome.judge_between(
        std::string("tip_at_1_ms_") + scheme,
        motion.diverged ? std::nan("") : motion.position(c, last) - motion.position(c, 0),
        expected * (1.0 - 1e-9), expected * (1.0 + 1e-9), who, "m");
  };
  tip("euler-cromer", 5.733796333e-4, "four other programs with this scheme, equal to ten digits");
  tip("rk4", 5.731306973e-4, "three other programs with this scheme, equal to ten digits");
}

// Manufactured solutions: a lattice pushed so that it moves along a chosen q*(t). References must
// follow it to their tolerance, and every scheme, on the model's own kernel, with its order.

using reference::ManufacturedProblem;

constexpr double duration = 0.02;  ///< [s]

/// The model's kernel with M q*'' - f(q*, q*') of the specification as its load.
class PushedSystem final : public System<double> {
 public:
  PushedSystem(const NetworkProblem& kernel, const ManufacturedProblem& motion,
               const NetworkProblem& specification, double h)
      : kernel_(kernel, {}, h, true), motion_(motion), specification_(specification) {
    set_mass(specification.mass());
  }
  void force(double t, double gate, const Vector<double>& q, const Vector<double>& v,
             Vector<double>& f) noexcept override {
    kernel_.force(t, gate, q, v, f);
    add_loads(t, gate, 1.0, f);
  }
  void add_loads(double t, double gate, double weight, Vector<double>& f) noexcept override {
    Eigen::VectorXd along(f.size());
    specification_.force(t, gate, motion_.exact_position(t), motion_.exact_velocity(t), along);
    f += weight * (mass().cwiseProduct(motion_.exact_acceleration(t)) - along);
  }
  void damping(const Vector<double>& q, const Vector<double>& w,
               Vector<double>& f) noexcept override {
    kernel_.damping(q, w, f);
  }
  void jacobian(const Vector<double>& q, const Vector<double>& v, double on_damping,
                double on_stiffness, Eigen::SparseMatrix<double>& a) noexcept override {
    kernel_.jacobian(q, v, on_damping, on_stiffness, a);
  }
  void pattern(Eigen::SparseMatrix<double>& a) override { kernel_.pattern(a); }

 private:
  ListNetwork<double> kernel_;
  const ManufacturedProblem& motion_;
  const NetworkProblem& specification_;
};

SpringNetwork lattice() {
  const Block block{.nodes = {3, 3, 3}, .relaxation = 1e-3};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  Random random(31);
  network.springs.change_each(
      [&](Spring& s) { s.stiffness *= random(0.5, 2.0); });  // damping not proportional
  return network;
}

/// Largest distance from q* at the end over the largest |q* - q*(0)|.
double error_of(const IntegratorInfo& scheme, const NetworkProblem& kernel,
                const ManufacturedProblem& motion, const NetworkProblem& specification,
                long steps) {
  const double h = duration / static_cast<double>(steps);
  PushedSystem system(kernel, motion, specification, h);
  State<double> state{motion.initial_position(), motion.initial_velocity()};
  const auto integrator = scheme.make<double>();
  integrator->prepare(system, state, h);
  integrator->start(system, state, 0.0, h);
  Largest error;
  Largest peak;
  for (long n = 0; n < steps; ++n) {
    integrator->step(system, state, static_cast<double>(n) * h, h);
    if ((n + 1) % (steps / 16) != 0) { continue; }
    const Eigen::VectorXd exact = motion.exact_position(static_cast<double>(n + 1) * h);
    const Eigen::VectorXd away = state.position - exact;
    if (!away.allFinite()) { return std::nan(""); }
    error.add(largest_of(away));
    peak.add(largest_of(exact - motion.initial_position()));
  }
  return error.value() / peak.value();
}

void judge_references(const CaseContext& context, const ManufacturedProblem& motion,
                      Outcome& outcome) {
  const std::vector<double> times = tick_times(duration / 16, 16);
  for (const auto& [name, relative] : {std::pair{"arkode-fehlberg-7-8", 1e-12},
                                       {"cvode-adams", 1e-12},
                                       {"gsl-rk8pd", 1e-12},
                                       {"arkode-esdirk-5-4", 1e-8},
                                       {"cvode-bdf", 1e-8},
                                       {"gsl-msbdf", 1e-8}}) {
    const reference::Tolerance tolerance{.relative = relative};
    const Trace solution = reference::solve_cached(
        context.cache, name, reference::solver_named(name).solve, motion, times, tolerance);
    Eigen::MatrixXd exact(motion.dof(), static_cast<Eigen::Index>(times.size()));
    for (std::size_t n = 0; n < times.size(); ++n) {
      exact.col(static_cast<Eigen::Index>(n)) = motion.exact_position(times[n]);
    }
    const double error = trajectory_error(solution.position, exact, exact.col(0)).maximum;
    outcome.judge_at_most(
        std::string("reference_error_") + name, error, 1e3 * tolerance.relative,
        "exact motion; local tolerance " + text(tolerance.relative) + " over at most 1000 steps");
  }
}

void measure_manufactured(const CaseContext& context, Outcome& outcome) {
  const NetworkProblem specification(lattice());
  const NetworkProblem kernel(candidate(context, lattice()));
  const ManufacturedProblem motion(specification,
                                   {.amplitude = 5e-4, .frequency = 300.0, .duration = duration});
  judge_references(context, motion, outcome);
  Figure& figure = outcome.plot("order", "Error against a manufactured motion",
                                "Every scheme follows the chosen motion with its own order.",
                                logarithmic("step (s)"), logarithmic("largest error / peak"));
  for (const IntegratorInfo* scheme : integrators()) {
    Series& errors = figure.add(std::string(scheme->name), Series::Style::line_and_points);
    long count = scheme->order_damped == 1 ? 256 : scheme->order_damped == 2 ? 128 : 64;
    for (int rung = 0; rung < 5; ++rung, count *= 2) {
      errors.add(duration / static_cast<double>(count),
                 error_of(*scheme, kernel, motion, specification, count));
    }
    const ObservedOrder order = observed_order(errors.x, errors.y, 1e-13);
    const double expected = scheme->order_damped;
    outcome.judge_near("order_" + std::string(scheme->name), order.slope, expected, 0.15, "theory");
    outcome.judge_true("falls_" + std::string(scheme->name), order.monotone,
                       "errors must fall with the step");
  }
}

// Observed order of every scheme on a lattice that is pushed far enough to be nonlinear, with and
// without damping, against a reference of ten digits.

constexpr long ticks = 16;
constexpr double tick = 1.25e-3;  ///< [s]

SpringNetwork lattice(bool damped) {
  const Block block{.nodes = {4, 4, 4}, .relaxation = damped ? 5e-4 : 0.0};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  // Forces at t = 0: from rest, a velocity that is half a step late would cost nothing.
  displace(network, 0.03 * block.spacing, 17);
  return network;
}

/// A smooth push that begins and ends with a tick.
Scene pushed(const std::string& scheme, int substeps) {
  Scene scene = scene_of(scheme, tick, static_cast<double>(ticks) * tick, substeps);
  scene.loads = {{.face = Face::z_min,
                  .force = {4e-3, 2e-3, 4e-3},
                  .start = tick,
                  .end = 11 * tick,
                  .profile = Profile::half_sine}};
  return scene;
}

const TruthSettings settings{.tolerance = {.relative = 1e-13}, .demanded_digits = 10.0};

/// Substeps a tick: errors between 10 % and the reference's floor, steps below the stability limit.
std::vector<int> ladder(const IntegratorInfo& scheme, int order, bool quick) {
  int substeps = order == 1 ? 64 : order == 2 ? 16 : 4;
  if (scheme.name == "euler") { substeps = 256; }  // gains energy at first order in the step
  if (scheme.implicit) { substeps = order == 1 ? (quick ? 8 : 16) : (quick ? 4 : 8); }
  std::vector<int> rungs;
  for (int rung = 0; rung < 5; ++rung) { rungs.push_back(substeps << rung); }
  return rungs;
}

/// Share of the motion that is nonlinear.
double nonlinear_share(const NetworkProblem& problem, const Truth& truth) {
  const reference::LinearProblem linear(problem);
  const Trace straight =
      reference::solve_arkode_explicit(linear, truth.solution.time, {.relative = 1e-8});
  return trajectory_error(straight.position, truth.solution.position,
                          truth.solution.position.col(0))
      .maximum;
}

/// Largest errors over the peak, by step [s].
Series climb(const CaseContext& context, const IntegratorInfo& scheme, int order,
             const SpringNetwork& network, const Truth& truth) {
  Series errors{.style = Series::Style::line_and_points};
  for (const int substeps : ladder(scheme, order, context.quick)) {
    const Trace motion =
        roll_out(context, pushed(std::string(scheme.name), substeps), &network, {.position = true});
    errors.add(tick / substeps,
               motion.diverged ? std::nan("") : distance(motion, truth.solution).maximum);
  }
  return errors;
}

void draw(Series errors, int order, const std::string& how, double floor, Figure& figure) {
  const std::vector<double> ends{errors.x.front(), errors.x.back()};
  const double finest = errors.y.back();
  const double slope = finest * std::pow(ends[0] / ends[1], order);
  errors.label = how;
  figure.series.push_back(std::move(errors));
  figure.add("order " + std::to_string(order), ends, {slope, finest}, Series::Style::dashed);
  figure.add("reference, " + how, ends, {floor, floor}, Series::Style::dashed);
}

void judge_order(const CaseContext& context, const IntegratorInfo& scheme, bool damped,
                 Figure& figure, Outcome& outcome) {
  const std::string how = damped ? "damped" : "undamped";
  const int expected = damped ? scheme.order_damped : scheme.order_undamped;
  const SpringNetwork network = lattice(damped);
  const NetworkProblem problem = problem_of(pushed("rk4", 1), network);
  const Truth truth = find_truth(context, problem, tick_times(tick, ticks), settings);
  Series climbed = climb(context, scheme, expected, network, truth);
  const double floor = std::max(100.0 * truth.worst_floor, 1e-12);
  const ObservedOrder order = observed_order(climbed.x, climbed.y, floor);
  outcome.judge_near("observed_order_" + how, order.slope, expected, 0.15, "theory");
  outcome.judge_true("errors_fall_" + how, order.monotone, "a smaller step must be closer");
  outcome.judge_at_least("reference_agreed_digits_" + how,
                         truth.trustworthy ? truth.agreed_digits : 0.0, settings.demanded_digits,
                         "two families of solvers must agree to ten digits");
  outcome.judge_at_least("nonlinear_share_" + how, nonlinear_share(problem, truth), 0.01,
                         "less would judge a linear lattice");
  outcome.report("rungs_" + how, order.rungs);
  outcome.report("r_squared_" + how, order.r_squared);
  draw(std::move(climbed), expected, how, truth.worst_floor, figure);
}

void measure_order(const IntegratorInfo& scheme, const CaseContext& context, Outcome& outcome) {
  Figure& figure = outcome.plot(
      "order", "Error of " + std::string(scheme.name) + " on a nonlinear lattice",
      "Largest error over the peak, slopes of the expected order, floor of the reference.",
      logarithmic("step (s)"), logarithmic("largest error / peak"));
  for (const bool damped : {false, true}) { judge_order(context, scheme, damped, figure, outcome); }
}

Figure ladder_figure(const reference::Reference& found) {
  Figure figure =
      plot("ladder", "Ladder of tolerances of the reference",
           "Distance of looser runs from the finest; dashed: disagreement of the families.",
           logarithmic("relative tolerance"), logarithmic("largest difference / peak"));
  Series& agreement = figure.add("agreement", Series::Style::dashed);
  Series& rungs = figure.add(settings.solvers[0], Series::Style::line_and_points);
  for (const reference::Rung& rung : found.ladder) {
    rungs.add(rung.relative_tolerance, rung.position_error);
  }
  const double floor = std::pow(10.0, -found.agreed_digits);
  agreement.x = {rungs.x.back(), rungs.x.front()};
  agreement.y = {floor, floor};
  return figure;
}

/// Reference of the cases above with all checks of references.
void measure_reference(const CaseContext& context, Outcome& outcome) {
  const NetworkProblem problem = problem_of(pushed("rk4", 1), lattice(true));
  using reference::solver_named;
  std::vector<reference::NamedSolver> families{solver_named(settings.solvers[0]),
                                               solver_named(settings.solvers[1]),
                                               solver_named("gsl-rk8pd")};
  if (!context.quick) { families.push_back(solver_named("long-double-fehlberg-7-8")); }
  const reference::Reference found =
      reference::establish(problem, tick_times(tick, ticks), settings.tolerance, families,
                           {.rungs = 5,
                            .demanded_digits = settings.demanded_digits,
                            .cache = context.cache,
                            .permute_springs = true});
  outcome.judge_at_least("agreed_digits", found.agreed_digits, settings.demanded_digits,
                         "demanded by the order cases: two digits below their finest rung");
  outcome.judge_at_least("agreed_velocity_digits", found.agreed_velocity_digits,
                         settings.demanded_digits - 1.0, "one digit less than positions");
  outcome.judge_true("ladder_is_monotone", found.ladder_is_monotone,
                     "tighter tolerances must come closer");
  outcome.judge_at_least("conditioning_digits", found.conditioning_digits.value_or(0.0),
                         settings.demanded_digits,
                         "springs in another order may cost no required digit");
  outcome.judge_true("trustworthy", found.trustworthy, "every check of the reference");
  if (!found.reason.empty()) { outcome.notes.push_back(found.reason); }
  for (const std::string& note : found.notes) { outcome.notes.push_back(note); }
  outcome.figures.push_back(ladder_figure(found));
}

}  // namespace

std::vector<Case> convergence_cases() {
  std::vector<Case> cases{
      {"network/cube", "accuracy",
       "On a cube of 1000 masses every scheme converges to an independent reference with its "
       "order, and stands where other programs stand.",
       measure_cube, 10.0},
      {"network/seven-layers", "accuracy",
       "On seven layers from skin to dura every scheme converges to an independent reference with "
       "its order.",
       measure_block<seven_layer_study>, 10.0},
      {"network/heterogeneous", "accuracy",
       "On a block whose springs and masses all differ every scheme converges to an independent "
       "reference with its order.",
       measure_block<heterogeneous_study>, 5.0},
      {"network/reference", "accuracy",
       "Independent solvers agree on a nonlinear lattice to ten digits, and tighter tolerances "
       "come closer.",
       measure_reference, 1.0},
      {"network/manufactured", "accuracy",
       "On a chosen exact motion the references keep their tolerance and every scheme its order.",
       measure_manufactured, 2.0}};
  add_scheme_cases(cases, "network/order/", "accuracy",
                   [](const IntegratorInfo& scheme) {
                     return "On a nonlinear lattice " + std::string(scheme.name) + " has order " +
                            std::to_string(scheme.order_undamped) + " without and order " +
                            std::to_string(scheme.order_damped) + " with damping.";
                   },
                   measure_order, {.explicit_scheme = 1.0, .implicit_scheme = 3.0});
  return cases;
}

}  // namespace palpate::networks

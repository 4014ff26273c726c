// SPDX-License-Identifier: MIT
/// Comparison of every fast kernel with the specification in random states.

#include <numbers>

#include "model/kernels/lattice_network.hpp"
#include "model/kernels/list_network.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::networks {

namespace {

/// Configuration of a kernel test.
struct Variant {
  const char* name;
  PrintedForm printed{};
  bool damped = true;
  bool held = true;    ///< one face fixed, so that some springs are anchors
  bool loaded = true;  ///< loads and weight
  bool skip = true;
};

std::vector<Variant> variants() {
  PrintedForm everything = PrintedForm::all();
  everything.no_time_step = false;  // these two are errata of the stepping, not of the force
  everything.lagged_velocity = false;
  return {{.name = "damped"},
          {.name = "undamped", .damped = false},
          {.name = "undamped_without_skipping", .damped = false, .skip = false},
          {.name = "damped_without_skipping", .skip = false},
          {.name = "free", .held = false, .loaded = false},
          {.name = "printed_sign", .printed = {.sign = true}},
          {.name = "printed_sign_reversed", .printed = {.sign = true, .reversed = true}},
          {.name = "printed_direction", .printed = {.direction = true}},
          {.name = "printed_half_force", .printed = {.half_force = true}},
          {.name = "printed_together", .printed = everything}};
}

NetworkProblem problem_for(const CaseContext& context, const Variant& variant) {
  const Block block{.nodes = {4, 5, 3}, .relaxation = variant.damped ? 1e-3 : 0.0};
  SpringNetwork network = block_network(block);
  Random random(21);
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= random(0.2, 5.0);
    s.viscosity *= random(0.2, 5.0);
  });
  if (variant.held) { hold(network, Face::z_max); }
  std::vector<Load> loads;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  if (variant.loaded) {
    loads = {
        {.nodes = {2, 7}, .force = {0.02, -0.01, 0.03}, .end = 0.1, .profile = Profile::half_sine},
        {.nodes = {3},
         .force = {-0.01, 0.0, 0.02},
         .start = 0.02,
         .end = 0.08,
         .profile = Profile::ramp}};
    gravity = {0.0, 1.0, 9.81};
  }
  return NetworkProblem(candidate(context, network), loads, gravity, variant.printed);
}

/// Largest |kernel - specification| over the largest |force|, over random states.
template <class Real>
double force_error(NetworkSystem<Real>& system, const NetworkProblem& specification, int states) {
  const NodeLayout& layout = system.layout();
  Random random(22);
  Largest error;
  Vector<Real> q = system.initial_position();
  Vector<Real> v = system.initial_velocity();
  Vector<Real> f(layout.size);
  Eigen::VectorXd q_there(specification.dof());
  Eigen::VectorXd v_there(specification.dof());
  Eigen::VectorXd computed(specification.dof());
  for (int state = 0; state < states; ++state) {
    scatter(specification.initial_position() + random.vector(specification.dof(), 1e-3), layout, q);
    scatter(random.vector(specification.dof(), 0.2), layout, v);
    const double t = random(0.0, 0.1);
    system.force(t, t, q, v, f);
    gather(q, layout, q_there);  // as the kernel saw them, rounded
    gather(v, layout, v_there);
    gather(f, layout, computed);
    Eigen::VectorXd expected(specification.dof());
    specification.force(t, t, q_there, v_there, expected);
    const Eigen::VectorXd difference = computed - expected;
    if (!difference.allFinite()) { return std::nan(""); }
    error.add(largest_of(difference) / largest_of(expected));
  }
  return error.value();
}

/// The same of A = M + d C + s K, against the specification's matrices.
double jacobian_error(const NetworkProblem& kernel, const NetworkProblem& specification,
                      const Variant& variant) {
  ListNetwork<double> system(kernel, variant.printed, 1e-4, variant.skip);
  Random random(23);
  const Eigen::VectorXd q =
      specification.initial_position() + random.vector(specification.dof(), 1e-3);
  const Eigen::VectorXd v = random.vector(specification.dof(), 0.2);
  Eigen::SparseMatrix<double> assembled;
  system.pattern(assembled);
  constexpr double on_damping = 0.3;
  constexpr double on_stiffness = 0.7;
  system.jacobian(q, v, on_damping, on_stiffness, assembled);
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  specification.jacobian(q, v, stiffness, damping);
  Eigen::MatrixXd expected =
      on_damping * Eigen::MatrixXd(damping) + on_stiffness * Eigen::MatrixXd(stiffness);
  expected.diagonal() += specification.mass();
  return largest_of(Eigen::MatrixXd(assembled) - expected) / largest_of(expected);
}

template <class Real>
double list_error(const NetworkProblem& kernel, const NetworkProblem& specification,
                  const Variant& variant, int states) {
  Largest error;
  for (const bool padded : {false, true}) {
    ListNetwork<Real> system(kernel, variant.printed, 1e-4, variant.skip, {.padded = padded});
    error.add(force_error<Real>(system, specification, states));
  }
  return error.value();
}

template <class Real>
double lattice_error(const NetworkProblem& kernel, const NetworkProblem& specification,
                     const Variant& variant, int states,
                     const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front()) {
  const auto system =
      make_lattice_network<Real>(kernel, {.skip = variant.skip, .kernels = kernels});
  return force_error<Real>(*system, specification, states);
}

/// Errors of the forces in double and single precision, and a third one that depends on the kernel.
using KernelErrors = std::array<double, 3>;

void judge_variants(const CaseContext& context, Outcome& outcome, Table table,
                    const std::vector<Variant>& all, const std::string& third,
                    const std::string& third_from,
                    const std::function<KernelErrors(const NetworkProblem&, const NetworkProblem&,
                                                     const Variant&)>& errors_of) {
  const char* from = "26 springs of a node, each k L / f = 10 times a few roundings";
  for (const Variant& variant : all) {
    const auto [in_double, in_float, other] =
        errors_of(problem_for(context, variant), problem_for(CaseContext{}, variant), variant);
    const std::string name = variant.name;
    outcome.judge_at_most("double_" + name, in_double, 1e-13, from);
    outcome.judge_at_most("float_" + name, in_float, 1e-5,
                          "the same in single precision, inputs rounded alike");
    outcome.judge_at_most(third + name, other, 1e-13, third_from.empty() ? from : third_from);
    table.rows.push_back({name, in_double, in_float, other});
  }
  outcome.tables.push_back(std::move(table));
}

/// Judges the kernels of regular lattices, which do not implement the printed form.
void measure_lattice(const CaseContext& context, Outcome& outcome) {
  const int states = context.quick ? 5 : 20;
  std::vector<Variant> corrected = variants();
  std::erase_if(corrected, [](const Variant& variant) { return variant.printed.any(); });
  judge_variants(
      context, outcome,
      make_table(
          "lattice-kernels", "Kernels of regular lattices against the specification",
          "Largest difference of forces over the largest force in seeded random states; with the "
          "instructions of this processor, and with those that all of its kind have.",
          {"variant", "double (1)", "float (1)", "double, baseline (1)"}),
      corrected, "baseline_", "",
      [&](const NetworkProblem& kernel, const NetworkProblem& specification,
          const Variant& variant) {
        return KernelErrors{lattice_error<double>(kernel, specification, variant, states),
                            lattice_error<float>(kernel, specification, variant, states),
                            lattice_error<double>(kernel, specification, variant, states,
                                                  baseline_kernels().lattice_double)};
      });
}

void measure_kernels(const CaseContext& context, Outcome& outcome) {
  const int states = context.quick ? 5 : 20;
  judge_variants(context, outcome,
                 make_table("kernels", "Kernels against the specification",
                            "Largest difference of forces over the largest force in seeded random "
                            "states, and of the Jacobian over its largest entry.",
                            {"variant", "double (1)", "float (1)", "Jacobian (1)"}),
                 variants(), "jacobian_", "sums of 26 blocks, a few roundings each",
                 [&](const NetworkProblem& kernel, const NetworkProblem& specification,
                     const Variant& variant) {
                   return KernelErrors{list_error<double>(kernel, specification, variant, states),
                                       list_error<float>(kernel, specification, variant, states),
                                       jacobian_error(kernel, specification, variant)};
                 });
}

// Approximations and savings of a scene: heavy nodes, single precision, skipping.

using Eigen::Index;

/// S26 with another scheme.
Scene pulled_cube(int nodes, const std::string& scheme, double step, double duration) {
  Scene scene = s26_scene(nodes);
  scene.simulation = scene_of(scheme, step, duration).simulation;
  return scene;
}

/// Largest motion of the nodes of the held face [m].
double face_drift(const Scene& scene, const Trace& motion) {
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network);
  Largest drift(motion.diverged || !motion.position.allFinite() ? std::nan("") : 0.0);
  for (const int node : face_nodes(network.rest_position, Face::z_min)) {
    for (Index n = 0; n < motion.position.cols(); ++n) {
      const Eigen::Vector3d away = motion.position.col(n).segment<3>(problem.coordinate(node)) -
                                   network.rest_position.col(node);
      drift.add(largest_of(away));
    }
  }
  return drift.value();
}

/// |M (centre of mass - its start) - F t^2 / 2| over F t^2 / 2 at the end: a body held by mass is
/// free, and Verlet is exact for a constant force.
double centre_error(const Scene& scene, const Trace& motion, double& rounding) {
  const SpringNetwork network = build_network(scene);
  const Eigen::VectorXd mass = NetworkProblem(network).mass();
  const Eigen::VectorXd moved = motion.position.rightCols<1>() - motion.position.col(0);
  double along = 0.0;
  for (Index i = 2; i < moved.size(); i += 3) { along += mass(i) * moved(i); }
  const double time = scene.simulation.duration;
  const double expected = 0.5 * scene.loads.front().force.z() * time * time;
  rounding = static_cast<double>(motion.steps) * epsilon * network.mass.sum() *
             network.rest_position.cwiseAbs().maxCoeff() / expected;
  return std::abs(along / expected - 1.0);
}

void measure_heavy(const CaseContext& context, Outcome& outcome) {
  Series drifts{.label = "held by mass", .style = Series::Style::line_and_points};
  std::vector<double> inverse;
  Largest excess;
  for (double factor = 1e2; factor < 2e8; factor *= 10.0) {
    Scene scene = pulled_cube(5, "velocity-verlet", 1e-3, 0.05);
    scene.tissue.hold_by_mass = true;
    scene.tissue.heavy_mass_factor = factor;
    const Trace motion = roll_out(context, scene, {.position = true});
    inverse.push_back(1.0 / factor);
    drifts.add(factor, face_drift(scene, motion));
    double rounding = 0.0;
    const double error = centre_error(scene, motion, rounding);
    excess.add(error / rounding);
  }
  const ObservedOrder slope = observed_order(inverse, drifts.y, 0.0, unbounded);
  outcome.judge_between("slope_of_drift_over_factor", -slope.slope, -1.02, -0.98,
                        "theory: the same reaction on a heavier node; at the lightest of seven "
                        "factors the neighbours' springs pull it back");
  outcome.judge_at_most(
      "centre_of_mass_error_over_rounding", excess.value(), 1.0,
      "theory: the whole moves by F t^2 / (2 M); one rounding of every position a step");
  outcome.figures.push_back(
      plot("drift", "Drift of nodes that are held by mass",
           "The drift of a heavy node in 50 ms is proportional to one over its mass.",
           logarithmic("mass factor (1)"), logarithmic("largest drift (m)"), {drifts}));
}

void measure_float(const CaseContext& context, Outcome& outcome) {
  constexpr double half_unit = 0x1p-24;
  for (const char* scheme : {"euler-cromer", "velocity-verlet", "rk4"}) {
    Scene scene = pulled_cube(10, scheme, 1e-3, context.quick ? 0.05 : 0.1);
    scene.loads.front().nodes = {955};
    const Trace in_double = roll_out(context, scene, {.position = true});
    scene.simulation.precision = Precision::single_precision;
    const Trace in_float = roll_out(context, scene, {.position = true});
    const SpringNetwork network = build_network(scene);
    const Eigen::VectorXd start = NetworkProblem(network).initial_position();
    const TrajectoryError error = trajectory_error(in_float.position, in_double.position, start);
    const double reach = network.rest_position.cwiseAbs().maxCoeff();
    const auto steps = static_cast<double>(in_double.steps);
    outcome.judge_at_most(std::string("largest_error_") + scheme, error.maximum,
                          steps * half_unit * reach / error.peak,
                          "every step rounds each position by at most 2^-24 of the cube's extent, "
                          "and damped motion does not amplify it");
    outcome.judge_at_most(std::string("rms_error_") + scheme, error.l2,
                          steps * half_unit * reach / error.peak, "the same");
    outcome.report(std::string("one_rounding_over_peak_") + scheme, half_unit * reach / error.peak);
  }
}

/// Values that differ, or all of them when the shapes do.
double differing_values(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) { return unbounded; }
  return static_cast<double>((a.array() != b.array()).count());
}

Eigen::VectorXd column_of(const Trace& trace, std::size_t n) {
  const std::vector<double>& values = trace.columns.at(n).values;
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

struct SkipScene {
  const char* name;
  Scene scene;
  SpringNetwork network;
};

std::vector<SkipScene> skip_scenes(bool quick) {
  const auto made = [](const char* name, double relaxation, bool held, bool gravity) {
    SkipScene one{.name = name,
                  .scene = scene_of("auto", 2e-4, 8e-3),
                  .network = block_network({.nodes = {4, 4, 5}, .relaxation = relaxation})};
    if (held) { hold(one.network, Face::z_max); }
    displace(one.network, 5e-4, 41);
    if (gravity) { one.scene.tissue.gravity = {0.0, 0.0, 9.81}; }
    one.scene.records = {{.name = "top",
                          .where = 0,
                          .quantities = {RecordedQuantity::velocity, RecordedQuantity::force}}};
    one.scene.loads = {{.nodes = {0, 5}, .force = {1e-3, 0.0, 2e-3}, .end = 4e-3}};
    return one;
  };
  std::vector<SkipScene> scenes{made("undamped", 0.0, true, false),
                                made("damped_with_weight", 1e-3, true, true)};
  if (!quick) {
    scenes.push_back(made("damped", 1e-3, true, false));
    scenes.push_back(made("free_and_undamped", 0.0, false, false));
  }
  return scenes;
}

void measure_skip(const CaseContext& context, Outcome& outcome) {
  CaseContext skipping = context;
  CaseContext computing = context;
  skipping.skip = true;
  computing.skip = false;
  for (SkipScene& one : skip_scenes(context.quick)) {
    Largest differing;
    for (const IntegratorInfo* scheme : integrators()) {
      for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
        one.scene.simulation.integrator = std::string(scheme->name);
        one.scene.simulation.precision = precision;
        const SampleOptions samples{.position = true, .velocity = true, .energy = true};
        const Trace a = roll_out(skipping, one.scene, &one.network, samples);
        const Trace b = roll_out(computing, one.scene, &one.network, samples);
        differing.add(differing_values(a.position, b.position));
        differing.add(differing_values(a.velocity, b.velocity));
        for (std::size_t n = 0; n < a.columns.size(); ++n) {
          differing.add(differing_values(column_of(a, n), column_of(b, n)));
        }
        differing.add(a.diverged || b.diverged ? std::nan("") : 0.0);
      }
    }
    outcome.judge_at_most(std::string("differing_values_") + one.name, differing.value(), 0.0,
                          "skipped work adds nothing: the same bits");
  }
  outcome.notes.push_back("Every scheme, in both precisions, with and without skipping.");
}

/// Threads share a block out by layers; the springs across their borders must not be lost.
void measure_threads(const CaseContext& context, Outcome& outcome) {
  Scene scene = s26_scene(12);
  scene.simulation.duration = 0.02;
  const SampleOptions samples{.position = true, .velocity = true};
  const Trace one = roll_out(context, scene, samples);
  Largest differing;
  for (const int threads : {2, 3}) {
    scene.simulation.threads = threads;
    const Trace several = roll_out(context, scene, samples);
    differing.add(differing_values(one.position, several.position));
    differing.add(differing_values(one.velocity, several.velocity));
  }
  outcome.judge_at_most("differing_values_of_several_threads", differing.value(), 0.0,
                        "each force is the sum of the same terms in the same order: the same bits");
}

/// Sleeping nodes withhold at most the force that the scene allows.
void measure_sleep(const CaseContext& context, Outcome& outcome) {
  constexpr double allowed = 1e-3;  // [N]
  Scene scene = s26_scene(10);
  scene.simulation.duration = 0.03;
  scene.simulation.sleep_force = allowed;
  const SpringNetwork network = build_network(scene);
  const Trace trace = roll_out(context, scene, {.position = true, .velocity = true});
  const NetworkProblem problem = problem_of(scene, network);
  const Eigen::VectorXd start = problem.initial_position();
  Eigen::VectorXd f(problem.dof());
  Largest withheld;
  for (Eigen::Index n = 0; n + 1 < trace.position.cols(); ++n) {
    problem.force(trace.time[static_cast<std::size_t>(n)], 1.0, trace.position.col(n),
                  trace.velocity.col(n), f);
    double sum = 0.0;
    for (Eigen::Index k = 0; k < f.size(); k += 3) {
      const bool sleeps = trace.position.col(n + 1).segment<3>(k) == start.segment<3>(k);
      if (sleeps) { sum += f.segment<3>(k).norm(); }
    }
    withheld.add(sum);
  }
  const double least = context.skip ? 0.05 : 0.0;  // otherwise no node may sleep
  outcome.judge_between("withheld_force_over_allowed", withheld.value() / allowed, least, 1.0,
                        "simulation.sleep_force limits the sum of the forces on nodes that do not "
                        "move in the next step; and some sleep");
}

/// At rest and in motion the reduced-order far field answers a small load as the whole block does.
void measure_far_field(const CaseContext& context, Outcome& outcome) {
  Scene scene = s26_scene(9);
  scene.loads.front().force *= 1e-3;
  // Steps that are long against the periods of the block: each reduces the motion to a hundredth.
  scene.simulation.step = 1.0;
  scene.simulation.duration = 20.0;
  scene.simulation.integrator = "implicit-euler";
  const auto motion = [&](double near_radius) -> Eigen::MatrixXd {
    scene.simulation.near_radius = near_radius;
    const Trace trace = roll_out(context, scene, SampleOptions{.position = true});
    return trace.position.colwise() - trace.position.col(0);
  };
  Eigen::VectorXd whole = motion(0.0).rightCols<1>();
  Eigen::VectorXd reduced = motion(0.012).rightCols<1>();
  Eigen::Index tip = 0;
  const double moved = whole.cwiseAbs().maxCoeff(&tip);
  const std::string theory =
      "theory: the answer at rest to each load is one of its modes; strains of 1e-4 turn springs "
      "by as much";
  outcome.judge_near("deflection_with_a_far_field_over_whole", reduced(tip) / whole(tip), 1.0, 1e-4,
                     theory);
  outcome.judge_at_most("furthest_node_with_a_far_field",
                        networks::largest_of(reduced - whole) / moved, 1e-4, theory);
  scene.simulation.step = 1e-3;
  scene.simulation.duration = 0.1;  // several periods of the block
  scene.simulation.integrator = "rk4";
  whole = motion(0.0).row(tip);
  const auto error = [&](int modes) {
    scene.simulation.far_modes = modes;
    reduced = motion(0.012).row(tip);
    return networks::largest_of(reduced - whole) / networks::largest_of(whole);
  };
  outcome.judge_at_most("error_in_motion_of_6_modes", error(6), 0.02,
                        "requirement on the reduced-order model: 2 % of the largest motion");
  outcome.judge_at_most("error_in_motion_of_24_modes", error(24), 2e-4,
                        "theory: more modes leave the nonlinear part; strains of 1e-4 turn springs "
                        "by as much, at either end");
}

/// The recorded force on a node is its mass times its acceleration.
void measure_recorded_force(const CaseContext& context, Outcome& outcome) {
  constexpr double h = 1e-5;
  Scene scene = s26_scene(5);
  scene.simulation.step = h;
  scene.simulation.duration = 0.02;
  scene.simulation.integrator = "velocity-verlet";
  scene.simulation.substeps = 1;
  const int node = scene.loads.front().nodes.front();
  scene.records = {{.name = "pulled",
                    .where = node,
                    .quantities = {RecordedQuantity::velocity, RecordedQuantity::force}}};
  const SpringNetwork network = build_network(scene);
  double stiffness = 0.0;  // of the springs of the node
  for (const Spring& s : network.springs) {
    if (s.a == node || s.b == node) { stiffness += s.stiffness; }
  }
  // No frequency is higher than the square root of twice this over the mass (Gershgorin), and a
  // central difference errs by a sixth of the square of h w.
  const double error_of_difference = h * h * 2.0 * stiffness / network.mass(node) / 6.0;
  const Trace trace = roll_out(context, scene, SampleOptions{});
  const std::vector<double>& v = trace.values("pulled.vz_m_per_s");
  const std::vector<double>& f = trace.values("pulled.fz_n");
  Largest error;
  Largest peak;
  for (std::size_t n = 1; n + 1 < v.size(); ++n) {
    error.add(std::abs(network.mass(node) * (v[n + 1] - v[n - 1]) / (2.0 * h) - f[n]));
    peak.add(std::abs(f[n]));
  }
  outcome.judge_at_most("recorded_force_less_mass_times_acceleration_over_peak",
                        error.value() / peak.value(), error_of_difference,
                        "Newton's second law; a central difference over 20 us of the fastest "
                        "possible motion, (h w)^2 / 6");
}

// A load acts on the steps that begin in [start, end): the impulse on a free node counts them.
// Instants are whole numbers of a unit, so the count is exact.

constexpr double force = 0.75;  ///< [N]
constexpr double mass = 0.25;   ///< [kg]

/// A tick, its substeps, and a load, in units of `unit` seconds.
struct Timing {
  const char* name;
  double unit;  ///< [s]
  long tick;
  int substeps;
  long ticks;
  double start;  ///< [s] as a person would write or compute it
  double end;
  long start_units;
  long end_units;
};

constexpr std::array timings{
    Timing{"aligned", 1e-3, 1, 1, 50, 0.01, 0.03, 10, 30},
    Timing{"from_the_beginning", 1e-3, 1, 1, 50, 0.0, 0.02, 0, 20},
    Timing{"sum_of_tenths", 0.1, 1, 1, 12, 0.1 + 0.2, 0.7, 3, 7},
    Timing{"product_of_tenths", 0.1, 1, 1, 12, 3 * 0.1, 7 * 0.1, 3, 7},
    Timing{"below_a_tenth", 0.1, 1, 1, 12, 0.3, 0.1 + 0.2 + 0.4, 3, 7},
    Timing{"between_steps", 1e-4, 10, 1, 50, 0.0103, 0.0297, 103, 297},
    Timing{"end_between_steps", 1e-4, 10, 1, 50, 0.01, 0.0201, 100, 201},
    Timing{"inside_one_step", 1e-4, 10, 1, 50, 0.0102, 0.0108, 102, 108},
    Timing{"one_step", 1e-3, 1, 1, 50, 0.017, 0.018, 17, 18},
    Timing{"on_substeps", 1e-4, 10, 10, 50, 0.0103, 0.0297, 103, 297},
    Timing{"between_substeps", 1e-5, 100, 10, 50, 0.01033, 0.02971, 1033, 2971},
    Timing{"thirds", 1.0 / 3000.0, 3, 3, 50, 7.0 / 3000.0, 0.031, 7, 93},
    Timing{"past_the_end", 1e-3, 1, 1, 50, 0.04, 1.0, 40, 1000}};

/// Steps n with start <= n h < end, in whole units.
long expected_steps(const Timing& timing) {
  const long total = timing.ticks * timing.substeps;
  long count = 0;
  for (long n = 0; n < total; ++n) {
    const long begin = n * timing.tick;  // in units / substeps
    if (begin >= timing.start_units * timing.substeps &&
        begin < timing.end_units * timing.substeps) {
      ++count;
    }
  }
  return count;
}

/// Velocity that a load leaves behind, over h force / mass: a number of steps.
double impulse_in_steps(const CaseContext& context, const std::string& scheme, const Timing& timing,
                        Profile profile) {
  const double tick = timing.unit * static_cast<double>(timing.tick);
  Scene scene = scene_of(scheme, tick, tick * static_cast<double>(timing.ticks), timing.substeps);
  scene.loads = {{.nodes = {0},
                  .force = {0.0, 0.0, force},
                  .start = timing.start,
                  .end = timing.end,
                  .profile = profile}};
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Constant(1, mass);
  network.fixed = {0};
  const Trace motion = roll_out(context, scene, &network, {.position = true, .velocity = true});
  return motion.velocity(2, motion.velocity.cols() - 1) * mass / (force * motion.h);
}

void judge_counts(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table(
      "steps", "Steps on which a load acts",
      "Impulse of a constant load over h F, and the steps that begin in [start, end).",
      {"load", "start (s)", "end (s)", "h (s)", "impulse (steps)", "expected (steps)"});
  for (const Timing& timing : timings) {
    const auto expected = static_cast<double>(expected_steps(timing));
    const double steps = impulse_in_steps(context, "euler-cromer", timing, Profile::constant);
    const double rounding = epsilon * (expected + 4.0) * expected;
    outcome.judge_at_most(std::string("impulse_error_") + timing.name, std::abs(steps - expected),
                          rounding, "an exact count; one rounding of the velocity per step",
                          "steps");
    table.rows.push_back({timing.name, timing.start, timing.end,
                          timing.unit * static_cast<double>(timing.tick) / timing.substeps, steps,
                          expected});
  }
}

/// Every scheme gives a constant load the same impulse. A staggered scheme's velocity at an instant
/// is the mean of two, so only loads that have ended count.
void judge_schemes(const CaseContext& context, Outcome& outcome) {
  for (const IntegratorInfo* scheme : integrators()) {
    Largest error;
    for (const Timing& timing : timings) {
      if (timing.end_units > timing.ticks * timing.tick) { continue; }
      const auto expected = static_cast<double>(expected_steps(timing));
      const double steps =
          impulse_in_steps(context, std::string(scheme->name), timing, Profile::constant);
      error.add(std::abs(steps - expected));
    }
    outcome.judge_at_most("largest_impulse_error_" + std::string(scheme->name), error.value(),
                          64.0 * epsilon * 200.0 * 200.0,
                          "an exact count of at most 200 steps; 64 roundings a step", "steps");
  }
}

/// Sums of the other profiles over aligned steps have closed forms.
void judge_profiles(const CaseContext& context, Outcome& outcome) {
  const Timing& aligned = timings.front();
  const double n = 20.0;
  const double sine = 1.0 / std::tan(std::numbers::pi / (2.0 * n));  // sum of sin(pi k / n)
  const double ramp = (n - 1.0) / 2.0;                               // sum of k / n
  const auto judge = [&](const char* name, Profile profile, double expected) {
    const double steps = impulse_in_steps(context, "euler-cromer", aligned, profile);
    outcome.judge_at_most(name, std::abs(steps / expected - 1.0), 1e-14 * n,
                          "closed sum over the steps; a few roundings each");
  };
  judge("half_sine_impulse_error", Profile::half_sine, sine);
  judge("ramp_impulse_error", Profile::ramp, ramp);
}

void measure_load_edges(const CaseContext& context, Outcome& outcome) {
  judge_counts(context, outcome);
  judge_schemes(context, outcome);
  judge_profiles(context, outcome);
}

}  // namespace

std::vector<Case> kernel_cases() {
  return {
      {"network/kernels", "accuracy",
       "Every kernel of the stepping computes the specification's forces and Jacobian to rounding.",
       measure_kernels, 0.2},
      {"network/lattice-kernels", "accuracy",
       "The kernels of regular lattices compute the specification's forces to rounding, with every "
       "set of instructions that this processor has.",
       measure_lattice, 0.2},
      {"network/heavy-nodes", "accuracy", "Nodes held by mass drift in inverse proportion to it.",
       measure_heavy, 0.3},
      {"network/float", "accuracy", "Single precision adds no more than the rounding of positions.",
       measure_float, 0.5},
      {"network/skip", "accuracy",
       "Skipping what a scene does not need changes no bit of its motion.", measure_skip, 0.5},
      {"network/threads", "accuracy",
       "Threads that share a block out compute the bits of one thread.", measure_threads, 0.2},
      {"network/sleep", "accuracy", "Nodes that sleep withhold no more force than is allowed.",
       measure_sleep, 0.2},
      {"network/far-field", "accuracy",
       "A reduced-order far field rests where the whole block does.", measure_far_field, 0.5},
      {"network/recorded-force", "accuracy",
       "The recorded force on a node is its mass times its acceleration.", measure_recorded_force,
       0.1},
      {"network/load-edges", "accuracy",
       "A load acts on exactly the integrator steps that begin in [start, end), whatever rounding "
       "does to the instants.",
       measure_load_edges, 0.1}};
}

}  // namespace palpate::networks

// SPDX-License-Identifier: MIT
/// Every fast kernel computes what the specification says, in random states.

#include <cmath>
#include <functional>

#include "model/stepping/lattice_network.hpp"
#include "model/stepping/list_network.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

/// What is asked of a kernel.
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
  double error = 0.0;
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
    error = worse(error, largest_of(difference) / largest_of(expected));
  }
  return error;
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
  double error = 0.0;
  for (const bool quads : {false, true}) {
    ListNetwork<Real> system(kernel, variant.printed, 1e-4, variant.skip, {.quads = quads});
    error = worse(error, force_error<Real>(system, specification, states));
  }
  return error;
}

template <class Real>
double lattice_error(const NetworkProblem& kernel, const NetworkProblem& specification,
                     const Variant& variant, int states,
                     const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front()) {
  LatticeNetwork<Real> system(kernel, variant.skip, 1, kernels);
  return force_error<Real>(system, specification, states);
}

/// Kernels of regular lattices, which know no printed form.
void measure_lattice(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "lattice-kernels",
              .title = "Kernels of regular lattices against the specification",
              .caption = "Largest difference of forces over the largest force in seeded random states; with the "
                         "instructions of this processor, and with those that all of its kind have.",
              .columns = {"variant", "double (1)", "float (1)", "double, baseline (1)"}};
  const int states = context.quick ? 5 : 20;
  for (const Variant& variant : variants()) {
    if (variant.printed.any()) { continue; }
    const NetworkProblem kernel = problem_for(context, variant);
    const NetworkProblem specification = problem_for(CaseContext{}, variant);
    const double in_double = lattice_error<double>(kernel, specification, variant, states);
    const double in_float = lattice_error<float>(kernel, specification, variant, states);
    const double baseline = lattice_error<double>(kernel, specification, variant, states,
                                                  lattice::baseline_kernels<double>());
    const std::string name = variant.name;
    for (const auto& [kind, value] : {std::pair{"double_", in_double}, {"baseline_", baseline}}) {
      outcome.judge({.name = kind + name,
                     .value = value,
                     .upper = 1e-13,
                     .bound_from = "26 springs of a node, each k L / f = 10 times a few roundings"});
    }
    outcome.judge({.name = "float_" + name,
                   .value = in_float,
                   .upper = 1e-5,
                   .bound_from = "the same in single precision, inputs rounded alike"});
    table.rows.push_back({name, in_double, in_float, baseline});
  }
  outcome.tables.push_back(std::move(table));
}

void measure(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "kernels",
              .title = "Kernels against the specification",
              .caption =
                  "Largest difference of forces over the largest force in seeded random "
                  "states, and of the Jacobian over its largest entry.",
              .columns = {"variant", "double (1)", "float (1)", "Jacobian (1)"}};
  const CaseContext unharmed{};
  const int states = context.quick ? 5 : 20;
  for (const Variant& variant : variants()) {
    const NetworkProblem kernel = problem_for(context, variant);
    const NetworkProblem specification = problem_for(unharmed, variant);
    const double in_double = list_error<double>(kernel, specification, variant, states);
    const double in_float = list_error<float>(kernel, specification, variant, states);
    const double matrix = jacobian_error(kernel, specification, variant);
    const std::string name = variant.name;
    outcome.judge({.name = "double_" + name,
                   .value = in_double,
                   .upper = 1e-13,
                   .bound_from = "26 springs of a node, each k L / f = 10 times a few roundings"});
    outcome.judge({.name = "float_" + name,
                   .value = in_float,
                   .upper = 1e-5,
                   .bound_from = "the same in single precision, inputs rounded alike"});
    outcome.judge({.name = "jacobian_" + name,
                   .value = matrix,
                   .upper = 1e-13,
                   .bound_from = "sums of 26 blocks, a few roundings each"});
    table.rows.push_back({name, in_double, in_float, matrix});
  }
  outcome.tables.push_back(std::move(table));
}

}  // namespace

std::vector<Case> kernel_cases() {
  return {{.name = "network/kernels",
           .suite = "accuracy",
           .claim = "Every kernel of the stepping computes the specification's forces and Jacobian "
                    "to rounding.",
           .measure = measure,
           .weight = 0.2},
          {.name = "network/lattice-kernels",
           .suite = "accuracy",
           .claim = "The kernels of regular lattices compute the specification's forces to rounding, with "
                    "every set of instructions that this processor has.",
           .measure = measure_lattice,
           .weight = 0.2}};
}

}  // namespace palpate::networks

// SPDX-License-Identifier: MIT
/// Manufactured solutions: a lattice pushed so that it moves along a chosen q*(t). References must
/// follow it to their tolerance, and every scheme, on the model's own kernel, with its order.

#include <cmath>

#include "model/stepping/integrator.hpp"
#include "model/stepping/list_network.hpp"
#include "reference/manufactured.hpp"
#include "reference/solvers.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

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
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= random(0.5, 2.0);
  });  // damping not proportional
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
  double error = 0.0;
  double peak = 0.0;
  for (long n = 0; n < steps; ++n) {
    integrator->step(system, state, static_cast<double>(n) * h, h);
    if ((n + 1) % (steps / 16) != 0) { continue; }
    const Eigen::VectorXd exact = motion.exact_position(static_cast<double>(n + 1) * h);
    const Eigen::VectorXd away = state.position - exact;
    if (!away.allFinite()) { return std::nan(""); }
    error = worse(error, largest_of(away));
    peak = worse(peak, largest_of(exact - motion.initial_position()));
  }
  return error / peak;
}

void judge_references(const CaseContext& context, const ManufacturedProblem& motion,
                      Outcome& outcome) {
  const std::vector<double> times = instants(duration / 16, 16);
  for (const char* name : {"arkode-fehlberg-7-8", "cvode-adams", "gsl-rk8pd", "arkode-esdirk-5-4",
                           "cvode-bdf", "gsl-msbdf"}) {
    const bool high = std::string_view(name) != "cvode-bdf" &&
                      std::string_view(name) != "arkode-esdirk-5-4" &&
                      std::string_view(name) != "gsl-msbdf";
    const reference::Tolerance tolerance{.relative = high ? 1e-12 : 1e-8};
    const reference::Solution solution = reference::solve_cached(
        context.cache, name, reference::solver_named(name).solve, motion, times, tolerance);
    Eigen::MatrixXd exact(motion.dof(), static_cast<Eigen::Index>(times.size()));
    for (std::size_t n = 0; n < times.size(); ++n) {
      exact.col(static_cast<Eigen::Index>(n)) = motion.exact_position(times[n]);
    }
    const double error = trajectory_error(solution.position, exact, exact.col(0)).maximum;
    outcome.judge({.name = std::string("reference_error_") + name,
                   .value = error,
                   .upper = 1e3 * tolerance.relative,
                   .bound_from = "exact motion; local tolerance " + text(tolerance.relative) +
                                 " over at most 1000 steps"});
  }
}

void measure(const CaseContext& context, Outcome& outcome) {
  const NetworkProblem specification(lattice());
  const NetworkProblem kernel(candidate(context, lattice()));
  const ManufacturedProblem motion(specification,
                                   {.amplitude = 5e-4, .frequency = 300.0, .duration = duration});
  judge_references(context, motion, outcome);
  Figure figure{.id = "order",
                .title = "Error against a manufactured motion",
                .caption =
                    "Every scheme follows the chosen motion of a damped nonlinear lattice "
                    "with its own order.",
                .x = {.label = "step (s)", .logarithmic = true},
                .y = {.label = "largest error / peak", .logarithmic = true}};
  for (const IntegratorInfo* scheme : integrators()) {
    std::vector<double> steps;
    std::vector<double> errors;
    long count = scheme->order_damped == 1 ? 256 : scheme->order_damped == 2 ? 128 : 64;
    for (int rung = 0; rung < 5; ++rung, count *= 2) {
      steps.push_back(duration / static_cast<double>(count));
      errors.push_back(error_of(*scheme, kernel, motion, specification, count));
    }
    const ObservedOrder order = observed_order(steps, errors, 1e-13);
    const double expected = scheme->order_damped;
    outcome.judge({.name = "order_" + std::string(scheme->name),
                   .value = order.slope,
                   .lower = expected - 0.15,
                   .upper = expected + 0.15,
                   .bound_from = "theory"});
    outcome.judge({.name = "falls_" + std::string(scheme->name),
                   .value = order.monotone ? 1.0 : 0.0,
                   .lower = 1.0,
                   .bound_from = "errors must fall with the step"});
    figure.series.push_back(
        line(std::string(scheme->name), steps, errors, Series::Style::line_and_points));
  }
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> manufactured_cases() {
  return {{.name = "network/manufactured",
           .suite = "accuracy",
           .claim = "On a chosen exact motion the references keep their tolerance and every scheme "
                    "its order.",
           .measure = measure,
           .weight = 2.0}};
}

}  // namespace palpate::networks

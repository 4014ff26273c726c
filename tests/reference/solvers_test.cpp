// SPDX-License-Identifier: MIT

#include "reference/solvers.hpp"

#include <map>
#include <random>
#include <stdexcept>

#include "model/tissue/lattice.hpp"
#include "reference/exact_problems.hpp"
#include "reference/integrate.hpp"
#include "reference/solution.hpp"
#include "reference/solver_cross_check.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const NetworkProblem pulsed(sample::block({.nodes = 2}), {sample::pulse(0.1)});

TEST("the force law of the long double run agrees on cells, also where a corner collapses") {
  SpringNetwork network = cell_lattice({{3, 3, 3}, 0.01, 26}, [](int, int, int) {
    return CellMaterial{
        .youngs_modulus = 5e3, .density = 1000.0, .poissons_ratio = 0.45, .retardation_time = 1e-3};
  });
  for (const int node : face_nodes(network.rest_position, Face::z_max)) {
    network.fixed[static_cast<std::size_t>(node)] = 1;
  }
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement(2, 4) =
      0.0085;  // the middle of the top face, close to the next node
  const NetworkProblem problem(std::move(network));
  const std::vector<double> times = sample::instants(0.02, 4);
  const Trace one = solver_named("cvode-adams").solve(problem, times, {.relative = 1e-11});
  const Trace other =
      solver_named("long-double-fehlberg-7-8").solve(problem, times, {.relative = 1e-12});
  CHECK((one.position - other.position).cwiseAbs().maxCoeff() <= 1e-8 * 0.0085);
}

TEST("segments begin and end at breaks and gates lie inside them") {
  const auto segments = segments_of(pulsed, {0.0, 0.01, 0.05});
  REQUIRE(segments.size() == 3);
  const double ends[] = {0.0, 5e-3, 15e-3, 0.05};
  for (std::size_t n = 0; n < segments.size(); ++n) {
    CHECK(segments[n].start == ends[n]);
    CHECK(segments[n].end == ends[n + 1]);
    CHECK(segments[n].gate > segments[n].start);
    CHECK(segments[n].gate < segments[n].end);
    CHECK(segments[n].stops.back().time == segments[n].end);
  }
}

TEST("no step may be longer than a quarter of the shortest feature or a tenth of its segment") {
  for (const Segment& segment : segments_of(pulsed, {0.0, 10.0})) {
    CHECK(segment.max_step <= pulsed.shortest_feature() / 4.0);
    CHECK(segment.max_step <= (segment.end - segment.start) / 10.0);
  }
}

TEST("every requested time is a stop exactly once") {
  const auto times = sample::instants(0.05, 100);
  std::vector<int> seen(times.size(), 0);
  for (const Segment& segment : segments_of(pulsed, times)) {
    for (const auto& stop : segment.stops) {
      if (!stop.output) { continue; }
      ++seen[*stop.output];
      CHECK_NEAR(stop.time, times[*stop.output], 1e-14);
    }
  }
  CHECK(seen[0] == 0);  // the initial state needs no stop
  for (std::size_t n = 1; n < seen.size(); ++n) { CHECK(seen[n] == 1); }
}

TEST("a requested time within rounding of a break is the break") {
  const double just_before = std::nextafter(15e-3, 0.0);
  const auto segments = segments_of(pulsed, {0.0, just_before, 0.05});
  REQUIRE(segments.size() == 3);
  CHECK(segments[1].stops.size() == 1);
  CHECK(segments[1].stops[0].output == 1U);
}

TEST("times that do not ascend from zero are refused, and later breaks are ignored") {
  CHECK(segments_of(pulsed, {0.0, 4e-3}).size() == 1);
  CHECK(segments_of(pulsed, {0.0}).empty());
  CHECK_THROWS(segments_of(pulsed, {}), "begin at 0");
  CHECK_THROWS(segments_of(pulsed, {0.1, 0.2}), "begin at 0");
  CHECK_THROWS(segments_of(pulsed, {0.0, 0.2, 0.2}), "not later");
  CHECK_THROWS(segments_of(pulsed, {0.0, std::nan("")}), "not later");
}

const NetworkProblem network(sample::block({.nodes = 3, .viscosity = 0.5}), {sample::pulse(0.5)});

/// Large deformation (10 % of the spacing) in motion, so that every term of J contributes.
VectorXd deformed_state(Index dof) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  VectorXd y(2 * dof);
  for (Index i = 0; i < dof; ++i) { y(i) = 5e-4 * unit(random); }
  for (Index i = dof; i < 2 * dof; ++i) { y(i) = 0.5 * unit(random); }
  return y;
}

/// Central differences of the derivative, of fourth order.
MatrixXd differences(FirstOrderSystem& system, const VectorXd& y) {
  const Index n = system.size();
  MatrixXd matrix(n, n);
  for (Index j = 0; j < n; ++j) {
    const double h = j < system.dof() ? 1e-6 : 1e-3;
    const auto at = [&](double by) {
      VectorXd moved = y;
      moved(j) += by;
      VectorXd dy(n);
      CHECK(system.derivative(0.0, moved.data(), dy.data()));
      return dy;
    };
    matrix.col(j) = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
  }
  return matrix;
}

TEST("the first-order system is velocity and force over mass, and reports NaN") {
  FirstOrderSystem system(network);
  const VectorXd y = deformed_state(network.dof());
  VectorXd dy(system.size()), force(network.dof());
  system.set_gate(0.01);
  CHECK(system.derivative(0.011, y.data(), dy.data()));
  network.force(0.011, 0.01, network.initial_position() + y.head(network.dof()),
                y.tail(network.dof()), force);
  CHECK(dy.head(network.dof()) == y.tail(network.dof()));
  // One division against one multiplication by the inverse: two roundings.
  CHECK_NEAR(dy.tail(network.dof()).cwiseProduct(network.mass()), force,
             4e-16 * force.cwiseAbs().maxCoeff());
  CHECK(system.evaluations() == 1);
  VectorXd lost = y;
  lost(3) = std::nan("");
  CHECK(!system.derivative(0.0, lost.data(), dy.data()));
}

TEST("the sparse Jacobian equals differences of the right-hand side, deformed and moving") {
  FirstOrderSystem system(network);
  const VectorXd y = deformed_state(network.dof());
  const MatrixXd jacobian = palpate::reference::first_order_jacobian(system, y.data());
  const MatrixXd expected = differences(system, y);
  // Fourth-order differences leave about (rounding / h)^(4/5); 1e-7 of the largest entry.
  CHECK_NEAR(jacobian / expected.cwiseAbs().maxCoeff(), expected / expected.cwiseAbs().maxCoeff(),
             1e-8);
  const Index n = network.dof();
  const MatrixXd drag = expected.bottomRightCorner(n, n);
  CHECK_NEAR(jacobian.bottomRightCorner(n, n) / drag.cwiseAbs().maxCoeff(),
             drag / drag.cwiseAbs().maxCoeff(), 1e-8);
}

TEST("the Jacobian's pattern holds the whole diagonal even without damping") {
  const NetworkProblem undamped(sample::chain(5, 100.0, 1e-3, false));
  const FirstOrderSystem system(undamped);
  const VectorXd y = system.initial_state();
  const auto jacobian = palpate::reference::first_order_jacobian(system, y.data());
  for (Index j = 0; j < jacobian.cols(); ++j) {
    bool found = false;
    for (std::decay_t<decltype(jacobian)>::InnerIterator k(jacobian, j); k; ++k) {
      found = found || k.row() == j;
    }
    CHECK(found);
  }
}

// Requirements on all solvers of the list, for all libraries.

constexpr Tolerance unit_scale{.relative = 1e-11, .position_scale = 1.0, .velocity_scale = 1.0};

/// Global error over local tolerance, measured over 25 s of motion with a margin of three. With
/// error control per step it increases with the number of steps.
double expected_error(const NamedSolver& solver) {
  if (solver.family == "modal") { return 1e-13; }
  if (solver.family == "bdf") { return 1e-7; }
  if (solver.family == "adams") { return 5e-9; }
  // Weights errors with |y| + h |y'|, so its tolerance is slightly larger than that of the others.
  if (solver.name.starts_with("odeint")) { return 3e-10; }
  return 1e-10;
}

void compare(const Oscillator& oscillator, sample::Motion (*exact)(const Oscillator&, double)) {
  const OscillatorProblem problem(oscillator);
  const auto times = sample::instants(25.0, 100);
  for (const NamedSolver& solver : all_solvers()) {
    const Trace solution = solver.solve(problem, times, unit_scale);
    double error = 0.0;
    for (std::size_t n = 0; n < times.size(); ++n) {
      const auto motion = exact(oscillator, times[n]);
      const auto column = static_cast<Eigen::Index>(n);
      error = std::fmax(error, std::abs(solution.position(0, column) - motion.position));
      error = std::fmax(error, std::abs(solution.velocity(0, column) - motion.velocity));
    }
    check::row = solver.name;
    CHECK_NEAR(error, 0.0, expected_error(solver));
    CHECK(solution.method == solver.name);
    CHECK((solution.steps >= 10 || solver.family == "modal"));
  }
}

/// Oscillator whose force calls `fault` after an instant.
class Faulty final : public DerivedProblem {
 public:
  Faulty(const Problem& base, double instant, double (*fault)())
      : DerivedProblem(base), instant_(instant), fault_(fault) {}
  void force(double t, double gate, const Eigen::Ref<const VectorXd>& q,
             const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> f) const override {
    DerivedProblem::force(t, gate, q, v, f);
    if (t > instant_) { f(0) = fault_(); }
  }

 private:
  double instant_;
  double (*fault_)();
};

/// Returns true for solvers that call Problem::force during a step.
bool steps_the_problem(const NamedSolver& solver) {
  return solver.family != "modal" && !solver.name.starts_with("long-double");
}

TEST("every solver follows the oscillator in every regime, free and driven") {
  compare({.viscosity = 0.3}, sample::exact);
  compare({.viscosity = 2.0, .velocity = 0.5}, sample::exact_critical);
  compare({.viscosity = 5.0, .velocity = 1.0}, sample::exact);
  compare({.viscosity = 0.0, .velocity = -0.5}, sample::exact);
  compare({.viscosity = 0.3, .drive_amplitude = 0.7, .drive_frequency = 1.7}, sample::exact);
}

TEST("a NaN or an exception of the problem is an error of the solver, never a result or a hang") {
  const OscillatorProblem healthy(Oscillator{.viscosity = 0.3});
  const auto not_a_number = [] { return std::nan(""); };
  const Faulty lost_at_once(healthy, -1.0, not_a_number);
  const Faulty lost_later(healthy, 0.5, not_a_number);
  const Faulty throwing(healthy, 0.5, []() -> double { throw std::runtime_error("planted"); });
  for (const NamedSolver& solver : all_solvers()) {
    if (!steps_the_problem(solver)) { continue; }
    for (const Faulty* problem : {&lost_at_once, &lost_later}) {
      CHECK_THROWS(solver.solve(*problem, {0.0, 1.0, 2.0}, unit_scale), solver.name);
      CHECK_THROWS(solver.solve(*problem, {0.0, 1.0, 2.0}, unit_scale), "not finite");
    }
    CHECK_THROWS(solver.solve(throwing, {0.0, 1.0, 2.0}, unit_scale), "planted");
  }
}

TEST("a motion that grows beyond all numbers, and an unknown solver, are errors") {
  CHECK_THROWS(solver_named("euler"), "cvode-adams");
  const OscillatorProblem problem(Oscillator{.viscosity = -2000.0});
  for (const NamedSolver& solver : all_solvers()) {
    CHECK_THROWS(solver.solve(problem, {0.0, 1.0, 2.0}, unit_scale), solver.name.substr(0, 5));
  }
}

TEST("the initial state is stored unchanged and a single instant needs no step") {
  const OscillatorProblem problem(Oscillator{.velocity = 0.25});
  for (const NamedSolver& solver : all_solvers()) {
    const Trace solution = solver.solve(problem, {0.0}, unit_scale);
    CHECK_NEAR(solution.position(0, 0), 1.0, 1e-15);
    CHECK_NEAR(solution.velocity(0, 0), 0.25, 1e-15);
  }
}

TEST("where the origin lies changes nothing") {
  // Rounding at 1 m is 1e-16 m of 4e-4 m of motion, but the solvers then choose other steps, so
  // results differ by their own errors: 1e-9 at this tolerance.
  SpringNetwork moved = sample::block({.nodes = 3});
  moved.rest_position.colwise() += Eigen::Vector3d(1.0, -0.5, 0.25);
  const NetworkProblem here(sample::block({.nodes = 3}), {sample::pulse(0.5)});
  const NetworkProblem there(moved, {sample::pulse(0.5)});
  const auto times = sample::instants(0.03, 6);
  for (const char* name : {"arkode-fehlberg-7-8", "cvode-adams", "gsl-rk8pd"}) {
    const auto& solver = solver_named(name);
    const Trace a = solver.solve(here, times, {.relative = 1e-10});
    Trace b = solver.solve(there, times, {.relative = 1e-10});
    b.position.colwise() += a.position.col(0) - b.position.col(0);
    const double peak = peak_displacement(a.position);
    CHECK_NEAR(trajectory_error(b.position, a.position, peak), 0.0, 1e-8);
  }
}

TEST("the key of a reference changes with code, solver, tolerance, times and every number") {
  const SpringNetwork block = sample::block({.nodes = 2});
  const std::vector<double> times{0.0, 0.1};
  const auto key_of = [&](const SpringNetwork& made, double force = 0.1) {
    return cache_key("code", "solver", NetworkProblem(made, {sample::pulse(force)}), times, {});
  };
  const NetworkProblem problem(block, {sample::pulse(0.1)});
  const std::string key = key_of(block);
  CHECK(cache_key("code", "solver", problem, times, {}) == key);
  CHECK(cache_key("edoc", "solver", problem, times, {}) != key);
  CHECK(cache_key("code", "other", problem, times, {}) != key);
  CHECK(cache_key("code", "solver", problem, {0.0, 0.2}, {}) != key);
  CHECK(cache_key("code", "solver", problem, times, {.relative = 1e-9}) != key);
  CHECK(key_of(block, 0.2) != key);
  SpringNetwork stiffer = block;
  stiffer.springs.change_each([](Spring& spring) { spring.stiffness *= 1.0 + 1e-15; });
  CHECK(key_of(stiffer) != key);
  SpringNetwork heavier = block;
  heavier.mass *= 1.0 + 1e-15;
  CHECK(key_of(heavier) != key);
}

TEST("a solution is computed once for each code, and is written but not read without a reader") {
  static int runs = 0;
  const Solver solve = [](const Problem&, const std::vector<double>& times, const Tolerance&) {
    ++runs;
    return Trace{.time = times};
  };
  std::map<std::string, Trace> kept;
  Cache cache{.code = "code"};
  const auto get = [&] { (void)solve_cached(&cache, "solver", solve, pulsed, {0.0, 0.1}, {}); };
  cache.save = [&](const std::string& key, const Trace& solution) { kept[key] = solution; };
  get();
  get();
  CHECK(runs == 2);  // --no-skip
  CHECK(kept.size() == 1);
  cache.load = [&](const std::string& key) {
    const auto found = kept.find(key);
    return found == kept.end() ? std::nullopt : std::optional(found->second);
  };
  get();
  CHECK(runs == 2);
  cache.code = "code with another reference";
  get();
  CHECK(runs == 3);
  CHECK(kept.size() == 2);
}

}  // namespace PALPATE_FILE

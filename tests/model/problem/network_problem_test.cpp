// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/problem/problem.hpp"
#include "model/problem/spring_law.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/lattice.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

bool same(const Spring& one, const Spring& other) {
  return one.a == other.a && one.b == other.b && one.stiffness == other.stiffness &&
         one.viscosity == other.viscosity && one.rest_length == other.rest_length;
}

void check_holds(const SpringList& list, const std::vector<Spring>& springs) {
  REQUIRE(list.size() == springs.size());
  CHECK(list.empty() == springs.empty());
  CHECK(std::ranges::equal(list, springs, same));
  CHECK(std::ranges::equal(list.listed(), springs, same));
  for (std::size_t n = 0; n < springs.size(); ++n) { CHECK(same(list[n], springs[n])); }
}

/// Springs in the order of a lattice builder, with duplicates.
std::vector<Spring> chains(int rows, int nodes) {
  std::vector<Spring> springs;
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i + 1 < nodes; ++i) {
      const int a = row * nodes + i;
      springs.push_back({a, a + 1, 50.0, 0.1, 0.01});
      if (i + 2 < nodes) { springs.push_back({a, a + 2, 20.0, 0.0, 0.02}); }
    }
  }
  return springs;
}

TEST("a list gives back its springs in their order, whatever they are") {
  check_holds({}, {});
  check_holds(chains(1, 9), chains(1, 9));
  check_holds(chains(7, 9), chains(7, 9));
  std::vector<Spring> springs = random_network(5, {.nodes = 30, .springs = 200}).springs.listed();
  REQUIRE(springs.size() == 200);
  check_holds(springs, springs);
  std::ranges::sort(springs, {}, &Spring::a);
  check_holds(springs, springs);
  springs.insert(springs.end(),
                 {springs.front(), springs.front(), springs[3], springs[3]});  // twice in a row
  check_holds(springs, springs);
}

TEST("a spring may come after any other") {
  SpringList list = chains(4, 6);
  std::vector<Spring> springs = chains(4, 6);
  for (const Spring& more : {springs.back(), springs.front(), Spring{23, 0, 1.0, 0.0, 0.5},
                             Spring{24, 0, 1.0, 0.0, 0.5}, Spring{25, 1, 1.0, 0.0, 0.5}}) {
    list.push_back(more);
    springs.push_back(more);
    check_holds(list, springs);
  }
}

TEST("a list contains the edited springs") {
  SpringList list = chains(3, 5);
  list.change_each([](Spring& spring) { spring.stiffness *= 2.0; });
  CHECK(std::ranges::all_of(
      list, [](const Spring& s) { return s.stiffness == 100.0 || s.stiffness == 40.0; }));
  list.edit([](std::vector<Spring>& all) { all.erase(all.begin() + 1); });
  REQUIRE(list.size() == chains(3, 5).size() - 1);
  CHECK(same(list[1], {1, 2, 100.0, 0.1, 0.01}));
}

TEST("a lattice's springs take kilobytes, one by one they would take megabytes") {
  const SpringList& list = uniform_lattice({{40, 40, 40}, 0.01, 26}, 50.0, 0.05, 1e-3).springs;
  CHECK(list.size() * sizeof(Spring) > 20'000'000);
  CHECK(list.memory_bytes() < 400'000);
}

TEST("a network whose springs all differ takes no more than twice its list") {
  SpringList list = uniform_lattice({{8, 8, 8}, 0.01, 26}, 50.0, 0.05, 1e-3).springs;
  double factor = 1.0;
  list.change_each([&](Spring& spring) { spring.stiffness *= (factor += 1e-3); });
  CHECK(list.memory_bytes() < 2 * list.size() * sizeof(Spring));
}

TEST("damping is found wherever it is") {
  std::vector<Spring> springs = chains(2, 5);
  for (Spring& spring : springs) { spring.viscosity = 0.0; }
  CHECK(!is_damped(springs));
  CHECK(!is_damped(SpringList{}));
  springs[9].viscosity = 1e-9;
  CHECK(is_damped(springs));
}

using Eigen::Vector3d;

constexpr double spring_k = 200.0;
constexpr double spring_c = 0.4;
constexpr double rest = 0.5;

/// Force on end a at the origin; end b lies at d and leaves with velocity w.
Vector3d force_on_a(const PrintedForm& printed, const Vector3d& d, const Vector3d& w) {
  return spring_force<double>(SpringLaw::from(printed), {spring_k, rest, spring_c}, d, d.norm(),
                              w.dot(d) / d.norm());
}

const Vector3d stretched(0.0, 0.6, 0.8);  // length 1: 0.5 longer than at rest
const Vector3d unit = stretched;
const Vector3d at_rest = Vector3d::Zero();

TEST("a spring's force is that of its law, in every printed form") {
  const double f = spring_k * 0.5;  // at rest, stretched to length 1
  const Vector3d twice = 2.0 * stretched;
  CHECK_NEAR(force_on_a({}, stretched, at_rest), f * unit, 1e-13);  // pulls the ends together
  CHECK_NEAR(force_on_a({}, 0.25 * stretched, at_rest), -0.5 * f * unit, 1e-13);
  CHECK_NEAR(force_on_a({}, 0.5 * stretched, at_rest), at_rest, 1e-15);
  CHECK_NEAR(force_on_a({}, twice, at_rest), 3.0 * f * unit, 1e-12);
  CHECK_NEAR(force_on_a({.direction = true}, twice, at_rest), 3.0 * f * twice, 1e-12);
  // The damper resists the extension rate and ignores sideways motion.
  CHECK_NEAR(force_on_a({}, 0.5 * stretched, 3.0 * unit + Vector3d::UnitX()), 3.0 * spring_c * unit,
             1e-13);
  const auto moving = [](const PrintedForm& form) { return force_on_a(form, stretched, unit); };
  CHECK_NEAR(moving({.sign = true}), (-f + spring_c) * unit, 1e-13);
  CHECK_NEAR(moving({.sign = true, .reversed = true}), (f - spring_c) * unit, 1e-13);
  CHECK_NEAR(moving({.half_force = true}), 0.5 * (f + spring_c) * unit, 1e-13);
}

TEST("a spring of zero length exerts no force and makes no NaN") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.mass = Eigen::VectorXd::Ones(2);
  network.fixed = {0, 0};
  network.springs = {{0, 1, spring_k, spring_c, rest}};
  for (const double gap : {0.0, 0.5 * zero_length, 2.0 * zero_length}) {
    network.rest_position(0, 1) = gap;
    const NetworkProblem problem(network);
    Eigen::VectorXd f(6);
    problem.force(0.0, 0.0, problem.initial_position(), Eigen::VectorXd::Ones(6), f);
    CHECK_NEAR(f(0), gap < zero_length ? 0.0 : spring_k * (gap - rest), 1e-9);
    CHECK((gap > zero_length || f.norm() == 0.0));
  }
}

constexpr double mass = 0.02;

TEST("a load acts where its activation time lies in [start, end)") {
  const Load load{.start = 0.25, .end = 0.5};
  CHECK(load_factor(load, 0.25, 0.25) == 1.0);
  CHECK(load_factor(load, 0.25, std::nextafter(0.25, 0.0)) == 0.0);
  CHECK(load_factor(load, 0.5, std::nextafter(0.5, 0.0)) == 1.0);
  CHECK(load_factor(load, 0.5, 0.5) == 0.0);
  CHECK(load_factor(Load{}, 1e12, 1e12) == 1.0);  // a load without an end never ends
}

TEST("the activation time decides whether a load acts, the time how strongly") {
  const Load ramp{.start = 1.0, .end = 3.0, .profile = Profile::ramp};
  CHECK_NEAR(load_factor(ramp, 3.0, 2.5), 1.0, 1e-15);
  CHECK_NEAR(load_factor(ramp, 1.5, 1.5), 0.25, 1e-15);
  const Load sine{.start = 1.0, .end = 3.0, .profile = Profile::half_sine};
  CHECK_NEAR(load_factor(sine, 1.5, 1.5), std::sin(std::numbers::pi / 4.0), 1e-15);
  CHECK_NEAR(load_factor(sine, 3.0, 2.0), 0.0, 1e-15);
}

/// Velocity of a free mass after the run, in units of the impulse of one step over the mass.
double impulses(const IntegratorInfo& scheme, const Load& load, double step, int ticks,
                int substeps = 1) {
  Scene scene;
  scene.simulation = {.duration = ticks * step,
                      .step = step,
                      .substeps = substeps,
                      .integrator = std::string(scheme.name)};
  scene.tissue.source = Source::network;
  SpringNetwork& network = scene.tissue.network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Constant(1, mass);
  network.fixed = {0};
  scene.loads = {load};
  Simulation simulation(scene);
  for (int n = 0; n < ticks; ++n) { (void)simulation.tick(); }
  Eigen::VectorXd v(3);
  simulation.velocities(v);
  return v(2) * mass * substeps / step;
}

Load push(double start, double end) {
  return {.nodes = {0}, .force = {0, 0, 1}, .start = start, .end = end};
}

TEST("every scheme gives one step's impulse for each step that begins in [start, end)") {
  // Each step adds its own rounding, so n steps agree to a few n units of rounding.
  for (const IntegratorInfo* scheme : integrators()) {
    CHECK_NEAR(impulses(*scheme, push(2e-3, 5e-3), 1e-3, 10), 3.0, 1e-12);
    CHECK_NEAR(impulses(*scheme, push(2.5e-3, 4.5e-3), 1e-3, 10), 2.0, 1e-12);  // 3, 4
    CHECK_NEAR(impulses(*scheme, push(2.1e-3, 2.9e-3), 1e-3, 10), 0.0, 1e-12);  // none begins there
    CHECK_NEAR(impulses(*scheme, push(0.0, 1.0), 1e-3, 10), 10.0, 1e-12);
    CHECK_NEAR(impulses(*scheme, push(2e-3, 5e-3), 1e-3, 10, 4), 12.0, 1e-12);  // of the integrator
    CHECK_NEAR(impulses(*scheme, push(0.3, 0.7), 0.1, 10), 4.0, 1e-12);  // 3 * 0.1 > 0.3 in binary
    CHECK_NEAR(impulses(*scheme, push(0.6, 0.9), 0.1, 10), 3.0, 1e-12);
  }
}

TEST("a half-sine load gives the impulse of its area") {
  Load pulse = push(0.0, 0.1);
  pulse.profile = Profile::half_sine;
  // Trapezium rule of 100 panels on a sine: relative error pi^2 / 12 / 100^2 = 8.2e-5.
  const double area = 100.0 * 2.0 / std::numbers::pi;
  for (const char* name : {"velocity-verlet", "rk4", "implicit-midpoint", "leapfrog"}) {
    CHECK_NEAR(impulses(*find_integrator(name), pulse, 1e-3, 110) / area, 1.0, 1e-4);
  }
}

TEST("breaks of a problem are the switching instants, sorted, once each") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = Eigen::VectorXd::Ones(1);
  network.fixed = {0};
  const NetworkProblem problem(network, {push(0.4, 0.5), push(0.0, 0.4), push(0.1, Load{}.end)});
  const std::vector<double> expected{0.1, 0.4, 0.5};
  CHECK(problem.breaks() == expected);
  CHECK_NEAR(problem.shortest_feature(), 0.1, 1e-15);
}

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd force_of(const NetworkProblem& problem, const VectorXd& q, const VectorXd& v) {
  VectorXd f(problem.dof());
  problem.force(0.0, 0.0, q, v, f);
  return f;
}

/// Problem with a random displacement and velocity of its nodes.
struct Moved {
  Moved(const SpringNetwork& network, std::uint64_t seed, const PrintedForm& form = {})
      : problem(network, {}, Eigen::Vector3d(0.0, 1.0, 9.81), form) {
    Random random(seed + 100);
    q = problem.initial_position() + random.vector(problem.dof(), 2e-3);
    v = random.vector(problem.dof(), 0.5);
  }
  NetworkProblem problem;
  VectorXd q, v;
};

// Truncation of the central difference (~1e-9) and rounding (eps / delta ~ 1e-9) of forces of 1 N.
constexpr double delta = 1e-7;
constexpr double difference_error = 1e-6;

template <class Function> MatrixXd numerical_derivative(const VectorXd& at, Function function) {
  MatrixXd result(function(at).size(), at.size());
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    VectorXd up = at;
    VectorXd down = at;
    up(i) += delta;
    down(i) -= delta;
    result.col(i) = (function(up) - function(down)) / (up(i) - down(i));
  }
  return result;
}

const PrintedForm forms[] = {{},
                             {.sign = true},
                             {.sign = true, .reversed = true},
                             {.direction = true},
                             {.half_force = true},
                             {.sign = true, .direction = true, .half_force = true}};

TEST("K and C are the derivatives of the force, in every printed form") {
  for (const PrintedForm& form : forms) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const auto [problem, q, v] = Moved(random_network(seed), seed, form);
      Eigen::SparseMatrix<double> stiffness, damping;
      problem.jacobian(q, v, stiffness, damping);
      const MatrixXd k =
          -numerical_derivative(q, [&](const VectorXd& x) { return force_of(problem, x, v); });
      const MatrixXd c =
          -numerical_derivative(v, [&](const VectorXd& x) { return force_of(problem, q, x); });
      CHECK_NEAR(MatrixXd(stiffness), k, difference_error * k.norm());
      CHECK_NEAR(MatrixXd(damping), c, difference_error * c.norm());
    }
  }
}

TEST("the pattern of K and C does not depend on the state; C, and K without speed, are symmetric") {
  const auto [problem, q, v] = Moved(random_network(4), 5);
  const VectorXd still = VectorXd::Zero(problem.dof());
  Eigen::SparseMatrix<double> k0, c0, k1, c1;
  problem.jacobian(problem.initial_position(), still, k0, c0);
  problem.jacobian(q, v, k1, c1);
  CHECK(k0.nonZeros() == k1.nonZeros());
  CHECK(c0.nonZeros() == c1.nonZeros());
  CHECK(k0.nonZeros() == c0.nonZeros());
  problem.jacobian(q, still, k1, c1);
  CHECK_NEAR(MatrixXd(k1), MatrixXd(k1.transpose()), 1e-13 * k1.norm());
  CHECK_NEAR(MatrixXd(c1), MatrixXd(c1.transpose()), 1e-15 * c1.norm());
}

TEST("forces of a free network have no resultant and no torque") {
  for (const std::uint64_t seed : {8u, 9u, 10u}) {
    const NetworkProblem problem(random_network(seed, {.fixed = 0}));
    Random random(seed);
    const VectorXd q = problem.initial_position() + random.vector(problem.dof(), 2e-3);
    const VectorXd f = force_of(problem, q, random.vector(problem.dof(), 1.0));
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < f.size(); i += 3) {
      sum += f.segment<3>(i);
      torque += q.segment<3>(i).cross(f.segment<3>(i));
    }
    CHECK_NEAR(sum.norm(), 0.0, 1e-14 * f.norm());            // a few roundings of the largest
    CHECK_NEAR(torque.norm(), 0.0, 1e-14 * f.norm() * 0.02);  // times the size of the body
  }
}

TEST("the undamped force is the negative gradient of the energy, and dampers only take power") {
  const auto [undamped, q, v] = Moved(random_network(11, {.viscosity = 0.0}), 12);
  const VectorXd still = VectorXd::Zero(undamped.dof());
  const VectorXd f = force_of(undamped, q, still);
  const MatrixXd gradient = numerical_derivative(
      q, [&](const VectorXd& x) { return VectorXd::Constant(1, undamped.energy(x, still)); });
  CHECK_NEAR(VectorXd(-gradient.transpose()), f, 1e-6 * f.norm());
  for (const std::uint64_t seed : {13u, 14u, 15u, 16u}) {
    const Moved damped(random_network(seed), seed);
    const VectorXd drag = force_of(damped.problem, damped.q, damped.v) -
                          force_of(damped.problem, damped.q, VectorXd::Zero(damped.q.size()));
    CHECK(drag.dot(damped.v) < 0.0);
  }
}

TEST("fixed nodes have no coordinate and no part in positions and masses") {
  SpringNetwork network = random_network(17);
  network.initial_displacement = NodeVectors::Constant(3, network.node_count(), 1e-3);
  const NetworkProblem problem(network);
  CHECK(problem.coordinate(0) == -1);
  CHECK(problem.coordinate(3) == -1);
  CHECK(problem.coordinate(1) == 0);
  CHECK(problem.dof() == 3 * (network.node_count() - 2));
  CHECK_NEAR(Eigen::Vector3d(problem.initial_position().segment<3>(0)),
             Eigen::Vector3d(network.rest_position.col(1).array() + 1e-3), 0.0);
  CHECK_NEAR(problem.mass()(0), network.mass(1), 0.0);
}

TEST("a common displacement of all nodes changes no spring force") {
  SpringNetwork network = random_network(18);
  const NetworkProblem before(network);
  network.initial_displacement = NodeVectors::Constant(3, network.node_count(), 0.25);
  const NetworkProblem after(network);
  const VectorXd still = VectorXd::Zero(before.dof());
  const VectorXd f = force_of(before, before.initial_position(), still);
  // Positions of 0.25 m round to 3e-17 m, times the stiffest spring of 1e3 N/m, times 10 springs.
  CHECK_NEAR(force_of(after, after.initial_position(), still), f, 1e-12);
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
/// The fast kernels against NetworkProblem, the specification.
#include "model/stepping/spring_kernels.hpp"

#include <limits>

#include "model/stepping/list_network.hpp"
#include "tests/check.hpp"
#include "tests/model/random_network.hpp"

namespace {

using namespace palpate;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double h = 1e-4;
const Eigen::Vector3d weight(0.3, -0.2, 9.81);

struct Setting {
  NetworkProblem problem;
  VectorXd q;
  VectorXd v;
};

Setting setting(std::uint64_t seed, const PrintedForm& form = {}, double viscosity = 0.1) {
  SpringNetwork network =
      random_network(seed, {.nodes = 20, .springs = 80, .fixed = 4, .viscosity = viscosity});
  network.rest_position.col(7) = network.rest_position.col(8);  // a pair without direction
  network.springs.push_back({7, 8, 100.0, 0.1, 1e-3});
  network.springs.push_back({0, 3, 100.0, 0.1, 1e-3});  // both ends fixed
  if (viscosity == 0.0) {
    network.springs.change_each([&](Spring& s) { s.viscosity = 0.0; });
  }
  const std::vector<Load> loads{
      {.nodes = {0, 5, 5}, .force = {1, 2, 3}},
      {.nodes = {9}, .force = {0, 0, 1}, .start = 1.0, .end = 2.0, .profile = Profile::half_sine}};
  NetworkProblem problem(network, loads, weight, form);
  Random random(seed + 50);
  VectorXd q = problem.initial_position() + random.vector(problem.dof(), 1e-3);
  q.segment<3>(problem.coordinate(7)) = q.segment<3>(problem.coordinate(8));
  return {problem, q, random.vector(problem.dof(), 0.5)};
}

template <class Real>
VectorXd fast_force(const Setting& at, const PrintedForm& form, double t, bool skip = true, bool quads = false) {
  ListNetwork<Real> system(at.problem, form, h, skip, {.quads = quads});
  Vector<Real> q = system.initial_position();
  Vector<Real> v = system.initial_velocity();
  scatter(at.q, system.layout(), q);
  scatter(at.v, system.layout(), v);
  Vector<Real> f = Vector<Real>::Constant(q.size(), Real(1e30));  // must be cleared
  system.force(t, t, q, v, f);
  VectorXd packed(at.problem.dof());
  gather(f, system.layout(), packed);
  return packed;
}

VectorXd specified_force(const Setting& at, double t) {
  VectorXd f(at.problem.dof());
  at.problem.force(t, t, at.q, at.v, f);
  return f;
}

const PrintedForm forms[] = {{},
                             {.sign = true},
                             {.sign = true, .reversed = true},
                             {.direction = true},
                             {.half_force = true},
                             {.sign = true, .direction = true, .half_force = true}};

// Each coordinate is a sum of about 20 terms no larger than the largest force.
TEST("every kernel equals the specification to rounding, in double") {
  for (const PrintedForm& form : forms) {
    for (const double viscosity : {0.1, 0.0}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const Setting at = setting(seed, form, viscosity);
        for (const double t : {0.0, 1.3, 5.0}) {
          const VectorXd expected = specified_force(at, t);
          const double rounding = 20 * 2.3e-16 * expected.cwiseAbs().maxCoeff();
          for (const bool quads : {false, true}) {
            CHECK_NEAR(fast_force<double>(at, form, t, true, quads), expected, rounding);
          }
        }
      }
    }
  }
}

TEST("every kernel equals the specification to rounding, in float") {
  for (const PrintedForm& form : forms) {
    const Setting at = setting(6, form);
    const VectorXd expected = specified_force(at, 0.0);
    // Positions of 0.01 m round to 1e-9 m; the stiffest springs have 1e3 N/m.
    for (const bool quads : {false, true}) {
      CHECK_NEAR(fast_force<float>(at, form, 0.0, true, quads), expected, 1e-5 + 1e-5 * expected.norm());
    }
  }
}

TEST("computing what a scene does not need changes no bit") {
  for (const double viscosity : {0.1, 0.0}) {
    const Setting at = setting(7, {}, viscosity);
    for (const bool quads : {false, true}) {
      CHECK_NEAR(fast_force<double>(at, {}, 0.0, false, quads), fast_force<double>(at, {}, 0.0, true, quads), 0.0);
      CHECK_NEAR(fast_force<float>(at, {}, 0.0, false, quads), fast_force<float>(at, {}, 0.0, true, quads), 0.0);
    }
  }
}

/// 20 steps of semi-implicit Euler, in one pass each or in the scheme's own sweeps: places, then velocities.
template <class Real>
VectorXd stepped(const Setting& at, bool skip, bool one_pass) {
  ListNetwork<Real> system(at.problem, {}, h, skip, {.quads = true});
  State<Real> state{system.initial_position(), system.initial_velocity()};
  scatter(at.q, system.layout(), state.position);
  scatter(at.v, system.layout(), state.velocity);
  Vector<Real> a(state.position.size());
  const Real dt = static_cast<Real>(h);
  CHECK(system.has_one_pass());
  system.prepare_one_pass();
  for (int n = 0; n < 20; ++n) {
    const double t = 1.0 + h * n;  // while both loads act
    if (one_pass) {
      const double squares = system.one_pass(t, t, dt, state);
      CHECK_NEAR(squares, static_cast<double>(state.velocity.squaredNorm()),
                 100.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()) * squares);
    } else {
      system.acceleration(t, t, state.position, state.velocity, a);
      state.velocity += dt * a;
      state.position += dt * state.velocity;
    }
  }
  VectorXd all(2 * at.problem.dof());
  VectorXd packed(at.problem.dof());
  gather(state.position, system.layout(), packed);
  all.head(packed.size()) = packed;
  gather(state.velocity, system.layout(), packed);
  all.tail(packed.size()) = packed;
  return all;
}

TEST("a step of a list in one pass gives the bits of sweeps one after another") {
  for (const double viscosity : {0.1, 0.0}) {
    for (const bool skip : {true, false}) {
      const Setting at = setting(9, {}, viscosity);
      const VectorXd expected = stepped<double>(at, skip, false);
      CHECK(expected.allFinite());
      CHECK(stepped<double>(at, skip, true) == expected);
      CHECK(stepped<float>(at, skip, true) == stepped<float>(at, skip, false));
    }
  }
}

TEST("only vectors of quads are stepped in one pass") {
  const Setting at = setting(9);
  CHECK(!ListNetwork<double>(at.problem, {}, h, true).has_one_pass());
}

TEST("the lagged velocity of Eq. 9 is the backward difference of the length") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.rest_position(0, 1) = 1.0;
  network.mass = VectorXd::Ones(2);
  network.fixed = {0, 1};
  network.springs = {{0, 1, 10.0, 0.5, 1.0}};
  const NetworkProblem problem(network);
  ListNetwork<double> system(problem, {.lagged_velocity = true}, h, true);
  const VectorXd v = VectorXd::Constant(3, 1e3);  // must be ignored
  VectorXd f(3);
  system.force(0.0, 0.0, problem.initial_position(), v, f);
  CHECK_NEAR(f.norm(), 0.0, 0.0);  // length unchanged since the start, and at rest
  const VectorXd q = VectorXd::Unit(3, 0) * -0.02;
  system.force(h, h, q, v, f);
  CHECK_NEAR(f(0), 10.0 * 0.02 + 0.5 * 0.02 / h, 1e-10);
  system.force(2 * h, 2 * h, q, v, f);
  CHECK_NEAR(f(0), 10.0 * 0.02, 1e-13);
}

TEST("damping equals C w of the specification") {
  for (const PrintedForm& form : forms) {
    const Setting at = setting(8, form);
    ListNetwork<double> system(at.problem, form, h, true);
    Eigen::SparseMatrix<double> k, c;
    at.problem.jacobian(at.q, at.v, k, c);
    VectorXd f(at.problem.dof());
    system.damping(at.q, at.v, f);
    const VectorXd expected = c * at.v;
    CHECK_NEAR(f, expected, 1e-14 * expected.norm());
  }
}

TEST("the matrix of the implicit schemes is M + a C + b K of the specification") {
  for (const PrintedForm& form : forms) {
    const Setting at = setting(9, form);
    ListNetwork<double> system(at.problem, form, h, true);
    Eigen::SparseMatrix<double> k, c, a;
    at.problem.jacobian(at.q, at.v, k, c);
    system.pattern(a);
    system.jacobian(at.q, at.v, 0.3, 0.7, a);
    const MatrixXd expected =
        MatrixXd(at.problem.mass().asDiagonal()) + 0.3 * MatrixXd(c) + 0.7 * MatrixXd(k);
    CHECK_NEAR(MatrixXd(a), expected, 1e-14 * expected.norm());
  }
}

TEST("energy equals that of the specification and zero lengths are counted") {
  const Setting at = setting(10);
  ListNetwork<double> system(at.problem, {}, h, true);
  // Springs between fixed nodes store a constant that the fast path leaves out.
  double held = 0.0;
  for (const Spring& s : at.problem.network().springs) {
    if (at.problem.coordinate(s.a) >= 0 || at.problem.coordinate(s.b) >= 0) { continue; }
    const double l =
        (at.problem.network().rest_position.col(s.b) - at.problem.network().rest_position.col(s.a))
            .norm();
    held += 0.5 * s.stiffness * std::pow(l - s.rest_length, 2);
  }
  CHECK_NEAR(system.energy(at.q, at.v) + held, at.problem.energy(at.q, at.v), 1e-15);
  CHECK(system.zero_length_springs(at.q) >= 1);
}

}  // namespace

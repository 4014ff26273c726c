// SPDX-License-Identifier: MIT
/// Selection of kernels by processor and by environment variable.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "model/kernels/instruction_set.hpp"
#include "model/kernels/lattice_rows.hpp"
#include "model/kernels/list_network.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/kernels/system.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

/// Sets the environment variable and restores its previous value.
class Asked {
 public:
  explicit Asked(const char* name) {
    if (const char* before = std::getenv(variable)) { before_ = before; }
    setenv(variable, name, 1);
  }
  ~Asked() { before_.empty() ? unsetenv(variable) : setenv(variable, before_.c_str(), 1); }
  Asked(const Asked&) = delete;
  Asked& operator=(const Asked&) = delete;

 private:
  static constexpr const char* variable = "PALPATE_INSTRUCTIONS";
  std::string before_{};
};

std::string best() { return lattice_kernels<double>().front().name; }

TEST("the widest kernels that the processor can run come first, those that all can run last") {
  const Asked asked("avx512");
  CHECK(best() == (has_avx512() ? "avx512" : has_avx2() ? "avx2" : "baseline"));
  CHECK(std::string(lattice_kernels<double>().back().name) == "baseline");
  CHECK(lattice_kernels<float>().size() == 1U + (has_avx2() ? 1U : 0U) + (has_avx512() ? 1U : 0U));
}

TEST("the environment can select smaller instruction sets, and other names are refused") {
  {
    const Asked asked("avx2");
    CHECK(best() == (has_avx2() ? "avx2" : "baseline"));
  }
  {
    const Asked asked("baseline");
    CHECK(best() == "baseline");
    CHECK(lattice_kernels<float>().size() == 1);
  }
  const Asked asked("sse9");
  CHECK_THROWS_AS(std::invalid_argument, lattice_kernels<double>(),
                  "PALPATE_INSTRUCTIONS = sse9; must be avx512, avx2 or baseline");
}

// Fast kernels compared with NetworkProblem, the specification.

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
VectorXd fast_force(const Setting& at, const PrintedForm& form, double t, bool skip = true,
                    bool padded = false) {
  ListNetwork<Real> system(at.problem, form, h, skip, {.padded = padded});
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

TEST("every kernel equals the specification to rounding, in double and in float") {
  for (const PrintedForm& form : forms) {
    for (const double viscosity : {0.1, 0.0}) {
      for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const Setting at = setting(seed, form, viscosity);
        for (const double t : {0.0, 1.3, 5.0}) {
          const VectorXd expected = specified_force(at, t);
          for (const bool padded : {false, true}) {
            // Each coordinate is a sum of about 20 terms no larger than the largest force.
            CHECK_NEAR(fast_force<double>(at, form, t, true, padded), expected,
                       20 * 2.3e-16 * expected.cwiseAbs().maxCoeff());
            // Positions of 0.01 m round to 1e-9 m; the stiffest springs have 1e3 N/m.
            CHECK_NEAR(fast_force<float>(at, form, t, true, padded), expected,
                       1e-5 + 1e-5 * expected.norm());
          }
        }
      }
    }
  }
}

TEST("computing the parts that a scene does not need changes no bit") {
  for (const double viscosity : {0.1, 0.0}) {
    const Setting at = setting(7, {}, viscosity);
    for (const bool padded : {false, true}) {
      CHECK_NEAR(fast_force<double>(at, {}, 0.0, false, padded),
                 fast_force<double>(at, {}, 0.0, true, padded), 0.0);
      CHECK_NEAR(fast_force<float>(at, {}, 0.0, false, padded),
                 fast_force<float>(at, {}, 0.0, true, padded), 0.0);
    }
  }
}

/// 20 steps of semi-implicit Euler, as a single pass or as the separate sweeps of the scheme:
/// positions, then velocities.
template <class Real> VectorXd stepped(const Setting& at, bool skip, bool one_pass) {
  ListNetwork<Real> system(at.problem, {}, h, skip, {.padded = true});
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
  VectorXd q(at.problem.dof()), v(at.problem.dof()), all(2 * at.problem.dof());
  gather(state.position, system.layout(), q);
  gather(state.velocity, system.layout(), v);
  all << q, v;
  return all;
}

TEST("a step of a list in one pass, with padded vectors, gives the bits of separate sweeps") {
  CHECK(!ListNetwork<double>(setting(9).problem, {}, h, true).has_one_pass());
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

TEST("damping is C w, and the matrix of the implicit schemes M + a C + b K of the specification") {
  for (const PrintedForm& form : forms) {
    const Setting at = setting(8, form);
    ListNetwork<double> system(at.problem, form, h, true);
    Eigen::SparseMatrix<double> k, c, a;
    at.problem.jacobian(at.q, at.v, k, c);
    VectorXd f(at.problem.dof());
    system.damping(at.q, at.v, f);
    const VectorXd drag = c * at.v;
    CHECK_NEAR(f, drag, 1e-14 * drag.norm());
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
  // Springs between fixed nodes store constant energy, which the fast path omits.
  double held = 0.0;
  const SpringNetwork& network = at.problem.network();
  for (const Spring& s : network.springs) {
    if (at.problem.coordinate(s.a) >= 0 || at.problem.coordinate(s.b) >= 0) { continue; }
    const double l = (network.rest_position.col(s.b) - network.rest_position.col(s.a)).norm();
    held += 0.5 * s.stiffness * std::pow(l - s.rest_length, 2);
  }
  CHECK_NEAR(system.energy(at.q, at.v) + held, at.problem.energy(at.q, at.v), 1e-15);
  CHECK(system.zero_length_springs(at.q) >= 1);
}

constexpr int node_count = 17;

/// Every third pair of nodes is connected, in either direction, and most nodes are connected to one
/// or two fixed nodes.
template <class Real> SpringSet<Real> some_springs(int spacing = 3) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0.5, 2.0);
  const auto number = [&] { return static_cast<Real>(any(random)); };
  SpringSet<Real> springs;
  int last = node_count;
  for (int a = 0; a < node_count; ++a) {
    for (int b = 0; b < node_count; ++b) {
      if (a == b || (a + 2 * b) % 3 != 0) { continue; }
      springs.links.push_back({spacing * a, spacing * b, number(), number(), number()});
    }
    for (int n = 0; n < a % 3; ++n) {
      springs.anchors.push_back({spacing * a,
                                 spacing * last++,
                                 number(),
                                 number(),
                                 number(),
                                 0,
                                 {number(), -number(), number()}});
    }
  }
  return springs;
}

template <class Real> struct Motion {
  Vector<Real> q = Vector<Real>::Random(3 * node_count);
  Vector<Real> v = Vector<Real>::Random(3 * node_count);
};

template <class Real>
Vector<Real> plain_forces(SpringSet<Real> springs, const Motion<Real>& motion, bool damped) {
  if (!damped) {
    for (Link<Real>& s : springs.links) { s.viscosity = Real(0); }
    for (Anchor<Real>& s : springs.anchors) { s.viscosity = Real(0); }
  }
  Vector<Real> f = Vector<Real>::Constant(3 * node_count, Real(0.25));
  add_forces(springs, motion.q.data(), motion.v.data(), f.data());
  return f;
}

/// Vector with a zero after every three numbers, and space for `further` more nodes.
template <class Real> Vector<Real> with_padding(const Vector<Real>& packed, std::size_t further) {
  Vector<Real> padded =
      Vector<Real>::Zero(packed.size() / 3 * 4 + 4 * static_cast<Eigen::Index>(further));
  for (Eigen::Index n = 0; n < packed.size() / 3; ++n) {
    padded.template segment<3>(4 * n) = packed.template segment<3>(3 * n);
  }
  return padded;
}

/// Padded vectors give the same result except for the order in which 0.25 is added, and keep zeros.
template <class Real>
void compare_padded(const adjacency::Kernels<Real>& kernels, bool damped,
                    const Motion<Real>& motion, const Vector<Real>& packed, double energy_there) {
  const SpringSet<Real> springs = some_springs<Real>(adjacency::node_stride);
  const std::size_t places = springs.anchors.size();
  Vector<Real> q = with_padding(motion.q, places);
  for (const Anchor<Real>& s : springs.anchors) { std::ranges::copy(s.place, q.data() + s.b); }
  const Vector<Real> v = with_padding(motion.v, places);
  Vector<Real> f = with_padding<Real>(Vector<Real>::Constant(3 * node_count, Real(0.25)), places);
  AdjacencySprings<Real> groups(kernels);
  groups.take(springs, damped, adjacency::node_stride);
  CHECK(groups.measure(q.data(), v.data(), f.data()) == energy_there);
  for (Eigen::Index n = 0; n < node_count; ++n) {
    const auto difference = f.template segment<3>(4 * n) - packed.template segment<3>(3 * n);
    CHECK_NEAR(static_cast<double>(difference.template lpNorm<Eigen::Infinity>()), 0.0,
               40.0 * 10.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()));
    CHECK(f(4 * n + 3) == Real(0));
  }
}

template <class Real> void compare(const adjacency::Kernels<Real>& kernels, bool damped) {
  SpringSet<Real> springs = some_springs<Real>();
  const Motion<Real> motion;
  AdjacencySprings<Real> groups(kernels);
  groups.take(springs, damped, 3);
  Vector<Real> f = Vector<Real>::Constant(3 * node_count, Real(0.25));
  Vector<Real> measured = f;
  groups.add(motion.q.data(), motion.v.data(), f.data());
  // About twenty springs per node, each rounded a few times, with forces of up to ten.
  const double rounding = 100.0 * 20.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  const Eigen::VectorXd plain = plain_forces(springs, motion, damped).template cast<double>();
  CHECK_NEAR(Eigen::VectorXd(f.template cast<double>()), plain, rounding);
  const double energy = groups.measure(motion.q.data(), motion.v.data(), measured.data());
  CHECK(measured == f);
  compare_padded(kernels, damped, motion, f, energy);
  double expected = 0.0;
  const Eigen::VectorXd q = motion.q.template cast<double>();
  const auto place = [&](int at) { return q.segment<3>(at); };
  const auto add = [&](const auto& s, double length) {
    const double extension = length - static_cast<double>(s.rest_length);
    expected += 0.5 * static_cast<double>(s.stiffness) * extension * extension;
  };
  for (const Link<Real>& s : springs.links) { add(s, (place(s.b) - place(s.a)).norm()); }
  for (const Anchor<Real>& s : springs.anchors) {
    const Eigen::Map<const Eigen::Matrix<Real, 3, 1>> far(s.place);
    add(s, (far.template cast<double>() - place(s.a)).norm());
  }
  CHECK_NEAR(energy / expected, 1.0, rounding);
}

/// One spring of stiffness 1 each, of rest length 0 (energy: half the length squared) or 1e6
/// (force: 1 - 1e6 / length).
template <class Real> void compare_lengths(const adjacency::Kernels<Real>& kernels) {
  constexpr double rounding = 0.5 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-6.0, 2.0);
  for (int n = 0; n < 200; ++n) {
    const Real x = static_cast<Real>(std::pow(10.0, exponent(random)));
    const double length = static_cast<double>(x);
    const Vector<Real> v = Vector<Real>::Zero(6);
    Vector<Real> q = v;
    q(3) = x;
    const auto spring = [&](Real rest) {
      SpringSet<Real> springs;
      springs.links.push_back({0, 3, Real(1), Real(0), rest});
      return springs;
    };
    Vector<Real> f = v;
    AdjacencySprings<Real> slack(kernels);
    slack.take(spring(Real(0)), true, 3);
    const double energy = slack.measure(q.data(), v.data(), f.data());
    // Square and product are rounded, and the length by two of its own, twice.
    CHECK_NEAR(energy / (0.5 * length * length), 1.0, 8.0 * rounding);
    f.setZero();
    AdjacencySprings<Real> pressed(kernels);
    pressed.take(spring(Real(1e6)), true, 3);
    pressed.add(q.data(), v.data(), f.data());
    // Square, length, difference, inverse and two products.
    CHECK_NEAR(static_cast<double>(f(0)) / (length - 1e6), 1.0, 10.0 * rounding);
  }
}

TEST("springs in adjacency groups exert the forces of single springs and store the same energy") {
  for (const bool damped : {true, false}) {
    for (const auto& kernels : adjacency_kernels<double>()) { compare(kernels, damped); }
    for (const auto& kernels : adjacency_kernels<float>()) { compare(kernels, damped); }
  }
}

TEST("lengths and their inverses are good to two roundings with every instruction set") {
  for (const auto& kernels : adjacency_kernels<double>()) { compare_lengths(kernels); }
  for (const auto& kernels : adjacency_kernels<float>()) { compare_lengths(kernels); }
}

TEST("a spring without length exerts no force, and only nodes that are not finite spread NaN") {
  SpringSet<double> springs;
  springs.links.push_back({0, 3, 1.0, 1.0, 0.5});
  AdjacencySprings<double> groups;
  groups.take(springs, true, 3);
  VectorXd q = VectorXd::Zero(6);
  const VectorXd v = VectorXd::Ones(6);
  VectorXd f = VectorXd::Zero(6);
  groups.add(q.data(), v.data(), f.data());
  CHECK(f == VectorXd::Zero(6));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  q(0) = nan;
  groups.add(q.data(), v.data(), f.data());
  CHECK(!f.allFinite());
  for (const int lost : {0, 1}) {
    SpringSet<double> anchored;
    for (const int n : {0, 1}) {
      anchored.anchors.push_back(
          {3 * n, 6 + 3 * n, 1.0, 0.0, 0.5, 0, {n == lost ? nan : 1.0, 0.0, 0.0}});
    }
    AdjacencySprings<double> held;
    held.take(anchored, true, 3);
    const VectorXd still = VectorXd::Zero(6);
    f.setZero();
    held.add(still.data(), still.data(), f.data());
    CHECK(std::isnan(f(3 * lost)));
    CHECK(f(3 * (1 - lost)) == 0.5);
  }
}

}  // namespace PALPATE_FILE

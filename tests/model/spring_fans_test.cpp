// SPDX-License-Identifier: MIT
#include "model/stepping/spring_fans.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "model/stepping/system.hpp"
#include "tests/check.hpp"

using namespace palpate;

namespace {

constexpr int node_count = 17;

/// Every third pair of nodes is joined, in either direction, and most nodes to one or two fixed places.
template <class Real>
SpringSet<Real> some_springs(int spacing = 3) {
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
      springs.anchors.push_back(
          {spacing * a, spacing * last++, number(), number(), number(), {number(), -number(), number()}});
    }
  }
  return springs;
}

template <class Real>
struct Motion {
  Vector<Real> q = Vector<Real>::Random(3 * node_count);
  Vector<Real> v = Vector<Real>::Random(3 * node_count);
};

template <class Real>
Vector<Real> plain_forces(SpringSet<Real>& springs, const Motion<Real>& motion, bool damped) {
  Vector<Real> f = Vector<Real>::Constant(3 * node_count, Real(0.25));
  spring_kernel_for<Real>({.damped = damped})(springs, motion.q.data(), motion.v.data(), f.data());
  return f;
}

/// A vector with a zero after every three numbers, and room for `further` more nodes.
template <class Real>
Vector<Real> in_quads(const Vector<Real>& packed, std::size_t further) {
  Vector<Real> quads = Vector<Real>::Zero(packed.size() / 3 * 4 + 4 * static_cast<Eigen::Index>(further));
  for (Eigen::Index n = 0; n < packed.size() / 3; ++n) {
    quads.template segment<3>(4 * n) = packed.template segment<3>(3 * n);
  }
  return quads;
}

/// Vectors of quads give the same, but for the order in which 0.25 is added, and leave zeros zero.
template <class Real>
void compare_quads(const fans::Kernels<Real>& kernels, bool damped, const Motion<Real>& motion,
                   const Vector<Real>& packed, double energy_there) {
  const SpringSet<Real> springs = some_springs<Real>(fans::quad);
  const std::size_t places = springs.anchors.size();
  Vector<Real> q = in_quads(motion.q, places);
  for (const Anchor<Real>& s : springs.anchors) { std::ranges::copy(s.place, q.data() + s.b); }
  const Vector<Real> v = in_quads(motion.v, places);
  Vector<Real> f = in_quads<Real>(Vector<Real>::Constant(3 * node_count, Real(0.25)), places);
  SpringFans<Real> fans(kernels);
  fans.take(springs, damped, fans::quad);
  CHECK(fans.measure(q.data(), v.data(), f.data()) == energy_there);
  for (Eigen::Index n = 0; n < node_count; ++n) {
    const auto difference = f.template segment<3>(4 * n) - packed.template segment<3>(3 * n);
    CHECK_NEAR(static_cast<double>(difference.template lpNorm<Eigen::Infinity>()), 0.0,
               40.0 * 10.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()));
    CHECK(f(4 * n + 3) == Real(0));
  }
}

template <class Real>
void compare(const fans::Kernels<Real>& kernels, bool damped) {
  SpringSet<Real> springs = some_springs<Real>();
  const Motion<Real> motion;
  SpringFans<Real> fans(kernels);
  fans.take(springs, damped, 3);
  Vector<Real> f = Vector<Real>::Constant(3 * node_count, Real(0.25));
  Vector<Real> measured = f;
  fans.add(motion.q.data(), motion.v.data(), f.data());
  // Some twenty springs pull at a node, each rounded a few times, with forces of up to ten.
  const double rounding = 100.0 * 20.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  const Eigen::VectorXd plain = plain_forces(springs, motion, damped).template cast<double>();
  CHECK_NEAR(Eigen::VectorXd(f.template cast<double>()), plain, rounding);
  const double energy = fans.measure(motion.q.data(), motion.v.data(), measured.data());
  CHECK(measured == f);
  compare_quads(kernels, damped, motion, f, energy);
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

/// One spring of stiffness 1 each, of rest length 0 (energy: half the length squared) or 1e6 (force: 1 - 1e6 / length).
template <class Real>
void compare_lengths(const fans::Kernels<Real>& kernels) {
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
    SpringFans<Real> slack(kernels);
    slack.take(spring(Real(0)), true, 3);
    const double energy = slack.measure(q.data(), v.data(), f.data());
    // Square and product are rounded, and the length by two of its own, twice.
    CHECK_NEAR(energy / (0.5 * length * length), 1.0, 8.0 * rounding);
    f.setZero();
    SpringFans<Real> pressed(kernels);
    pressed.take(spring(Real(1e6)), true, 3);
    pressed.add(q.data(), v.data(), f.data());
    // Square, length, difference, inverse and two products.
    CHECK_NEAR(static_cast<double>(f(0)) / (length - 1e6), 1.0, 10.0 * rounding);
  }
}

}  // namespace

TEST("springs in fans pull as they do one by one, and store the same energy") {
  for (const bool damped : {true, false}) {
    for (const auto& kernels : fan_kernels<double>()) { compare(kernels, damped); }
    for (const auto& kernels : fan_kernels<float>()) { compare(kernels, damped); }
  }
}

TEST("lengths and their inverses are good to two roundings with every instruction set") {
  for (const auto& kernels : fan_kernels<double>()) { compare_lengths(kernels); }
  for (const auto& kernels : fan_kernels<float>()) { compare_lengths(kernels); }
}

TEST("a spring without length exerts no force, and a force that is not finite is not hidden") {
  SpringSet<double> springs;
  springs.links.push_back({0, 3, 1.0, 1.0, 0.5});
  SpringFans<double> fans;
  fans.take(springs, true, 3);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  const Eigen::VectorXd v = Eigen::VectorXd::Ones(6);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(6);
  fans.add(q.data(), v.data(), f.data());
  CHECK(f == Eigen::VectorXd::Zero(6));
  q(0) = std::numeric_limits<double>::quiet_NaN();
  fans.add(q.data(), v.data(), f.data());
  CHECK(!f.allFinite());
}

TEST("an anchor at a place that is not a number says so, and others do not") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const int lost : {0, 1}) {
    SpringSet<double> springs;
    for (const int n : {0, 1}) {
      springs.anchors.push_back({3 * n, 6 + 3 * n, 1.0, 0.0, 0.5, {n == lost ? nan : 1.0, 0.0, 0.0}});
    }
    SpringFans<double> fans;
    fans.take(springs, true, 3);
    const Eigen::VectorXd still = Eigen::VectorXd::Zero(6);
    Eigen::VectorXd f = still;
    fans.add(still.data(), still.data(), f.data());
    CHECK(std::isnan(f(3 * lost)));
    CHECK(f(3 * (1 - lost)) == 0.5);
  }
}

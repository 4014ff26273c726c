// SPDX-License-Identifier: MIT
#pragma once
/// Vector aligned to a cache line, so that no SIMD load crosses two lines.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <memory>
#include <new>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate {

/// Allocates at the beginning of a cache line.
template <class Value> struct CacheLineAllocator {
  using value_type = Value;
  static constexpr std::align_val_t alignment{64};
  CacheLineAllocator() = default;
  template <class Other> CacheLineAllocator(const CacheLineAllocator<Other>& /*other*/) noexcept {}
  [[nodiscard]] Value* allocate(std::size_t count) {
    return static_cast<Value*>(::operator new(count * sizeof(Value), alignment));
  }
  void deallocate(Value* at, std::size_t count) noexcept {
    ::operator delete(at, count * sizeof(Value), alignment);
  }
  bool operator==(const CacheLineAllocator& /*other*/) const noexcept { return true; }
};
template <class Real> using AlignedVector = std::vector<Real, CacheLineAllocator<Real>>;

/// Layout of the node coordinates in the state vectors of the integrators.
struct NodeLayout {
  Eigen::Index size = 0;     ///< length of a vector of all coordinates, without that of a tool
  Eigen::Index stride = 1;   ///< offset from a node's x to its y, and from y to z
  std::vector<int> first{};  ///< index of each node's x; -1 for a fixed node
};

/// Returns the three coordinates of a node with its x at index `first`.
template <class Real>
auto at_node(const Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, Eigen::Index first,
             Eigen::Index stride) noexcept {
  return Eigen::Map<const Eigen::Matrix<Real, 3, 1>, 0, Eigen::InnerStride<>>(
      all.data() + first, Eigen::InnerStride<>(stride));
}
template <class Real>
auto at_node(Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, Eigen::Index first,
             Eigen::Index stride) noexcept {
  return Eigen::Map<Eigen::Matrix<Real, 3, 1>, 0, Eigen::InnerStride<>>(
      all.data() + first, Eigen::InnerStride<>(stride));
}

/// Copies the coordinates of the free nodes to a packed vector in the order of a Problem.
template <class Real>
void gather(const Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, const NodeLayout& layout,
            Eigen::Ref<Eigen::VectorXd> packed) noexcept {
  Eigen::Index n = 0;
  for (const Eigen::Index first : layout.first) {
    if (first < 0) { continue; }
    packed.segment<3>(n) = at_node(all, first, layout.stride).template cast<double>();
    n += 3;
  }
}
/// Copies a packed vector back; elements of no free node are unchanged.
template <class Real>
void scatter(const Eigen::VectorXd& packed, const NodeLayout& layout,
             Eigen::Matrix<Real, Eigen::Dynamic, 1>& all) noexcept {
  Eigen::Index n = 0;
  for (const Eigen::Index first : layout.first) {
    if (first < 0) { continue; }
    at_node(all, first, layout.stride) = packed.segment<3>(n).template cast<Real>();
    n += 3;
  }
}

template <class Real> using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// Returns the index of an entry in the values of a compressed matrix whose pattern contains it.
template <class Real>
std::ptrdiff_t slot_of(const Eigen::SparseMatrix<Real>& a, Eigen::Index row, Eigen::Index column) {
  const int* begin = a.innerIndexPtr() + a.outerIndexPtr()[column];
  const int* end = a.innerIndexPtr() + a.outerIndexPtr()[column + 1];
  return std::lower_bound(begin, end, static_cast<int>(row)) - a.innerIndexPtr();
}

template <class Real> struct State {
  Vector<Real> position;  ///< q [m]
  Vector<Real> velocity;  ///< staggered schemes store the velocity at the half step [m/s]
};

/// System that an integrator advances: M q'' = f(t, q, q') in the precision of the stepping. Only
/// constructors and the functions that say so allocate.
template <class Real> class System {
 public:
  virtual ~System() = default;
  [[nodiscard]] Eigen::Index dof() const { return inverse_mass().size(); }
  [[nodiscard]] const Vector<Real>& inverse_mass() const { return masses_->inverse; }  ///< [1/kg]
  [[nodiscard]] const Vector<Real>& mass() const { return masses_->mass; }             ///< [kg]

  /// Computes f [N]; the loads that are active at `gate`, the beginning of the step, act.
  virtual void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                     Vector<Real>& f) noexcept = 0;
  /// Adds `weight` times the loads, for schemes whose kick spans two steps.
  virtual void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept = 0;
  /// Computes C(q) w [N], the resistance of the dampers to velocity w.
  virtual void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept = 0;
  /// Returns false if damping() is always zero.
  [[nodiscard]] virtual bool has_dampers() const { return true; }
  /// Takes a semi-implicit Euler step in one pass over memory, if has_one_pass(), and returns the
  /// sum of squares of the new velocities.
  [[nodiscard]] virtual bool has_one_pass() const { return false; }
  virtual void prepare_one_pass() {}  ///< allocates
  virtual double one_pass(double /*t*/, double /*gate*/, Real /*h*/,
                          State<Real>& /*state*/) noexcept {
    assert(!"this system has none");
    return 0.0;
  }
  /// Computes A = M + on_damping C + on_stiffness K in a matrix from `pattern`.
  virtual void jacobian(const Vector<Real>& /*q*/, const Vector<Real>& /*v*/, Real /*on_damping*/,
                        Real /*on_stiffness*/, Eigen::SparseMatrix<Real>& /*a*/) noexcept {
    assert(!"only systems for implicit schemes have matrices");
  }
  virtual void pattern(Eigen::SparseMatrix<Real>& /*a*/) {  ///< allocates
    assert(!"only systems for implicit schemes have matrices");
  }
  /// Returns the positions at rest of the nodes whose coordinates come first, three each, for the
  /// order of elimination; no columns: the order of the coordinates.
  [[nodiscard]] virtual NodeVectors places() const { return NodeVectors(3, 0); }
  /// Changes product = A x to the product under the active contact constraints.
  virtual void hold(const Vector<Real>& /*x*/, Vector<Real>& /*product*/) noexcept {}
  /// Computes the constraint compliance before the first step; `solve` applies P^-1. Allocates.
  virtual void learn_compliance(
      const std::function<void(const Vector<Real>&, Vector<Real>&)>& /*solve*/) {}
  /// Returns a number that changes with the set of active constraints.
  [[nodiscard]] virtual long constraint_set() const noexcept { return 0; }
  /// Prepares the constraints for one linear solve; call it before the products.
  virtual void begin_linear_solve() noexcept {}
  /// Changes solution = P^-1 r to the solution under the active contact constraints.
  virtual void constrain_solution(const Vector<Real>& /*r*/, Vector<Real>& /*solution*/) noexcept {}

  void acceleration(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                    Vector<Real>& a) noexcept {
    force(t, gate, q, v, a);
    a.array() *= inverse_mass().array();
  }

 protected:
  /// Sets the masses; coordinates with zero mass never move.
  void set_mass(const Eigen::VectorXd& mass) {
    const auto inverse = mass.unaryExpr([](double m) { return m == 0.0 ? 0.0 : 1.0 / m; });
    masses_ =
        std::make_shared<const Masses>(Masses{mass.cast<Real>(), inverse.template cast<Real>()});
  }
  /// Uses the masses of another system with the same coordinates.
  void share_mass(const System& other) { masses_ = other.masses_; }

 private:
  struct Masses {
    Vector<Real> mass;
    Vector<Real> inverse;
  };
  std::shared_ptr<const Masses> masses_ = std::make_shared<const Masses>();
};

/// Single spring-mass-damper. The drive does not switch, so the activation time has no effect.
template <class Real> class OscillatorSystem final : public System<Real> {
 public:
  explicit OscillatorSystem(const Oscillator& oscillator) : o_(oscillator) {
    this->set_mass(Eigen::VectorXd::Constant(1, oscillator.mass));
  }
  void force(double t, double /*gate*/, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    f(0) = static_cast<Real>(drive(t)) - static_cast<Real>(o_.stiffness) * q(0) -
           static_cast<Real>(o_.viscosity) * v(0);
  }
  void add_loads(double t, double /*gate*/, Real weight, Vector<Real>& f) noexcept override {
    f(0) += weight * static_cast<Real>(drive(t));
  }
  void damping(const Vector<Real>& /*q*/, const Vector<Real>& w,
               Vector<Real>& f) noexcept override {
    f(0) = static_cast<Real>(o_.viscosity) * w(0);
  }
  void jacobian(const Vector<Real>& /*q*/, const Vector<Real>& /*v*/, Real on_damping,
                Real on_stiffness, Eigen::SparseMatrix<Real>& a) noexcept override {
    a.valuePtr()[0] = static_cast<Real>(o_.mass) + on_damping * static_cast<Real>(o_.viscosity) +
                      on_stiffness * static_cast<Real>(o_.stiffness);
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    a.resize(1, 1);
    a.insert(0, 0) = Real(0);
    a.makeCompressed();
  }
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept {
    const double x = static_cast<double>(q(0));
    const double speed = static_cast<double>(v(0));
    return 0.5 * o_.mass * speed * speed + 0.5 * o_.stiffness * x * x;
  }

 private:
  [[nodiscard]] double drive(double t) const noexcept {
    return o_.drive_amplitude == 0.0 ? 0.0 : o_.drive_amplitude * std::cos(o_.drive_frequency * t);
  }
  Oscillator o_;
};

}  // namespace palpate

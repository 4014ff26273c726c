// SPDX-License-Identifier: MIT
#pragma once
/// Numbers that kernels read: they begin where a cache line does, so that no register is loaded
/// from two lines.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cassert>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate {

static_assert(EIGEN_DEFAULT_ALIGN_BYTES >= 64,
              "compile with EIGEN_MAX_ALIGN_BYTES=64, as palpate_build_options does");

template <class Real> using AlignedVector = std::vector<Real, Eigen::aligned_allocator<Real>>;

// Where the coordinates of nodes stand in the vectors of the stepping. Kernels choose it; all else
// asks it.

struct NodeLayout {
  Eigen::Index size = 0;              ///< of a vector of all coordinates, without that of a tool
  Eigen::Index stride = 1;            ///< from a node's x to its y, and from y to z
  std::vector<Eigen::Index> first{};  ///< of each node's x; -1 for a fixed node
};

/// The three coordinates of a node whose x stands at `first`.
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

/// Coordinates of the free nodes in their order, three each, as a Problem has them.
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
/// And back; what belongs to no free node stays as it is.
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

// What an integrator sees of a scene: M q'' = f(t, q, q') in the precision of the stepping.
// Everything is allocated on construction; calls after that allocate nothing.

template <class Real> using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

template <class Real> struct State {
  Vector<Real> position;  ///< q [m]
  Vector<Real> velocity;  ///< [m/s]; schemes that stagger hold the one of their half step
};

template <class Real> class System {
 public:
  virtual ~System() = default;
  [[nodiscard]] Eigen::Index dof() const { return inverse_mass().size(); }
  [[nodiscard]] const Vector<Real>& inverse_mass() const { return masses_->inverse; }  ///< [1/kg]
  [[nodiscard]] const Vector<Real>& mass() const { return masses_->mass; }             ///< [kg]

  /// f [N]; `gate` is the beginning of the step, which decides the loads that act.
  virtual void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                     Vector<Real>& f) noexcept = 0;
  /// Adds weight times the loads alone, for schemes whose kick straddles two steps.
  virtual void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept = 0;
  /// C(q) w [N]: what the dampers would resist velocity w with.
  virtual void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept = 0;
  /// Whether damping() is ever anything but zero.
  [[nodiscard]] virtual bool has_dampers() const { return true; }
  /// A whole step of semi-implicit Euler in one pass over memory, for systems that say they have
  /// one; returns the sum of squares of the new velocities.
  [[nodiscard]] virtual bool has_one_pass() const { return false; }
  virtual void prepare_one_pass() {}  ///< allocates
  virtual double one_pass(double /*t*/, double /*gate*/, Real /*h*/,
                          State<Real>& /*state*/) noexcept {
    assert(!"this system has none");
    return 0.0;
  }
  /// A = M + on_damping C + on_stiffness K, K = -df/dq and C = -df/dv, into a matrix that
  /// `pattern` made.
  virtual void jacobian(const Vector<Real>& /*q*/, const Vector<Real>& /*v*/, Real /*on_damping*/,
                        Real /*on_stiffness*/, Eigen::SparseMatrix<Real>& /*a*/) noexcept {
    assert(!"only systems for implicit schemes have matrices");
  }
  virtual void pattern(Eigen::SparseMatrix<Real>& /*a*/) {  ///< allocates
    assert(!"only systems for implicit schemes have matrices");
  }
  /// product = A x becomes that of the Jacobian with what sticks to a tool held; see force().
  virtual void hold(const Vector<Real>& /*x*/, Vector<Real>& /*product*/) noexcept {}
  /// Before the first step: `solve` is P^-1 of a preconditioner that knows nothing of what sticks.
  virtual void learn_compliance(
      const std::function<void(const Vector<Real>&, Vector<Real>&)>& /*solve*/) {}
  /// Before the products of one linear solve.
  virtual void begin_linear_solve() noexcept {}
  /// solution = P^-1 r becomes that with what sticks held.
  virtual void constrain_solution(const Vector<Real>& /*r*/, Vector<Real>& /*solution*/) noexcept {}

  void acceleration(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                    Vector<Real>& a) noexcept {
    force(t, gate, q, v, a);
    a.array() *= inverse_mass().array();
  }

 protected:
  /// What has no mass never moves.
  void set_mass(const Eigen::VectorXd& mass) {
    const auto inverse = mass.unaryExpr([](double m) { return m == 0.0 ? 0.0 : 1.0 / m; });
    masses_ =
        std::make_shared<const Masses>(Masses{mass.cast<Real>(), inverse.template cast<Real>()});
  }
  /// Those of another system with the same coordinates.
  void share_mass(const System& other) { masses_ = other.masses_; }

 private:
  struct Masses {
    Vector<Real> mass;
    Vector<Real> inverse;
  };
  std::shared_ptr<const Masses> masses_ = std::make_shared<const Masses>();
};

// The single spring-mass-damper as an integrator sees it.

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
  /// The drive never switches, so both halves of a kick see the same and nothing changes.
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

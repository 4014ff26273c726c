// SPDX-License-Identifier: MIT
#pragma once
/// What an integrator sees of a scene: M q'' = f(t, q, q') in the precision of the stepping.
/// Everything is allocated on construction; calls after that allocate nothing.

#include <cassert>
#include <functional>
#include <memory>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace palpate {

template <class Real>
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

template <class Real>
struct State {
  Vector<Real> position;  ///< q [m]
  Vector<Real> velocity;  ///< [m/s]; schemes that stagger hold the one of their half step
};

template <class Real>
class System {
 public:
  virtual ~System() = default;
  [[nodiscard]] Eigen::Index dof() const { return inverse_mass().size(); }
  [[nodiscard]] const Vector<Real>& inverse_mass() const { return masses_->inverse; }  ///< [1/kg]
  [[nodiscard]] const Vector<Real>& mass() const { return masses_->mass; }          ///< [kg]

  /// f [N]; `gate` is the beginning of the step, which decides the loads that act.
  virtual void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                     Vector<Real>& f) noexcept = 0;
  /// Adds weight times the loads alone, for schemes whose kick straddles two steps.
  virtual void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept = 0;
  /// C(q) w [N]: what the dampers would resist velocity w with.
  virtual void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept = 0;
  /// Whether damping() is ever anything but zero.
  [[nodiscard]] virtual bool has_dampers() const { return true; }
  /// A whole step of semi-implicit Euler in one pass over memory, for systems that say they have one; returns
  /// the sum of squares of the new velocities.
  [[nodiscard]] virtual bool has_one_pass() const { return false; }
  virtual void prepare_one_pass() {}  ///< allocates
  virtual double one_pass(double /*t*/, double /*gate*/, Real /*h*/, State<Real>& /*state*/) noexcept {
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
  virtual void learn_response(
      const std::function<void(const Vector<Real>&, Vector<Real>&)>& /*solve*/) {}
  /// Before the products of one linear solve.
  virtual void begin_holding() noexcept {}
  /// solution = P^-1 r becomes that with what sticks held.
  virtual void hold_solution(const Vector<Real>& /*r*/, Vector<Real>& /*solution*/) noexcept {}

  void acceleration(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                    Vector<Real>& a) noexcept {
    force(t, gate, q, v, a);
    a.array() *= inverse_mass().array();
  }

 protected:
  /// What has no mass never moves.
  void set_mass(const Eigen::VectorXd& mass) {
    const auto inverse = mass.unaryExpr([](double m) { return m == 0.0 ? 0.0 : 1.0 / m; });
    masses_ = std::make_shared<const Masses>(Masses{mass.cast<Real>(), inverse.template cast<Real>()});
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

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "reference/haptic_loop.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/problem/problem.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

namespace {

/// Returns the coefficients of the characteristic polynomial, highest power first, in extended
/// precision.
std::vector<long double> characteristic(const WallLoop& loop, double stiffness) {
  const long double b = loop.viscosity;
  const long double period = loop.period;
  const long double tau = loop.mass / b;
  const long double one_less_a = -std::expm1(-period / tau);
  const long double a = 1.0L - one_less_a;
  const long double n1 = (period - tau * one_less_a) / b;
  const long double n0 = (tau * one_less_a - period * a) / b;
  const long double h1 = stiffness + loop.damping / period;
  const long double h0 = -loop.damping / period;
  std::vector<long double> p(static_cast<std::size_t>(loop.delay) + 4, 0.0L);
  p[0] = 1.0L;
  p[1] = -(1.0L + a);
  p[2] = a;
  const std::size_t last = p.size() - 1;
  p[last - 2] += n1 * h1;
  p[last - 1] += n1 * h0 + n0 * h1;
  p[last] += n0 * h0;
  return p;
}

}  // namespace

double largest_root(const WallLoop& loop, double stiffness) {
  std::vector<long double> p = characteristic(loop, stiffness);
  while (p.size() > 1 && p.back() == 0.0L) { p.pop_back(); }  // roots at zero
  const auto degree = static_cast<Eigen::Index>(p.size()) - 1;
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix companion = Matrix::Zero(degree, degree);
  for (Eigen::Index n = 0; n < degree; ++n) {
    companion(0, n) = -p[static_cast<std::size_t>(n) + 1];
    if (n > 0) { companion(n, n - 1) = 1.0L; }
  }
  return static_cast<double>(companion.eigenvalues().cwiseAbs().maxCoeff());
}

double critical_stiffness(const WallLoop& loop) {
  // Without a wall the root at 1 is the rigid motion; any small K must move it inside.
  double low = 1e-9 * loop.viscosity / loop.period;
  if (!(largest_root(loop, low) < 1.0)) { return 0.0; }
  double high = low;
  while (largest_root(loop, high) < 1.0) { high *= 2.0; }
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    (largest_root(loop, middle) < 1.0 ? low : high) = middle;
  }
  return low;
}

double passive_stiffness(const WallLoop& loop) {
  return 2.0 * (loop.viscosity - std::abs(loop.damping)) / loop.period;
}

double linear_rule(const WallLoop& loop) {
  return (loop.viscosity + loop.damping) / ((0.5 + loop.delay) * loop.period);
}

double quantised_stiffness(const WallLoop& loop, double encoder_step, double coulomb_friction) {
  return std::min(2.0 * loop.viscosity / loop.period, 2.0 * coulomb_friction / encoder_step);
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Returns theta1 of one leg while the grip moves from `place` [m] with constant `velocity` [m/s].
Taylor arm_angle(const LegLengths& legs, double azimuth, const Vector3d& place,
                 const Vector3d& velocity) {
  const double c = std::cos(azimuth);
  const double s = std::sin(azimuth);
  const auto along = [&](double on_x, double on_y) {
    return Taylor{on_x * place.x() + on_y * place.y(), on_x * velocity.x() + on_y * velocity.y()};
  };
  const Taylor knee = along(c, s) + -legs.radial;  // u + c of the effector
  const Taylor side = along(-s, c) + (legs.effector_lateral - legs.base_lateral);
  const Taylor height{place.z(), velocity.z()};
  const Taylor cosine = (1.0 / legs.shin) * side;
  const Taylor reach = legs.shin * sqrt(-1.0 * (cosine * cosine) + 1.0) + legs.link;
  const Taylor far2 = knee * knee + height * height;
  const Taylor bend =
      (far2 + legs.arm * legs.arm - reach * reach) * inverse(2.0 * legs.arm * sqrt(far2));
  return angle(height, knee) - acos(bend);
}

struct Arms {
  Matrix3d slope{};      ///< d(theta1)/d(place) [rad/m]
  Vector3d curvature{};  ///< theta1'' at constant velocity of the grip [rad/s^2]
};

Arms arms_of(const LegLengths& legs, const Vector3d& place, const Vector3d& velocity) {
  Arms arms;
  for (int leg = 0; leg < 3; ++leg) {
    const double azimuth = legs.azimuth[static_cast<std::size_t>(leg)];
    for (int axis = 0; axis < 3; ++axis) {
      arms.slope(leg, axis) = arm_angle(legs, azimuth, place, Vector3d::Unit(axis)).first;
    }
    arms.curvature(leg) = arm_angle(legs, azimuth, place, velocity).second;
  }
  return arms;
}

/// Grip and network between two ticks. The coordinates of the grip have unit mass, so that their
/// force is their acceleration.
class BetweenTicks final : public Problem {
 public:
  BetweenTicks(const HeldTool& held, const SpringNetwork& network)
      : held_(held), tissue_(network), tip_(tissue_.coordinate(0) + 2) {
    mass_.setOnes(3 + tissue_.dof());
    mass_.tail(tissue_.dof()) = tissue_.mass();
    mass_(3 + tip_) += held.tool_mass;
    place_.setZero(mass_.size());
    velocity_.setZero(mass_.size());
    place_.head(3) = held.start;
    place_.tail(tissue_.dof()) = tissue_.initial_position();
    rest_ = place_(3 + tip_);
  }

  [[nodiscard]] Eigen::Index dof() const override { return mass_.size(); }
  [[nodiscard]] const VectorXd& mass() const override { return mass_; }
  [[nodiscard]] VectorXd initial_position() const override { return place_; }
  [[nodiscard]] VectorXd initial_velocity() const override { return velocity_; }
  [[nodiscard]] std::vector<double> breaks() const override { return {}; }
  [[nodiscard]] double shortest_feature() const override { return held_.period; }
  [[nodiscard]] double energy(const Eigen::Ref<const VectorXd>&,
                              const Eigen::Ref<const VectorXd>&) const override {
    return std::numeric_limits<double>::quiet_NaN();
  }
  void jacobian(const Eigen::Ref<const VectorXd>&, const Eigen::Ref<const VectorXd>&,
                Eigen::SparseMatrix<double>&, Eigen::SparseMatrix<double>&) const override {
    throw SolverError("held tool: has no Jacobian; must be solved by Adams");
  }

  void force(double t, double gate, const Eigen::Ref<const VectorXd>& q,
             const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> f) const override {
    const Vector3d place = q.head<3>();
    const Vector3d velocity = v.head<3>();
    Vector3d wanted;
    Vector3d wanted_velocity;
    held_.intent(begin_ + t, wanted, wanted_velocity);
    const Vector3d hand = held_.hand_stiffness * (wanted - place) +
                          held_.hand_viscosity * (wanted_velocity - velocity);
    const Arms arms = arms_of(held_.legs, place, velocity);
    const double left = held_.motor_lag > 0.0 ? std::exp(-t / held_.motor_lag) : 0.0;
    const Vector3d torque = target_ + left * (torque_ - target_);
    const Matrix3d inertia = held_.grip_mass * Matrix3d::Identity() +
                             held_.arm_inertia * arms.slope.transpose() * arms.slope;
    const Vector3d push =
        hand + arms.slope.transpose() * (torque - held_.arm_inertia * arms.curvature);
    f.head<3>() = inertia.inverse() * push;
    const Eigen::Index n = tissue_.dof();
    VectorXd tissue(n);
    tissue_.force(t, gate, q.tail(n), v.tail(n), tissue);
    f.tail(n) = tissue;
    f(3 + tip_) += held_.coupling_stiffness * (handle_ - (q(3 + tip_) - rest_)) +
                   held_.coupling_viscosity * (handle_velocity_ - v(3 + tip_));
  }

  /// Samples a tick: reads the position, computes the force, and sets the torques of the force
  /// sent.
  Vector3d sample(bool first) {
    const Vector3d place = grip();
    const Vector3d velocity =
        first ? Vector3d(Vector3d::Zero()) : Vector3d((place - read_) / held_.period);
    read_ = place;
    handle_ = held_.start.z() - place.z();
    handle_velocity_ = -velocity.z();
    const double push = held_.coupling_stiffness * (handle_ - tool()) +
                        held_.coupling_viscosity * (handle_velocity_ - velocity_(3 + tip_));
    return {0.0, 0.0, push};
  }
  void send(const Vector3d& force) {
    const Matrix3d slope = arms_of(held_.legs, grip(), Vector3d::Zero()).slope;
    target_ = slope.inverse().transpose() * force;
  }
  void arrive(const Trace& solution) {
    place_ = solution.position.rightCols(1);
    velocity_ = solution.velocity.rightCols(1);
    const double left = held_.motor_lag > 0.0 ? std::exp(-held_.period / held_.motor_lag) : 0.0;
    torque_ = target_ + left * (torque_ - target_);
    begin_ += held_.period;
  }
  [[nodiscard]] Vector3d grip() const { return place_.head<3>(); }
  [[nodiscard]] double tool() const { return place_(3 + tip_) - rest_; }

 private:
  const HeldTool& held_;
  NetworkProblem tissue_;
  Eigen::Index tip_;
  VectorXd mass_;
  VectorXd place_;
  VectorXd velocity_;
  double rest_ = 0.0;
  double begin_ = 0.0;
  double handle_ = 0.0;
  double handle_velocity_ = 0.0;
  Vector3d read_ = Vector3d::Zero();
  Vector3d target_ = Vector3d::Zero();
  Vector3d torque_ = Vector3d::Zero();
};

}  // namespace

Trace solve_held_tool(const HeldTool& held, const SpringNetwork& network, long ticks,
                      const Tolerance& tolerance) {
  BetweenTicks flow(held, network);
  Trace motion{.method = "cvode-adams"};
  for (const char* name : {"device.x_m", "device.y_m", "device.z_m", "tool.insertion_m"}) {
    motion.columns.push_back({name, "m", {}});
  }
  for (const char* name : {"device.command_x_n", "device.command_y_n", "device.command_z_n"}) {
    motion.columns.push_back({name, "N", {}});
  }
  std::vector<Vector3d> waiting(static_cast<std::size_t>(held.delay), Vector3d::Zero());
  for (long tick = 0; tick <= ticks; ++tick) {
    motion.time.push_back(static_cast<double>(tick) * held.period);
    const Vector3d grip = flow.grip();
    const double place = flow.tool();
    Vector3d force = flow.sample(tick == 0);
    if (!waiting.empty()) {
      std::swap(force, waiting.front());
      std::rotate(waiting.begin(), waiting.begin() + 1, waiting.end());
    }
    auto column = motion.columns.begin();
    for (const double value :
         {grip.x(), grip.y(), grip.z(), place, force.x(), force.y(), force.z()}) {
      (column++)->values.push_back(value);
    }
    flow.send(force);
    if (tick < ticks) { flow.arrive(solve_cvode_adams(flow, {0.0, held.period}, tolerance)); }
  }
  return motion;
}

}  // namespace palpate::reference

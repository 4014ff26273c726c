// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

/// Friction of a shaft that first drags the tissue along and then slides, the faster the larger the
/// force (model/EQUATIONS.md, "Creeping friction").
struct CreepingFriction {
  double travel = 0.0;    ///< delta: drag at which the force is `limit` [m], > 0
  double exponent = 0.0;  ///< nu of the speed [1]; 0: the force never exceeds the limit
  double limit = 0.0;     ///< L: force at the sliding speed of reference_speed [N]
  double force = 0.0;     ///< F at the end of the last step [N]

  static constexpr double reference_speed = 1e-3;  ///< v_1 [m/s]

  struct Response {
    double force = 0.0;  ///< [N]
    double slope = 0.0;  ///< d force / d velocity [N s/m]
  };

  /// Returns the force after h seconds [s] in which the shaft moves relative to the far tissue with
  /// a velocity [m/s]: travel (F - F_before) / L + h v_1 (F / L)^(1/nu) = h velocity.
  [[nodiscard]] Response after(double h, double velocity) const noexcept {
    if (!(limit > 0.0)) { return {}; }
    const double wanted = travel * force / limit + h * velocity;
    const double sense = wanted < 0.0 ? -1.0 : 1.0;
    const double far = std::abs(wanted);
    if (exponent == 0.0) {
      const bool slides = far >= travel;
      return {sense * limit * (slides ? 1.0 : far / travel), slides ? 0.0 : h * limit / travel};
    }
    const double slip = h * reference_speed;
    const double power = 1.0 / exponent;
    // The left side is convex: Newton's method from above converges without bounds.
    double x = far / travel;
    if (slip > 0.0) { x = std::min(x, std::pow(far / slip, exponent)); }
    double rise = travel;
    for (int n = 0; n < 30; ++n) {
      const double crept = slip * std::pow(x, power);
      rise = travel + (x > 0.0 ? power * crept / x : 0.0);
      const double change = (travel * x + crept - far) / rise;
      x = std::max(x - change, 0.0);
      if (!(std::abs(change) > 1e-15 * x)) { break; }
    }
    return {sense * limit * x, h * limit / rise};
  }
  /// Energy of the tissue that is dragged along [J].
  [[nodiscard]] double energy() const noexcept {
    return limit > 0.0 ? 0.5 * travel / limit * force * force : 0.0;
  }
  /// Changes the limit after the shaft has gone `deeper` [m], less than zero on its way back. Shaft
  /// that is new to the tissue has rubbed on it since it entered; shaft that leaves takes its share
  /// along.
  void reach(double new_limit, double deeper) noexcept {
    if (new_limit > limit) {
      force += (new_limit - limit) * std::clamp(deeper / travel, 0.0, 1.0);
    } else {
      force *= limit > 0.0 ? new_limit / limit : 0.0;
    }
    limit = new_limit;
  }
};

}  // namespace palpate

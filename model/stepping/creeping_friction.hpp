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
  double friction = 0.0;  ///< f: force per length of shaft at the speed reference_speed [N/m]
  double length = 0.0;    ///< x: length of shaft in the tissue [m]
  double force = 0.0;     ///< F at the end of the last step [N]

  static constexpr double reference_speed = 1e-3;  ///< v_1 [m/s]

  struct Response {
    double force = 0.0;  ///< [N]
    double slope = 0.0;  ///< d force / d velocity [N s/m]
  };

  /// Returns the force after h seconds [s] in which the shaft moves relative to the far tissue with
  /// a velocity [m/s]: travel (F - F_before) / L + h v_1 (F / L)^(1/nu) = h velocity.
  [[nodiscard]] Response after(double h, double velocity) const noexcept {
    const double limit = this->limit();
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
  /// L: force at the sliding speed of reference_speed [N].
  [[nodiscard]] double limit() const noexcept { return friction * length; }
  /// z: displacement of the tissue that is dragged along [m].
  [[nodiscard]] double drag() const noexcept {
    return limit() > 0.0 ? travel * force / limit() : 0.0;
  }
  /// Energy of the tissue that is dragged along [J].
  [[nodiscard]] double energy() const noexcept { return 0.5 * drag() * force; }
  /// Adapts length and force to a tip that is `entered` [m] below the rest position of the tissue's
  /// upper border, less than zero above it. The tissue is at most `thickness` [m] long. The border
  /// follows the drag, x = entered - z, but at least half of the way belongs to the tissue. Shaft
  /// that leaves takes its share of the force along. Shaft that enters by dx adds the friction that
  /// it has built up over dx.
  void reach(double entered, double thickness) noexcept {
    const double least = std::clamp(0.5 * entered, 0.0, thickness);
    const double unchanged = std::clamp(entered - drag(), least, thickness);
    if (unchanged <= length) {
      force = length > 0.0 ? force * (unchanged / length) : 0.0;
      length = unchanged;
      return;
    }
    // x (entered - x) = travel F / f, where F is the force after the entry: two quadratic
    // equations, for entries up to the travel and beyond it. Each has one root above `length`.
    const double pull = friction > 0.0 ? travel * force / friction : 0.0;
    const auto larger_root = [](double sum, double product) {
      return 0.5 * (sum + std::sqrt(std::max(sum * sum - 4.0 * product, 0.0)));
    };
    double x = larger_root(0.5 * entered + length, 0.5 * (length * length + pull));
    if (x > length + travel) { x = larger_root(entered - travel, pull - length * travel); }
    x = std::clamp(x, std::max(least, length), thickness);
    force += friction * (x - length) * std::min((x - length) / travel, 1.0);
    length = x;
  }
};

}  // namespace palpate

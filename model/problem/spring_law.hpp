// SPDX-License-Identifier: MIT
#pragma once
/// The law of one spring-damper (model/EQUATIONS.md, "Spring force").

#include <Eigen/Core>
#include <cmath>

#include "model/problem/scene.hpp"

namespace palpate {

/// Below this length [m] a spring has no direction: it exerts no force and is reported.
inline constexpr double zero_length = 1e-12;

/// f_a = scale (elastic k (L - L0) + viscous c L') e, with e = u, or d for the printed Eq. 12.
struct SpringLaw {
  double scale = 1.0;
  double elastic = 1.0;
  double viscous = 1.0;
  bool along_displacement = false;  ///< e = d instead of u

  /// Whether any printed form of the force is asked for.
  static bool is_printed(const PrintedForm& printed) {
    return printed.sign || printed.reversed || printed.direction || printed.half_force ||
           printed.lagged_velocity;
  }
  static SpringLaw from(const PrintedForm& printed) {
    SpringLaw law;
    if (printed.half_force) { law.scale = 0.5; }
    if (printed.reversed) {
      law.viscous = -1.0;
    } else if (printed.sign) {
      law.elastic = -1.0;
    }
    law.along_displacement = printed.direction;
    return law;
  }
};

/// Force [N] on end a; end b feels the opposite. d = x_b - x_a [m], extension_rate = L' [m/s].
template <class Real>
Eigen::Matrix<Real, 3, 1> spring_force(const SpringLaw& law, Real stiffness, Real viscosity,
                                       Real rest_length, const Eigen::Matrix<Real, 3, 1>& d,
                                       Real length, Real extension_rate) noexcept {
  const Real tension = static_cast<Real>(law.scale) *
                       (static_cast<Real>(law.elastic) * stiffness * (length - rest_length) +
                        static_cast<Real>(law.viscous) * viscosity * extension_rate);
  return (law.along_displacement ? tension : tension / length) * d;
}

}  // namespace palpate

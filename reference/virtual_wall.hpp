// SPDX-License-Identifier: MIT
#pragma once
/// When a sampled virtual wall is stable, and when passive: mass m and viscosity b behind a zero-order
/// hold of period T, a wall K with a backward difference B, computed `delay` ticks late.

#include <vector>

namespace palpate::reference {

struct WallLoop {
  double mass = 0.1;       ///< m of device and hand [kg]
  double viscosity = 0.5;  ///< b of device and hand [N s/m]
  double damping = 0.0;    ///< B of the wall [N s/m]
  int delay = 0;           ///< whole ticks from a position to the force that it leads to
  double period = 1e-3;    ///< T [s]
};

/// Largest root of the closed loop's characteristic polynomial
///   z^(d+1) (z - 1)(z - a) + (n1 z + n0)(h1 z + h0),   a = exp(-b T / m), tau = m / b,
///   n1 = (T - tau (1 - a)) / b, n0 = (tau (1 - a) - T a) / b, h1 = K + B / T, h0 = -B / T,
/// the exact z transform of the held plant with the wall; stable where it is below 1.
double largest_root(const WallLoop& loop, double stiffness);

/// The stiffness K [N/m] above which the loop is unstable, to 1e-12 of itself. 0 where no stiffness
/// is stable.
double critical_stiffness(const WallLoop& loop);

/// Colgate & Schenkel (1997): passive for K < 2 (b - |B|) / T, no delay; below 0: none is.
double passive_stiffness(const WallLoop& loop);

/// Gil, Avello, Rubio & Florez (2004), Hulin et al. (2014), small damping: K < (b + B) / (T / 2 + d T).
double linear_rule(const WallLoop& loop);

/// Abbott & Okamura (2005), encoder step D [m] and Coulomb friction f [N]: K <= min(2 b / T, 2 f / D).
double quantised_stiffness(const WallLoop& loop, double encoder_step, double coulomb_friction);

}  // namespace palpate::reference

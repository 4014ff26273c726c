// SPDX-License-Identifier: MIT
#pragma once
/// One mode under a force of known shape, exactly: eta'' + 2 gamma eta' + omega^2 eta = p(t),
///   p(t) = constant + slope t + sum of cosine_k cos(w_k t) + sine_k sin(w_k t).
/// Free motion in closed form for every sign of omega^2 - gamma^2, omega = 0 included. Forced
/// motion by its particular solution, or, near resonance and for omega near 0 where that cancels,
/// by the exponential of the mode and its force taken as one small linear system.

#include <vector>

namespace palpate::reference {

template <class Real>
struct ModeState {
  Real position{};
  Real velocity{};
};

template <class Real>
struct ModeForce {
  struct Harmonic {
    Real frequency{};  ///< [rad/s]
    Real cosine{};
    Real sine{};
  };
  Real constant{};
  Real slope{};
  std::vector<Harmonic> harmonics{};
};

template <class Real>
struct Mode {
  Real omega_squared{};  ///< [rad^2/s^2], negative for an unstable mode
  Real gamma{};          ///< [1/s]
};

template <class Real>
ModeState<Real> free_response(const Mode<Real>& mode, const ModeState<Real>& initial, Real t);

/// State at time t after `initial` at time 0. Defined for double and long double.
template <class Real>
ModeState<Real> respond(const Mode<Real>& mode, const ModeState<Real>& initial,
                        const ModeForce<Real>& force, Real t);

}  // namespace palpate::reference

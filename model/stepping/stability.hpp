// SPDX-License-Identifier: MIT
#pragma once
/// Largest stable step of any registered scheme, from the scheme's own step on the scalar
/// oscillator: no formula per scheme, so a new scheme has its limit at once.

#include "model/stepping/integrator.hpp"
#include "model/stepping/spectral_bounds.hpp"

namespace palpate {

/// Spectral radius of one step of h on x'' + damping x' + omega^2 x = 0.
double amplification(const IntegratorInfo& scheme, double omega, double damping, double h);

/// Largest h [s] up to which no step amplifies that oscillator (infinite when none does, 0 when one
/// of 1e-4 / max(omega, damping) already does). omega [rad/s], damping = c/m [1/s].
double stable_step(const IntegratorInfo& scheme, double omega, double damping);

/// The same for every oscillator that a network with these bounds can contain. Each eigenvalue of
/// its motion is a root of l^2 + g l + w^2 with w <= omega_upper, g <= damping_upper and
/// g >= relaxation_lower w^2 (Rayleigh quotients), whether or not the damping is proportional.
double stable_step(const IntegratorInfo& scheme, const SpectralBounds& bounds);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Exact step matrices of the stepping schemes for the linear oscillator m x'' + c x' + k x = 0:
/// one 2x2 matrix per step. They are derived in long double from the definitions of the schemes,
/// independently of the model's code, so that it can be tested to rounding and not only to O(h^p).
///
/// The state is (x, v). The instant of v depends on the scheme:
///   at the instant of x: "euler", "euler-cromer", "feynman-newton-printed", "velocity-verlet",
///       "rk4", "implicit-euler", "implicit-midpoint";
///   half a step later than x: "feynman-newton", "leapfrog", both started with
///       v(h/2) = v(0) + (h/2) a(x(0), v(0)).

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

using Amplification = Eigen::Matrix<long double, 2, 2>;
using DiscreteState = Eigen::Matrix<long double, 2, 1>;

const std::vector<std::string_view>& discrete_schemes();
bool velocity_is_staggered(std::string_view scheme);

/// Returns the matrix of one undriven step of h [s]. Throws std::invalid_argument for an unknown
/// scheme.
Amplification amplification(std::string_view scheme, const Oscillator& oscillator, double h);

/// Returns (x(0), v(0)), or (x(0), v(h/2)) for a staggered scheme.
DiscreteState discrete_start(std::string_view scheme, const Oscillator& oscillator, double h);

/// Returns the state after `steps` steps, A^steps times the start, by repeated squaring.
DiscreteState discrete_state(std::string_view scheme, const Oscillator& oscillator, double h,
                             long steps);

long double spectral_radius(const Amplification& matrix);

/// Returns the largest h [s] such that no smaller step amplifies: infinity for schemes that never
/// amplify, 0 if arbitrarily small steps amplify. omega0 = sqrt(k/m) [rad/s], damping_ratio = c /
/// (2 sqrt(k m)).
double stability_limit(std::string_view scheme, double omega0, double damping_ratio);

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#pragma once
/// When a run counts as diverged.

#include <cmath>
#include <optional>

#include "model/dynamics/problem.hpp"
#include "model/stepping/integrator.hpp"

namespace palpate {

/// How far a coordinate may go [m] in a run that has not diverged: a million times the size of what moves, beyond
/// where it is at first.
double bound_of_motion(const Problem& problem);

/// Whether a state is finite and within `bound` [m]. A sum of squares cannot hide what is not finite, and is quick; only
/// a large one, or one that is no number, asks for a closer look. `travelled`: most that any coordinate can have gone
/// [m], if the scheme knows.
template <class Real>
bool is_sane(const State<Real>& state, Real bound, std::optional<double> travelled) noexcept {
  if (travelled && *travelled <= static_cast<double>(bound)) { return true; }
  const bool near = state.position.squaredNorm() <= bound * bound;
  if (near && std::isfinite(state.velocity.squaredNorm())) { return true; }
  const Real far = state.position.template lpNorm<Eigen::Infinity>();
  return far <= bound && state.position.allFinite() && state.velocity.allFinite();
}

}  // namespace palpate

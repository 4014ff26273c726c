// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "model/stepping/integrators/schemes.hpp"

namespace palpate {

namespace {

/// A new scheme is one more line here.
constexpr std::array registry{
    &schemes::euler,        &schemes::euler_cromer,    &schemes::feynman_newton,
    &schemes::feynman_newton_printed, &schemes::leapfrog, &schemes::velocity_verlet,
    &schemes::rk4,          &schemes::implicit_euler,  &schemes::implicit_midpoint};

}  // namespace

std::span<const IntegratorInfo* const> integrators() { return registry; }

const IntegratorInfo* find_integrator(std::string_view name) {
  const auto found =
      std::ranges::find_if(registry, [&](const IntegratorInfo* info) { return info->name == name; });
  return found == registry.end() ? nullptr : *found;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Right-hand sides of long_double.cpp, from the physics alone: no force law, load profile or
/// Problem::force of the model is used.

#include <array>
#include <memory>
#include <vector>

#include "model/dynamics/problem.hpp"

namespace palpate::reference {

using Extended = long double;
using ExtendedState = std::vector<Extended>;  ///< [u; v], u = q - q(0)

class ExtendedEquations {
 public:
  virtual ~ExtendedEquations() = default;
  [[nodiscard]] virtual std::size_t dof() const = 0;
  [[nodiscard]] virtual ExtendedState initial_state() const = 0;
  [[nodiscard]] virtual Extended initial_position(std::size_t coordinate) const = 0;
  virtual void derivative(Extended t, double gate, const ExtendedState& y,
                          ExtendedState& dy) const = 0;
};

/// Null for a kind of problem that is not known.
std::unique_ptr<ExtendedEquations> extended_equations(const Problem& problem);

}  // namespace palpate::reference

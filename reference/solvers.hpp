// SPDX-License-Identifier: MIT
#pragma once
/// All solvers of this library by name and family. Two solvers of one family do not confirm each
/// other.

#include <string>
#include <string_view>
#include <vector>

#include "reference/solution.hpp"

namespace palpate::reference {

struct NamedSolver {
  std::string name{};  ///< as in Solution::solver
  std::string
      family{};  ///< "explicit runge-kutta", "adams", "bdf", "implicit runge-kutta", "modal"
  Solver solve = nullptr;
};

const std::vector<NamedSolver>& all_solvers();

/// std::invalid_argument, naming those that exist, when there is none of that name.
const NamedSolver& solver_named(std::string_view name);

}  // namespace palpate::reference

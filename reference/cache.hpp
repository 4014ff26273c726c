// SPDX-License-Identifier: MIT
#pragma once
/// Where slow references may be kept between runs. The folder behind it may vanish at any time: a
/// miss is never an error. The key is everything that decides the answer.

#include <functional>
#include <optional>
#include <string>

#include "reference/solution.hpp"

namespace palpate::reference {

struct Cache {
  std::function<std::optional<Solution>(const std::string& key)> load{};
  std::function<void(const std::string& key, const Solution& solution)> save{};
};

/// Key of a solver on a problem: solver, version, tolerances, times and every number of the
/// problem (masses, initial values, forces and Jacobian along a probe motion, breaks).
std::string cache_key(const std::string& solver, const Problem& problem,
                      const std::vector<double>& times, const Tolerance& tolerance);

/// From the cache when it is there, else computed and kept. cache may be nullptr.
Solution solve_cached(const Cache* cache, const std::string& solver, Solver compute,
                      const Problem& problem, const std::vector<double>& times,
                      const Tolerance& tolerance);

}  // namespace palpate::reference

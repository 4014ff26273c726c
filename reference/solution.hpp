// SPDX-License-Identifier: MIT
#pragma once
/// Tolerances, errors and solution cache of all reference solvers.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"

namespace palpate::reference {

/// Tolerances of a solver. Absolute tolerances are position_scale * relative and velocity_scale *
/// relative, because metres and metres per second need different ones.
struct Tolerance {
  double relative = 1e-10;
  double position_scale = 1e-3;  ///< [m]
  double velocity_scale = 1e-1;  ///< [m/s]
};

/// Failure of a solver: the message names solver, flag and time.
class SolverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Iteration that ended before convergence.
class NotConverged : public SolverError {
 public:
  using SolverError::SolverError;
};

/// Function type that solves a problem. `times` [s] ascend from times[0] = 0, the initial instant
/// of the problem. Every break of the problem is a stop time, and no step is longer than a quarter
/// of its shortest feature. Throws SolverError.
using Solve = Trace(const Problem& problem, const std::vector<double>& times,
                    const Tolerance& tolerance);
using Solver = Solve*;

// Cache of slow references between runs. Its folder may be deleted at any time: a miss is not an
// error. The key contains everything that the solution depends on.

struct Cache {
  std::string code{};  ///< hash of the program and of the libraries that compute the solutions
  /// Returns the kept solution of a key; empty function: nothing is read.
  std::function<std::optional<Trace>(const std::string& key)> load{};
  std::function<void(const std::string& key, const Trace& solution)> save{};
};

/// Returns the key of a solver on a problem: a line of text with solver, versions, tolerances and
/// `code`, then the bytes of the times and of every number of the problem (masses, initial values,
/// springs, loads, forces at probe states, breaks).
std::string cache_key(const std::string& code, const std::string& solver, const Problem& problem,
                      const std::vector<double>& times, const Tolerance& tolerance);

/// Returns the solution from the cache, or computes and stores it. `cache` may be nullptr.
Trace solve_cached(const Cache* cache, const std::string& solver, Solver compute,
                   const Problem& problem, const std::vector<double>& times,
                   const Tolerance& tolerance);

}  // namespace palpate::reference

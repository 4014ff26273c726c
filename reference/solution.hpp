// SPDX-License-Identifier: MIT
#pragma once
/// What all reference solvers share: tolerances, errors, and a cache of solutions.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/trace.hpp"

namespace palpate::reference {

/// Absolute tolerances follow from physical sizes: position_scale * relative and
/// velocity_scale * relative, never one scalar for metres and metres per second.
struct Tolerance {
  double relative = 1e-10;
  double position_scale = 1e-3;  ///< [m]
  double velocity_scale = 1e-1;  ///< [m/s]
};

/// A solver that could not do what was asked: the message names solver, flag and time.
class SolverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An iteration that was ended before it had found its answer.
class NotConverged : public SolverError {
 public:
  using SolverError::SolverError;
};

/// times: ascending, times[0] = 0 and equal to the problem's initial instant. Every break of the
/// problem is a stop time, and no step is longer than a quarter of its shortest feature.
/// Throws SolverError.
using Solver = Trace (*)(const Problem& problem, const std::vector<double>& times,
                         const Tolerance& tolerance);

// Where slow references may be kept between runs. The folder behind it may vanish at any time: a
// miss is never an error. The key is everything that decides the answer.

struct Cache {
  std::function<std::optional<Trace>(const std::string& key)> load{};
  std::function<void(const std::string& key, const Trace& solution)> save{};
};

/// Key of a solver on a problem: solver, version, tolerances, times and every number of the
/// problem (masses, initial values, forces and Jacobian along a probe motion, breaks).
std::string cache_key(const std::string& solver, const Problem& problem,
                      const std::vector<double>& times, const Tolerance& tolerance);

/// From the cache when it is there, else computed and kept. cache may be nullptr.
Trace solve_cached(const Cache* cache, const std::string& solver, Solver compute,
                   const Problem& problem, const std::vector<double>& times,
                   const Tolerance& tolerance);

}  // namespace palpate::reference

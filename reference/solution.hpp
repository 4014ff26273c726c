// SPDX-License-Identifier: MIT
#pragma once
/// A trajectory of a Problem computed by somebody else's method, and how it was computed.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"

namespace palpate::reference {

/// Absolute tolerances follow from physical sizes: position_scale * relative and
/// velocity_scale * relative, never one scalar for metres and metres per second.
struct Tolerance {
  double relative = 1e-10;
  double position_scale = 1e-3;  ///< [m]
  double velocity_scale = 1e-1;  ///< [m/s]
};

struct Solution {
  std::string solver{};   ///< "cvode-adams"
  std::string version{};  ///< "SUNDIALS 6.4.1"
  double relative_tolerance = 0.0;
  long steps = 0;
  long evaluations = 0;        ///< of the right-hand side
  double seconds = 0.0;        ///< wall time
  std::vector<double> time{};  ///< [s]
  Eigen::MatrixXd position{};  ///< dof x times [m]
  Eigen::MatrixXd velocity{};  ///< dof x times [m/s]
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
using Solver = Solution (*)(const Problem& problem, const std::vector<double>& times,
                            const Tolerance& tolerance);

// Where slow references may be kept between runs. The folder behind it may vanish at any time: a
// miss is never an error. The key is everything that decides the answer.

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

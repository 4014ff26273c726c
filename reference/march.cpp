// SPDX-License-Identifier: MIT
#include "reference/march.hpp"

#include <chrono>
#include <cstdio>

namespace palpate::reference {

namespace {

void store(const FirstOrderSystem& system, const double* y, std::size_t output,
           Solution& solution) {
  const Eigen::Index n = system.dof();
  const auto column = static_cast<Eigen::Index>(output);
  solution.position.col(column) = system.origin() + Eigen::Map<const Eigen::VectorXd>(y, n);
  solution.velocity.col(column) = Eigen::Map<const Eigen::VectorXd>(y + n, n);
}

void check_outcome(const Solution& solution, std::size_t segment_count) {
  const auto least = static_cast<long>(segment_count) - 1 + 10;
  if (segment_count > 0 && solution.steps < least) {
    throw SolverError(solution.solver + ": took " + std::to_string(solution.steps) +
                      " steps; at least " + std::to_string(least) + " (breaks + 10) are needed");
  }
  if (!solution.position.allFinite() || !solution.velocity.allFinite()) {
    throw SolverError(solution.solver + ": the solution is not finite");
  }
}

}  // namespace

Solution march(const Method& method, FirstOrderSystem& system, const std::vector<double>& times,
               const Tolerance& tolerance, Integrator& integrator) {
  const auto begun = std::chrono::steady_clock::now();
  const std::vector<Segment> segments = segments_of(system.problem(), times);
  Solution solution{.solver = method.name,
                    .version = method.version,
                    .relative_tolerance = tolerance.relative,
                    .time = times};
  solution.position.resize(system.dof(), static_cast<Eigen::Index>(times.size()));
  solution.velocity.resizeLike(solution.position);
  store(system, integrator.state(), 0, solution);
  for (const Segment& segment : segments) {
    system.set_gate(segment.gate);
    integrator.begin(segment);
    for (const Stop& stop : segment.stops) {
      integrator.advance(stop.time);
      if (stop.output) { store(system, integrator.state(), *stop.output, solution); }
    }
    solution.steps += integrator.segment_steps();
  }
  solution.evaluations = system.evaluations();
  solution.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  check_outcome(solution, segments.size());
  return solution;
}

void fail(const std::string& solver, const std::string& function, const std::string& flag,
          double time, const std::string& why) {
  char instant[32];
  std::snprintf(instant, sizeof instant, "%.9g", time);
  std::string message =
      solver + ": " + function + " failed with " + flag + " at t = " + instant + " s";
  if (!why.empty()) { message += ": " + why; }
  throw SolverError(message);
}

}  // namespace palpate::reference

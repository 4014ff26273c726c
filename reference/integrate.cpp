// SPDX-License-Identifier: MIT

#include "reference/integrate.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "reference/solution.hpp"

namespace palpate::reference {

using Eigen::Index;
using Eigen::VectorXd;
using ConstVectorMap = Eigen::Map<const VectorXd>;
using VectorMap = Eigen::Map<VectorXd>;

FirstOrderSystem::FirstOrderSystem(const Problem& problem)
    : problem_(&problem),
      origin_(problem.initial_position()),
      inverse_mass_(problem.mass().cwiseInverse()),
      position_(origin_) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  if (network != nullptr && relaxes(network->network())) {
    throw SolverError("relaxing tissue has further states; only solve_long_double integrates them");
  }
}

VectorXd FirstOrderSystem::initial_state() const {
  VectorXd y(size());
  y << VectorXd::Zero(dof()), problem_->initial_velocity();
  return y;
}

VectorXd FirstOrderSystem::scales(const Tolerance& tolerance) const {
  VectorXd scales(size());
  scales << VectorXd::Constant(dof(), tolerance.position_scale),
      VectorXd::Constant(dof(), tolerance.velocity_scale);
  return scales;
}

bool FirstOrderSystem::derivative(double t, const double* y, double* dy) {
  ++evaluations_;
  const ConstVectorMap velocity(y + dof(), dof());
  VectorMap acceleration(dy + dof(), dof());
  position_ = origin_ + ConstVectorMap(y, dof());
  problem_->force(t, gate_, position_, velocity, acceleration);
  acceleration.array() *= inverse_mass_.array();
  VectorMap(dy, dof()) = velocity;
  return VectorMap(dy, size()).allFinite();
}

SparseJacobian first_order_jacobian(const FirstOrderSystem& system, const double* y) {
  const Problem& problem = system.problem();
  const Index n = system.dof();
  Eigen::SparseMatrix<double> stiffness, damping;
  problem.jacobian(system.origin() + ConstVectorMap(y, n), ConstVectorMap(y + n, n), stiffness,
                   damping);
  const VectorXd inverse_mass = problem.mass().cwiseInverse();
  std::vector<Eigen::Triplet<double, std::int64_t>> entries;
  for (Index j = 0; j < n; ++j) {
    entries.emplace_back(j, j, 0.0);
    entries.emplace_back(j, n + j, 1.0);
    entries.emplace_back(n + j, n + j, 0.0);
    const auto add = [&](const Eigen::SparseMatrix<double>& matrix, Index column) {
      for (Eigen::SparseMatrix<double>::InnerIterator k(matrix, j); k; ++k) {
        entries.emplace_back(n + k.row(), column, -k.value() * inverse_mass(k.row()));
      }
    };
    add(stiffness, j);
    add(damping, n + j);
  }
  SparseJacobian jacobian(2 * n, 2 * n);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

namespace {

void check_times(const std::vector<double>& times) {
  if (times.empty() || times.front() != 0.0) {
    throw SolverError("segments: the requested times must begin at 0 s");
  }
  for (std::size_t n = 1; n < times.size(); ++n) {
    if (!(times[n] > times[n - 1]) || !std::isfinite(times[n])) {
      throw SolverError("segments: requested time " + std::to_string(n) +
                        " is not later than the one before it");
    }
  }
}

}  // namespace

std::vector<Segment> segments_of(const Problem& problem, const std::vector<double>& times) {
  check_times(times);
  std::vector<Segment> segments;
  if (times.size() == 1) { return segments; }
  // A solver cannot distinguish stops that are closer than this.
  const double apart = 1e-13 * times.back();
  std::vector<double> ends;
  for (const double t : problem.breaks()) {
    if (t > apart && t < times.back() - apart) { ends.push_back(t); }
  }
  ends.push_back(times.back());
  const double longest = problem.shortest_feature() / 4.0;
  double start = 0.0;
  std::size_t next = 1;
  for (const double end : ends) {
    Segment segment{.start = start, .end = end, .gate = 0.5 * (start + end)};
    segment.max_step = std::min(longest, (end - start) / steps_per_segment);
    while (next < times.size() && times[next] < end - apart) {
      segment.stops.push_back({times[next], next});
      ++next;
    }
    Stop last{end, {}};
    if (next < times.size() && times[next] <= end + apart) { last.output = next++; }
    segment.stops.push_back(last);
    segments.push_back(std::move(segment));
    start = end;
  }
  return segments;
}

void SystemIntegrator::read(Eigen::Ref<VectorXd> position, Eigen::Ref<VectorXd> velocity) const {
  position = system_.origin() + ConstVectorMap(state(), system_.dof());
  velocity = ConstVectorMap(state() + system_.dof(), system_.dof());
}

namespace {

void check_outcome(const Trace& solution, std::size_t segment_count) {
  const auto least = static_cast<long>(segment_count) - 1 + 10;
  if (segment_count > 0 && solution.steps < least) {
    throw SolverError(solution.method + ": took " + std::to_string(solution.steps) +
                      " steps; at least " + std::to_string(least) + " (breaks + 10) are needed");
  }
  if (!solution.position.allFinite() || !solution.velocity.allFinite()) {
    throw SolverError(solution.method + ": the solution is not finite");
  }
}

}  // namespace

Trace integrate(const Method& method, const Problem& problem, const std::vector<double>& times,
                const Tolerance& tolerance, Integrator& integrator) {
  const auto begun = std::chrono::steady_clock::now();
  const std::vector<Segment> segments = segments_of(problem, times);
  Trace solution{.time = times,
                 .method = method.name,
                 .version = method.version,
                 .relative_tolerance = tolerance.relative};
  solution.position.resize(problem.dof(), static_cast<Index>(times.size()));
  solution.velocity.resizeLike(solution.position);
  const auto store = [&](std::size_t output) {
    const auto column = static_cast<Index>(output);
    integrator.read(solution.position.col(column), solution.velocity.col(column));
  };
  store(0);
  for (const Segment& segment : segments) {
    integrator.begin(segment);
    for (const Stop& stop : segment.stops) {
      integrator.advance(stop.time);
      if (stop.output) { store(*stop.output); }
    }
    solution.steps += integrator.segment_steps();
  }
  solution.evaluations = integrator.evaluations();
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

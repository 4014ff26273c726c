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
      position_(origin_) {}

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

FirstOrderJacobian::FirstOrderJacobian(const FirstOrderSystem& system)
    : system_(&system), inverse_mass_(system.problem().mass().cwiseInverse()) {
  evaluate(system.initial_state().data());
  const Index n = system.dof();
  const auto add = [this](Index row, double value) {
    rows_.push_back(row);
    values_.push_back(value);
    return values_.size() - 1;
  };
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  for (Index j = 0; j < n; ++j) {
    column_starts_.push_back(static_cast<Index>(rows_.size()));
    add(j, 0.0);
    for (Entry k(stiffness_, j); k; ++k) { stiffness_slots_.push_back(add(n + k.row(), 0.0)); }
  }
  for (Index j = 0; j < n; ++j) {
    column_starts_.push_back(static_cast<Index>(rows_.size()));
    add(j, 1.0);
    bool has_diagonal = false;
    for (Entry c(damping_, j); c; ++c) {
      has_diagonal = has_diagonal || c.row() == j;
      damping_slots_.push_back(add(n + c.row(), 0.0));
    }
    if (!has_diagonal) { add(n + j, 0.0); }
  }
  column_starts_.push_back(static_cast<Index>(rows_.size()));
}

void FirstOrderJacobian::evaluate(const double* y) {
  const Index n = system_->dof();
  const VectorXd position = system_->origin() + ConstVectorMap(y, n);
  system_->problem().jacobian(position, ConstVectorMap(y + n, n), stiffness_, damping_);
  stiffness_.makeCompressed();
  damping_.makeCompressed();
}

void FirstOrderJacobian::update(const double* y) {
  evaluate(y);
  if (static_cast<std::size_t>(stiffness_.nonZeros()) != stiffness_slots_.size() ||
      static_cast<std::size_t>(damping_.nonZeros()) != damping_slots_.size()) {
    throw SolverError("first order: the pattern of the problem's Jacobian has changed");
  }
  const auto scatter = [this](const Eigen::SparseMatrix<double>& matrix,
                              const std::vector<std::size_t>& slots) {
    for (std::size_t s = 0; s < slots.size(); ++s) {
      const auto entry = static_cast<Index>(s);
      const Index row = matrix.innerIndexPtr()[entry];
      values_[slots[s]] = -matrix.valuePtr()[entry] * inverse_mass_(row);
    }
  };
  scatter(stiffness_, stiffness_slots_);
  scatter(damping_, damping_slots_);
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

/// Returns the breaks strictly inside (0, end), at least `apart` [s] from the ends.
std::vector<double> inner_breaks(const Problem& problem, double end, double apart) {
  std::vector<double> inner;
  for (const double t : problem.breaks()) {
    if (t > apart && t < end - apart) { inner.push_back(t); }
  }
  return inner;
}

}  // namespace

std::vector<Segment> segments_of(const Problem& problem, const std::vector<double>& times) {
  check_times(times);
  std::vector<Segment> segments;
  if (times.size() == 1) { return segments; }
  // A solver cannot distinguish stops that are closer than this.
  const double apart = 1e-13 * times.back();
  std::vector<double> ends = inner_breaks(problem, times.back(), apart);
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

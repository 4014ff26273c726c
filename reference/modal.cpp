// SPDX-License-Identifier: MIT
#include "reference/modal.hpp"

#include <Eigen/Eigenvalues>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>

#include "reference/dense_modes.hpp"
#include "reference/linear_problem.hpp"
#include "reference/mode_response.hpp"
#include "reference/segments.hpp"

namespace palpate::reference {

namespace {

using Eigen::Index;
template <class Real>
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
template <class Real>
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// q = r + shapes * eta, shapes^T M shapes = 1.
template <class Real>
struct Modes {
  Vector<Real> root_mass;      ///< sqrt(m)
  Vector<Real> omega_squared;  ///< ascending
  Vector<Real> gamma;
  Matrix<Real> shapes;  ///< M^-1/2 Phi
};

/// M^-1/2 A M^-1/2
template <class Real>
Matrix<Real> mass_scaled(const Eigen::SparseMatrix<double>& matrix, const Vector<Real>& root_mass) {
  Matrix<Real> scaled = Eigen::MatrixXd(matrix).cast<Real>();
  scaled.array().colwise() /= root_mass.array();
  scaled.array().rowwise() /= root_mass.transpose().array();
  return scaled;
}

template <class Real>
struct Decomposition {
  Vector<Real> values;
  Matrix<Real> vectors;
};

template <class Real>
Decomposition<Real> decompose(const LinearProblem& problem, const Vector<Real>& root_mass) {
  const Matrix<Real> scaled = mass_scaled(problem.stiffness(), root_mass);
  if ((scaled - scaled.transpose()).cwiseAbs().maxCoeff() >
      Real(1e-12) * scaled.cwiseAbs().maxCoeff()) {
    throw SolverError("modal: the stiffness matrix is not symmetric");
  }
  if constexpr (std::is_same_v<Real, double>) {
    SymmetricModes modes = symmetric_modes(scaled);
    return {std::move(modes.values), std::move(modes.vectors)};
  } else {
    const Eigen::SelfAdjointEigenSolver<Matrix<Real>> solver(scaled);
    if (solver.info() != Eigen::Success) { throw SolverError("modal: no convergence of the modes"); }
    return {solver.eigenvalues(), solver.eigenvectors()};
  }
}

template <class Real>
Modes<Real> modes_of(const LinearProblem& problem) {
  Modes<Real> modes;
  modes.root_mass = problem.mass().cast<Real>().cwiseSqrt();
  const Decomposition<Real> found = decompose(problem, modes.root_mass);
  modes.omega_squared = found.values;
  modes.shapes = found.vectors;
  Matrix<Real> damping = mass_scaled(problem.damping(), modes.root_mass);
  const Real largest = damping.cwiseAbs().maxCoeff();
  damping = (modes.shapes.transpose() * (damping * modes.shapes)).eval();
  modes.gamma = damping.diagonal() / 2;
  damping.diagonal().setZero();
  const Real coupling = damping.cwiseAbs().maxCoeff();
  if (!(coupling <= Real(1e-9) * largest)) {
    throw SolverError("modal: damping is not proportional: it couples the modes by " +
                      std::to_string(static_cast<double>(coupling / largest)) +
                      " of its largest entry; at most 1e-9");
  }
  modes.shapes.array().colwise() /= modes.root_mass.array();
  return modes;
}

/// What acts on one mode in one segment, time counted from the segment's start.
template <class Real>
ModeForce<Real> force_in(const Segment& segment, const std::vector<ShapedLoad>& loads,
                         const Eigen::Ref<const Vector<Real>>& share) {
  ModeForce<Real> force;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const ShapedLoad& load = loads[l];
    const Real amplitude = share(static_cast<Index>(l));
    if (segment.gate < load.start || segment.gate >= load.end || amplitude == 0) { continue; }
    const Real length = Real(load.end) - Real(load.start);
    const Real elapsed = Real(segment.start) - Real(load.start);
    if (load.shape == ShapedLoad::Shape::constant) {
      force.constant += amplitude;
    } else if (load.shape == ShapedLoad::Shape::ramp) {
      force.constant += amplitude * elapsed / length;
      force.slope += amplitude / length;
    } else if (load.shape == ShapedLoad::Shape::half_sine) {
      const Real w = std::numbers::pi_v<Real> / length;
      force.harmonics.push_back(
          {w, amplitude * std::sin(w * elapsed), amplitude * std::cos(w * elapsed)});
    } else {
      const Real w = Real(load.frequency);
      const Real phase = w * Real(segment.start);
      force.harmonics.push_back({w, amplitude * std::cos(phase), -amplitude * std::sin(phase)});
    }
  }
  return force;
}

/// Modal coordinates and velocities at all requested times, one row per mode.
template <class Real>
struct ModalHistory {
  Matrix<Real> position;
  Matrix<Real> velocity;
};

template <class Real>
ModalHistory<Real> history(const LinearProblem& problem, const Modes<Real>& modes,
                           const std::vector<double>& times) {
  const std::vector<Segment> segments = segments_of(problem, times);
  const std::vector<ShapedLoad> loads = shaped_loads(problem);
  const Index n = problem.dof();
  Matrix<Real> shares(static_cast<Index>(loads.size()), n);  // of each load in each mode
  for (Index l = 0; l < shares.rows(); ++l) {
    shares.row(l) = modes.shapes.transpose() *
                    loads[static_cast<std::size_t>(l)].amplitude.template cast<Real>();
  }
  const Vector<Real> mass = modes.root_mass.cwiseAbs2();
  const Vector<Real> u0 =
      problem.initial_position().cast<Real>() - problem.rest().template cast<Real>();
  const Vector<Real> v0 = problem.initial_velocity().cast<Real>();
  ModalHistory<Real> result;
  result.position.resize(n, static_cast<Index>(times.size()));
  result.velocity.resizeLike(result.position);
  result.position.col(0) = modes.shapes.transpose() * mass.cwiseProduct(u0);
  result.velocity.col(0) = modes.shapes.transpose() * mass.cwiseProduct(v0);
  for (Index j = 0; j < n; ++j) {
    const Mode<Real> mode{modes.omega_squared(j), modes.gamma(j)};
    ModeState<Real> state{result.position(j, 0), result.velocity(j, 0)};
    for (const Segment& segment : segments) {
      const ModeForce<Real> force = force_in<Real>(segment, loads, shares.col(j));
      const ModeState<Real> initial = state;
      for (const Stop& stop : segment.stops) {
        state = respond<Real>(mode, initial, force, Real(stop.time) - Real(segment.start));
        if (!stop.output) { continue; }
        result.position(j, static_cast<Index>(*stop.output)) = state.position;
        result.velocity(j, static_cast<Index>(*stop.output)) = state.velocity;
      }
    }
  }
  return result;
}

}  // namespace

Eigen::VectorXd natural_frequencies(const Problem& problem) {
  const LinearProblem linear(problem);
  const Eigen::VectorXd root_mass = linear.mass().cwiseSqrt();
  return decompose<double>(linear, root_mass).values.cwiseMax(0.0).cwiseSqrt();
}

template <class Real>
Solution modal_solution(const Problem& problem, const std::vector<double>& times) {
  const auto begun = std::chrono::steady_clock::now();
  const LinearProblem linear(problem);
  const Modes<Real> modes = modes_of<Real>(linear);
  const ModalHistory<Real> modal = history(linear, modes, times);
  Solution solution{.solver = std::is_same_v<Real, double> ? "modal" : "modal-long-double",
                    .version = "modal superposition",
                    .time = times};
  Matrix<Real> position = modes.shapes * modal.position;
  position.colwise() += linear.rest().template cast<Real>();
  solution.position = position.template cast<double>();
  solution.velocity = (modes.shapes * modal.velocity).template cast<double>();
  solution.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  if (!solution.position.allFinite() || !solution.velocity.allFinite()) {
    throw SolverError("modal: the solution is not finite");
  }
  return solution;
}

template Solution modal_solution<double>(const Problem&, const std::vector<double>&);
template Solution modal_solution<long double>(const Problem&, const std::vector<double>&);

Solution solve_modal(const Problem& problem, const std::vector<double>& times, const Tolerance&) {
  return modal_solution<double>(problem, times);
}

Solution solve_modal_long_double(const Problem& problem, const std::vector<double>& times,
                                 const Tolerance&) {
  return modal_solution<long double>(problem, times);
}

}  // namespace palpate::reference

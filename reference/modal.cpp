// SPDX-License-Identifier: MIT

#include "reference/modal.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "reference/exact_problems.hpp"
#include "reference/integrate.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

template <class T> using Owned = std::unique_ptr<T, void (*)(T*)>;

/// Row-major matrix for GSL, which overwrites its input.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

gsl_matrix_view view_of(Rows& rows) {
  return gsl_matrix_view_array(rows.data(), static_cast<std::size_t>(rows.rows()),
                               static_cast<std::size_t>(rows.cols()));
}

void check(int status) {
  if (status != GSL_SUCCESS) {
    throw SolverError(std::string("dense modes: GSL: ") + gsl_strerror(status));
  }
}

}  // namespace

SymmetricModes symmetric_modes(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() == 0) { return {Eigen::VectorXd(0), Eigen::MatrixXd(0, 0)}; }
  return_gsl_errors();
  const auto n = static_cast<std::size_t>(matrix.rows());
  Rows work = matrix;
  Rows vectors(matrix.rows(), matrix.cols());
  SymmetricModes modes;
  modes.values.resize(matrix.rows());
  gsl_matrix_view a = view_of(work);
  gsl_matrix_view v = view_of(vectors);
  gsl_vector_view values = gsl_vector_view_array(modes.values.data(), n);
  const Owned<gsl_eigen_symmv_workspace> space(gsl_eigen_symmv_alloc(n), gsl_eigen_symmv_free);
  check(gsl_eigen_symmv(&a.matrix, &values.vector, &v.matrix, space.get()));
  check(gsl_eigen_symmv_sort(&values.vector, &v.matrix, GSL_EIGEN_SORT_VAL_ASC));
  modes.vectors = vectors;
  return modes;
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& matrix) {
  return symmetric_modes(matrix).values;
}

GeneralModes general_modes(const Eigen::MatrixXd& matrix) {
  if (matrix.rows() == 0) { return {}; }
  return_gsl_errors();
  const auto n = static_cast<std::size_t>(matrix.rows());
  Rows work = matrix;
  gsl_matrix_view a = view_of(work);
  const Owned<gsl_vector_complex> values(gsl_vector_complex_alloc(n), gsl_vector_complex_free);
  const Owned<gsl_matrix_complex> vectors(gsl_matrix_complex_alloc(n, n), gsl_matrix_complex_free);
  const Owned<gsl_eigen_nonsymmv_workspace> space(gsl_eigen_nonsymmv_alloc(n),
                                                  gsl_eigen_nonsymmv_free);
  check(gsl_eigen_nonsymmv(&a.matrix, values.get(), vectors.get(), space.get()));
  using Complex = std::complex<double>;  // of the same layout as GSL's
  using ComplexRows = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return {Eigen::VectorXcd::Map(reinterpret_cast<const Complex*>(values->data), matrix.rows()),
          ComplexRows::Map(reinterpret_cast<const Complex*>(vectors->data), matrix.rows(),
                           matrix.rows())};
}

namespace {

/// Returns cos(sqrt(z)) and sin(sqrt(z)) / sqrt(z), analytic in z.
template <class Real> ModeState<Real> circular(Real z) {
  if (std::abs(z) < Real(1)) {
    Real cosine = 1, sine = 1, cosine_term = 1, sine_term = 1;
    for (int n = 1; n < 14; ++n) {
      cosine_term *= -z / Real((2 * n - 1) * (2 * n));
      sine_term *= -z / Real((2 * n) * (2 * n + 1));
      cosine += cosine_term;
      sine += sine_term;
    }
    return {cosine, sine};
  }
  const Real root = std::sqrt(std::abs(z));
  if (z > 0) { return {std::cos(root), std::sin(root) / root}; }
  return {std::cosh(root), std::sinh(root) / root};
}

template <class Real> using Harmonic = typename ModeForce<Real>::Harmonic;

/// Returns the particular solution for one harmonic: amplitudes of its cosine and sine.
template <class Real> Harmonic<Real> steady(const Mode<Real>& mode, const Harmonic<Real>& force) {
  const Real w = force.frequency;
  const Real detuning = mode.omega_squared - w * w;
  const Real drag = 2 * mode.gamma * w;
  const Real norm = detuning * detuning + drag * drag;
  return {w, (detuning * force.cosine - drag * force.sine) / norm,
          (drag * force.cosine + detuning * force.sine) / norm};
}

/// Returns true if the particular solution is much larger than the motion, which causes
/// cancellation.
template <class Real> bool cancels(const Mode<Real>& mode, const ModeForce<Real>& force, Real t) {
  constexpr Real close = Real(0.1);
  const Real elastic = std::abs(mode.omega_squared);
  if ((force.constant != 0 || force.slope != 0) && elastic * t * t < close) { return true; }
  if (force.slope != 0 && std::abs(mode.gamma) > 10 * elastic * t) { return true; }
  return std::ranges::any_of(force.harmonics, [&](const Harmonic<Real>& h) {
    const Real square = h.frequency * h.frequency;
    const Real size = std::hypot(mode.omega_squared - square, 2 * mode.gamma * h.frequency);
    return size * t * t < close || size < close * std::max(elastic, square);
  });
}

template <class Real>
ModeState<Real> particular(const Mode<Real>& mode, const ModeForce<Real>& force, Real t) {
  ModeState<Real> state;
  if (force.constant != 0 || force.slope != 0) {
    const Real drift = force.slope / mode.omega_squared;
    state.position = (force.constant - 2 * mode.gamma * drift) / mode.omega_squared + drift * t;
    state.velocity = drift;
  }
  for (const Harmonic<Real>& h : force.harmonics) {
    const Harmonic<Real> s = steady(mode, h);
    const Real cosine = std::cos(h.frequency * t);
    const Real sine = std::sin(h.frequency * t);
    state.position += s.cosine * cosine + s.sine * sine;
    state.velocity += h.frequency * (s.sine * cosine - s.cosine * sine);
  }
  return state;
}

template <class Real> using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

/// Computes the matrix exponential by scaling and squaring of the Taylor series; the norm is halved
/// to below 1/4.
template <class Real> Matrix<Real> exponential(const Matrix<Real>& matrix) {
  const Real norm = matrix.cwiseAbs().rowwise().sum().maxCoeff();
  const int halvings = norm > Real(0.25) ? static_cast<int>(std::ceil(std::log2(norm * 4))) : 0;
  const Matrix<Real> small = matrix * std::ldexp(Real(1), -halvings);
  Matrix<Real> term = Matrix<Real>::Identity(matrix.rows(), matrix.cols());
  Matrix<Real> sum = term;
  for (int n = 1; n < 18; ++n) {
    term = (term * small / Real(n)).eval();
    sum += term;
  }
  for (int n = 0; n < halvings; ++n) { sum = (sum * sum).eval(); }
  return sum;
}

/// Augmented linear system of [eta, eta'/rate, 1, t rate, (cos, sin) of each harmonic].
template <class Real>
ModeState<Real> coupled_response(const Mode<Real>& mode, const ModeState<Real>& initial,
                                 const ModeForce<Real>& force, Real t) {
  const auto count = static_cast<Eigen::Index>(force.harmonics.size());
  Real rate = std::max(std::sqrt(std::abs(mode.omega_squared)), 1 / t);
  for (const Harmonic<Real>& h : force.harmonics) { rate = std::max(rate, std::abs(h.frequency)); }
  Matrix<Real> generator = Matrix<Real>::Zero(4 + 2 * count, 4 + 2 * count);
  Eigen::Matrix<Real, Eigen::Dynamic, 1> start(4 + 2 * count);
  start.setZero();
  start.template head<3>() << initial.position, initial.velocity / rate, Real(1);
  generator(0, 1) = rate;
  generator.template block<1, 4>(1, 0) << -mode.omega_squared / rate, -2 * mode.gamma,
      force.constant / rate, force.slope / (rate * rate);
  generator(3, 2) = rate;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Harmonic<Real>& h = force.harmonics[static_cast<std::size_t>(k)];
    const Eigen::Index c = 4 + 2 * k;
    generator(1, c) = h.cosine / rate;
    generator(1, c + 1) = h.sine / rate;
    generator(c, c + 1) = -h.frequency;
    generator(c + 1, c) = h.frequency;
    start(c) = 1;
  }
  const Eigen::Matrix<Real, Eigen::Dynamic, 1> end = exponential<Real>(generator * t) * start;
  return {end(0), end(1) * rate};
}

}  // namespace

template <class Real>
ModeState<Real> free_response(const Mode<Real>& mode, const ModeState<Real>& initial, Real t) {
  const Real x0 = initial.position;
  const Real v0 = initial.velocity;
  const Real gamma = mode.gamma;
  const Real z = (mode.omega_squared - gamma * gamma) * t * t;
  if (z < Real(-1)) {  // two real rates, in a form without cancellation or overflow
    const Real root = std::sqrt(gamma * gamma - mode.omega_squared);
    const Real one = gamma >= 0 ? -(gamma + root) : root - gamma;
    const Real other = mode.omega_squared / one;
    const Real b = (v0 - other * x0) / (one - other);
    const Real a = x0 - b;
    const Real ea = std::exp(other * t);
    const Real eb = std::exp(one * t);
    return {a * ea + b * eb, a * other * ea + b * one * eb};
  }
  const auto [c, s] = circular(z);
  const Real decay = std::exp(-gamma * t);
  return {decay * (x0 * c + (v0 + gamma * x0) * t * s),
          decay * (v0 * c - (gamma * v0 + mode.omega_squared * x0) * t * s)};
}

template <class Real>
ModeState<Real> respond(const Mode<Real>& mode, const ModeState<Real>& initial,
                        const ModeForce<Real>& force, Real t) {
  if (t == 0) { return initial; }
  if (cancels(mode, force, t)) { return coupled_response(mode, initial, force, t); }
  const ModeState<Real> before = particular(mode, force, Real(0));
  const ModeState<Real> now = particular(mode, force, t);
  const ModeState<Real> free = free_response<Real>(
      mode, {initial.position - before.position, initial.velocity - before.velocity}, t);
  return {now.position + free.position, now.velocity + free.velocity};
}

template ModeState<double> free_response(const Mode<double>&, const ModeState<double>&, double);
template ModeState<long double> free_response(const Mode<long double>&,
                                              const ModeState<long double>&, long double);
template ModeState<double> respond(const Mode<double>&, const ModeState<double>&,
                                   const ModeForce<double>&, double);
template ModeState<long double> respond(const Mode<long double>&, const ModeState<long double>&,
                                        const ModeForce<long double>&, long double);

namespace {

using Eigen::Index;
template <class Real> using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

/// Modes of a problem: q = r + shapes * eta, shapes^T M shapes = 1.
template <class Real> struct Modes {
  Vector<Real> root_mass;      ///< sqrt(m)
  Vector<Real> omega_squared;  ///< ascending
  Vector<Real> gamma;
  Matrix<Real> shapes;  ///< M^-1/2 Phi
};

/// Returns M^-1/2 A M^-1/2.
template <class Real>
Matrix<Real> mass_scaled(const Eigen::SparseMatrix<double>& matrix, const Vector<Real>& root_mass) {
  Matrix<Real> scaled = Eigen::MatrixXd(matrix).cast<Real>();
  scaled.array().colwise() /= root_mass.array();
  scaled.array().rowwise() /= root_mass.transpose().array();
  return scaled;
}

/// Returns eigenvalues, ascending, and eigenvectors.
template <class Real>
std::pair<Vector<Real>, Matrix<Real>> decompose(const LinearProblem& problem,
                                                const Vector<Real>& root_mass) {
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
    if (solver.info() != Eigen::Success) {
      throw SolverError("modal: no convergence of the modes");
    }
    return {solver.eigenvalues(), solver.eigenvectors()};
  }
}

template <class Real> Modes<Real> modes_of(const LinearProblem& problem) {
  Modes<Real> modes;
  modes.root_mass = problem.mass().cast<Real>().cwiseSqrt();
  std::tie(modes.omega_squared, modes.shapes) = decompose(problem, modes.root_mass);
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

/// Returns the force on one mode in one segment, with time counted from the start of the segment.
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
template <class Real> struct ModalHistory {
  Matrix<Real> position;
  Matrix<Real> velocity;
};

template <class Real>
ModalHistory<Real> history(const LinearProblem& problem, const Modes<Real>& modes,
                           const std::vector<double>& times) {
  const std::vector<Segment> segments = segments_of(problem, times);
  const std::vector<ShapedLoad> loads = shaped_loads(problem);
  const Index n = problem.dof();
  Matrix<Real> shares(static_cast<Index>(loads.size()), n);  // component of each load in each mode
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
  return decompose<double>(linear, root_mass).first.cwiseMax(0.0).cwiseSqrt();
}

namespace {

template <class Real>
Trace modal_solution(const Problem& problem, const std::vector<double>& times) {
  const auto begun = std::chrono::steady_clock::now();
  const LinearProblem linear(problem);
  const Modes<Real> modes = modes_of<Real>(linear);
  const ModalHistory<Real> modal = history(linear, modes, times);
  Trace solution{.time = times,
                 .method = std::is_same_v<Real, double> ? "modal" : "modal-long-double",
                 .version = "modal superposition"};
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

}  // namespace

Trace solve_modal(const Problem& problem, const std::vector<double>& times, const Tolerance&) {
  return modal_solution<double>(problem, times);
}

Trace solve_modal_long_double(const Problem& problem, const std::vector<double>& times,
                              const Tolerance&) {
  return modal_solution<long double>(problem, times);
}

}  // namespace palpate::reference

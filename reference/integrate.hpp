// SPDX-License-Identifier: MIT
#pragma once
/// Problem as a first-order system for solver libraries: y = [u; v], u = q - q(0) [m], v [m/s], y'
/// = [v; f(t, q(0) + u, v) / m]. Displacements are used instead of positions, so that relative
/// tolerances and rounding do not depend on the origin.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

class FirstOrderSystem {
 public:
  explicit FirstOrderSystem(const Problem& problem);

  [[nodiscard]] const Problem& problem() const { return *problem_; }
  [[nodiscard]] Eigen::Index dof() const { return origin_.size(); }
  [[nodiscard]] Eigen::Index size() const { return 2 * origin_.size(); }
  [[nodiscard]] long evaluations() const { return evaluations_; }
  [[nodiscard]] const Eigen::VectorXd& origin() const { return origin_; }  ///< q(0) [m]

  void set_gate(double gate) { gate_ = gate; }  ///< midpoint of the current segment [s]
  [[nodiscard]] Eigen::VectorXd initial_state() const;
  /// Returns the scales of positions and velocities of a tolerance, one per component of y.
  [[nodiscard]] Eigen::VectorXd scales(const Tolerance& tolerance) const;
  /// Computes y'. Returns false if a component is not finite, because the error tests of many
  /// solvers accept NaN.
  [[nodiscard]] bool derivative(double t, const double* y, double* dy);

 private:
  const Problem* problem_;
  Eigen::VectorXd origin_;
  Eigen::VectorXd inverse_mass_;
  Eigen::VectorXd position_;
  double gate_ = 0.0;
  long evaluations_ = 0;
};

/// Sparse matrix with the indices of the solver libraries.
using SparseJacobian = Eigen::SparseMatrix<double, Eigen::ColMajor, std::int64_t>;

/// Returns the Jacobian dy'/dy = [0 I; -K/m -C/m] at y. The pattern includes the whole diagonal, so
/// that I - gamma J has the same pattern.
SparseJacobian first_order_jacobian(const FirstOrderSystem& system, const double* y);

// Segments of the time axis between the instants at which a load switches. The right-hand side is
// smooth within a segment, so that a method keeps its order.

/// Smallest number of steps per segment, which guarantees steps >= breaks + 10.
inline constexpr int steps_per_segment = 10;

/// Instant at which a solver must end a step.
struct Stop {
  double time = 0.0;                    ///< [s]
  std::optional<std::size_t> output{};  ///< index of the requested time that is stored here
};

struct Segment {
  double start = 0.0;         ///< [s] a break, or 0
  double end = 0.0;           ///< [s] the next break, or the last requested time
  double gate = 0.0;          ///< midpoint, which selects the active loads [s]
  double max_step = 0.0;      ///< [s] <= shortest feature / 4 and <= (end - start) / 10
  std::vector<Stop> stops{};  ///< ascending; the last is `end`
};

/// Returns the segments. `times` [s] must ascend strictly from 0 (else SolverError). A requested
/// time within rounding of a break is moved to the break. Returns nothing for the single time 0.
std::vector<Segment> segments_of(const Problem& problem, const std::vector<double>& times);

/// Largest number of steps between two stops; more steps are an error.
inline constexpr long step_limit = 10'000'000;

/// Interface of an integrator of one problem, which begins at the initial state.
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual void begin(const Segment& segment) = 0;  ///< restarts at segment.start
  virtual void advance(double time) = 0;           ///< [s]; throws SolverError
  /// Writes the present position [m] and velocity [m/s].
  virtual void read(Eigen::Ref<Eigen::VectorXd> position,
                    Eigen::Ref<Eigen::VectorXd> velocity) const = 0;
  [[nodiscard]] virtual long segment_steps() const = 0;  ///< since begin()
  [[nodiscard]] virtual long evaluations() const = 0;
};

/// Integrator of a library for y = [u; v] of a FirstOrderSystem.
class SystemIntegrator : public Integrator {
 public:
  explicit SystemIntegrator(const Problem& problem) : system_(problem) {}
  void read(Eigen::Ref<Eigen::VectorXd> position,
            Eigen::Ref<Eigen::VectorXd> velocity) const override;
  [[nodiscard]] long evaluations() const override { return system_.evaluations(); }

 protected:
  [[nodiscard]] virtual const double* state() const = 0;

  FirstOrderSystem system_;
};

struct Method {
  std::string name{};     ///< "cvode-adams"
  std::string version{};  ///< "SUNDIALS 6.4.1"
};

/// Integrates to each requested time and restarts at each break. Throws SolverError, also if steps
/// < breaks + 10 or if the result is not finite.
Trace integrate(const Method& method, const Problem& problem, const std::vector<double>& times,
                const Tolerance& tolerance, Integrator& integrator);

/// Makes GSL return its error codes; its default handler aborts the program.
void return_gsl_errors();

/// Throws a SolverError such as "cvode-adams: CVode failed with CV_TOO_MUCH_WORK at t = 0.01 s:
/// <why>".
[[noreturn]] void fail(const std::string& solver, const std::string& function,
                       const std::string& flag, double time, const std::string& why);

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#pragma once
/// One number for the distance of two trajectories. A value that is not finite, anywhere, makes the
/// error infinite: it can never pass a limit.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "reference/solution.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

/// Trajectories are matrices of coordinates x instants; std::invalid_argument when sizes differ.
/// scale: what counts as 100 %. When it is 0 (nothing moves) any difference is infinite.

/// Largest |q - q(first instant)| of a trajectory [m].
double peak_displacement(const Eigen::MatrixXd& position);
/// Largest |v| [m/s].
double peak_speed(const Eigen::MatrixXd& velocity);

/// Largest difference over the coordinates at each instant, over scale.
std::vector<double> instant_errors(const Eigen::MatrixXd& candidate,
                                   const Eigen::MatrixXd& reference, double scale);

/// Largest of instant_errors.
double trajectory_error(const Eigen::MatrixXd& candidate, const Eigen::MatrixXd& reference,
                        double scale);

/// -log10 of an error, between 0 and 17; 0 for an infinite one.
double digits(double error);

/// Mixed-error significant digits at the last instant (Bari test set):
/// -log10 max |candidate - reference| / (scale + |reference - first instant of the reference|).
double mixed_error_digits(const Eigen::MatrixXd& candidate, const Eigen::MatrixXd& reference,
                          double scale);

// When a computed trajectory may be called a reference: several methods of different families
// agree, tighter tolerances come closer, energy balances where it must. Every check that was not
// made is named in `notes`.

struct EstablishOptions {
  int rungs = 4;                 ///< tolerances of the primary; 1 where a ladder costs too much
  double rung_ratio = 100.0;     ///< between neighbouring tolerances
  double demanded_digits = 9.0;  ///< of agreement, in position
  const Cache* cache = nullptr;  ///< of solutions between runs; nullptr: none
  bool permute_springs = false;  ///< run once more with the springs in another order
};

/// One tolerance of the primary against its finest.
struct Rung {
  double relative_tolerance = 0.0;
  double position_error = 0.0;  ///< as trajectory_error; infinite when the solver failed
  double velocity_error = 0.0;
  long steps = 0;
  long evaluations = 0;
  double seconds = 0.0;
};

/// Errors are relative to the peak displacement and the peak speed of the primary.
struct Reference {
  Trace solution{};                      ///< the primary, at the finest tolerance
  std::vector<Trace> second_opinions{};  ///< the other families
  std::vector<Rung> ladder{};            ///< coarse to fine, without the finest itself
  bool ladder_is_monotone = false;
  double agreed_digits = 0.0;  ///< in position, worst instant, worst second opinion
  double agreed_velocity_digits = 0.0;
  std::vector<double> position_floor{};  ///< disagreement at each stored instant
  std::vector<double> velocity_floor{};
  std::optional<double> energy_digits{};        ///< undamped and unloaded problems only
  std::optional<double> conditioning_digits{};  ///< of the run with permuted springs
  bool trustworthy = false;
  std::string reason{};              ///< why not; empty when trustworthy
  std::vector<std::string> notes{};  ///< checks not made, and why
};

/// families: the primary first, then at least one of another family (std::invalid_argument
/// otherwise). SolverError when the primary fails; a second opinion that fails is a reason.
Reference establish(const Problem& problem, const std::vector<double>& times,
                    const Tolerance& finest, const std::vector<NamedSolver>& families,
                    const EstablishOptions& options = {});

/// Digits of energy conservation along a solution, relative to its largest kinetic energy; nothing
/// for a problem that is damped, loaded, or of an unknown kind.
std::optional<double> energy_digits(const Problem& problem, const Trace& solution);

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#pragma once
/// Distance of two trajectories, and the cross-check of several solvers. Any value that is not
/// finite makes an error infinite, so that no limit accepts it.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "reference/solution.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

// Trajectories are matrices of coordinates x instants; different sizes throw std::invalid_argument.
// `scale` is the reference value of relative errors; if it is 0, any difference is infinite.

/// Returns the largest |q - q(first instant)| of a trajectory [m].
double peak_displacement(const Eigen::MatrixXd& position);
/// Returns the largest |v| of a trajectory [m/s].
double peak_speed(const Eigen::MatrixXd& velocity);

/// Returns the largest difference over the coordinates at each instant, divided by `scale` [1].
std::vector<double> instant_errors(const Eigen::MatrixXd& candidate,
                                   const Eigen::MatrixXd& reference, double scale);

/// Returns the largest of instant_errors [1].
double trajectory_error(const Eigen::MatrixXd& candidate, const Eigen::MatrixXd& reference,
                        double scale);

/// Returns -log10 of an error, between 0 and 17; 0 for an infinite one.
double digits(double error);

// Cross-check of references. A computed trajectory is accepted as a reference if methods of
// different families agree, if tighter tolerances converge, and if the energy balances. `notes`
// lists every check that was not made.

struct EstablishOptions {
  int rungs = 4;                 ///< number of tolerances of the primary solver; 1: no ladder
  double rung_ratio = 100.0;     ///< between neighbouring tolerances
  double demanded_digits = 9.0;  ///< of agreement, in position
  const Cache* cache = nullptr;  ///< solutions of earlier runs; nullptr: none
  bool permute_springs = false;  ///< repeat the run with the springs in another order
};

/// Error of the primary solver at one tolerance, compared with its finest tolerance.
struct Rung {
  double relative_tolerance = 0.0;
  double position_error = 0.0;  ///< as trajectory_error; infinite if the solver failed
  double velocity_error = 0.0;
  long steps = 0;
  long evaluations = 0;
  double seconds = 0.0;
};

/// Result of a cross-check. Errors are relative to the peak displacement and the peak speed of the
/// primary.
struct Reference {
  Trace solution{};                      ///< the primary, at the finest tolerance
  std::vector<Trace> second_opinions{};  ///< solutions of the other families
  std::vector<Rung> ladder{};            ///< coarse to fine, without the finest itself
  bool ladder_is_monotone = false;
  double agreed_digits = 0.0;  ///< in position, worst instant, worst second opinion
  double agreed_velocity_digits = 0.0;
  std::vector<double> position_floor{};  ///< disagreement at each stored instant
  std::vector<double> velocity_floor{};
  std::optional<double> energy_digits{};        ///< undamped and unloaded problems only
  std::optional<double> conditioning_digits{};  ///< of the run with permuted springs
  bool trustworthy = false;
  std::string reason{};              ///< reason for rejection; empty if accepted
  std::vector<std::string> notes{};  ///< checks not made, and why
};

/// Runs the cross-check. `families` contains the primary first, then at least one of another family
/// (else std::invalid_argument). Throws SolverError if the primary fails; if another solver fails,
/// the reference is rejected.
Reference establish(const Problem& problem, const std::vector<double>& times,
                    const Tolerance& finest, const std::vector<NamedSolver>& families,
                    const EstablishOptions& options = {});

/// Returns the digits of energy conservation along a solution, relative to its largest kinetic
/// energy. Returns nothing for a problem that is damped, loaded, or of an unknown kind.
std::optional<double> energy_digits(const Problem& problem, const Trace& solution);

}  // namespace palpate::reference

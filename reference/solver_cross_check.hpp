// SPDX-License-Identifier: MIT
#pragma once
/// Distance of two trajectories, and the cross-check of several solvers. Any value that is not
/// finite makes an error infinite, so that it cannot pass a limit.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "reference/solution.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

// Trajectories are matrices of coordinates x instants; different sizes throw std::invalid_argument.
// `scale` is the reference value of relative errors; if it is 0, any difference is infinite.

/// Largest |q - q(first instant)| of a trajectory [m].
double peak_displacement(const Eigen::MatrixXd& position);
/// Largest |v| [m/s].
double peak_speed(const Eigen::MatrixXd& velocity);

/// Largest difference over the coordinates at each instant, divided by `scale`.
std::vector<double> instant_errors(const Eigen::MatrixXd& candidate,
                                   const Eigen::MatrixXd& reference, double scale);

/// Largest of instant_errors.
double trajectory_error(const Eigen::MatrixXd& candidate, const Eigen::MatrixXd& reference,
                        double scale);

/// -log10 of an error, between 0 and 17; 0 for an infinite one.
double digits(double error);

// A computed trajectory is a reference if several methods of different families agree, if tighter
// tolerances converge, and if the energy balances. `notes` names every check that was not made.

struct EstablishOptions {
  int rungs = 4;                 ///< number of tolerances of the primary solver; 1: no ladder
  double rung_ratio = 100.0;     ///< between neighbouring tolerances
  double demanded_digits = 9.0;  ///< of agreement, in position
  const Cache* cache = nullptr;  ///< solutions of earlier runs; nullptr: none
  bool permute_springs = false;  ///< run once more with the springs in another order
};

/// Error of the primary solver at one tolerance, compared with its finest.
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

/// Digits of energy conservation along a solution, relative to its largest kinetic energy. Empty
/// for a problem that is damped, loaded, or of an unknown kind.
std::optional<double> energy_digits(const Problem& problem, const Trace& solution);

}  // namespace palpate::reference

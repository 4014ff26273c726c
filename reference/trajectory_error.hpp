// SPDX-License-Identifier: MIT
#pragma once
/// One number for the distance of two trajectories. A value that is not finite, anywhere, makes the
/// error infinite: it can never pass a limit.

#include <Eigen/Core>
#include <vector>

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

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the errata cases: a small lattice, an independent linearisation of the printed
/// equations, and the growth or decay rate of a mode in a run of the model.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "reference/solution.hpp"
#include "validation/case.hpp"

namespace palpate::errata {

inline constexpr double step = 1e-4;      ///< h [s], a tenth of the stable step
inline constexpr double duration = 0.05;  ///< duration of a run of a pressed lattice [s]
inline constexpr double press = 0.02;     ///< force on the middle of the top, inwards [N]
inline constexpr int pressed_node = 4;

/// Returns a scene of 3 x 3 x 3 nodes of 1 g, 5 mm apart, with 26 neighbours, 50 N/m and 0.02 N s/m
/// each, and the bottom fixed.
Scene lattice_scene(double h, double seconds, const std::string& integrator = "euler-cromer");
Scene pressed_scene(double h, double seconds, const PrintedForm& printed = {});

/// Linearised motion u'' = -K u - C v for small displacements, divided by mass.
struct Linear {
  Eigen::MatrixXd stiffness{};  ///< M^-1 K [1/s^2]
  Eigen::MatrixXd damping{};    ///< M^-1 C [1/s]
};

/// Linearises a network from its springs and the printed equations, without the force law of the
/// model. damping_factor multiplies C to account for the lag of Eq. 9 if the step differs from its
/// h.
Linear linearise(const SpringNetwork& network, const PrintedForm& printed,
                 double damping_factor = 1.0);

/// Left eigenvector w of s(n+1) = S s(n), or of s' = S s. The product w^T s is multiplied by the
/// eigenvalue z, independent of the other modes in s.
struct Mode {
  Eigen::VectorXcd left{};  ///< w, scaled so that its largest position weight is real
  std::complex<double> value{};
};
/// Returns the mode of Euler-Cromer with step h [s] that grows most or decays least.
Mode dominant_mode(const Linear& linear, double h);
/// Returns the mode of the exact motion that grows most or decays least.
Mode dominant_mode(const Linear& linear);

/// Displaces the free nodes along the position weights of a mode by at most `amplitude` [m].
SpringNetwork displaced(SpringNetwork network, const Mode& mode, double amplitude);

/// Returns log |w^T s(last) / w^T s(0)|; NaN if the motion is not finite or ended early.
double log_growth(const Mode& mode, const SpringNetwork& network, const Eigen::MatrixXd& position,
                  const Eigen::MatrixXd& velocity);

/// Growth rate [1/s], measured in the model and predicted.
struct Rate {
  double measured = 0.0;
  double predicted = 0.0;  ///< for Euler-Cromer with this step on the linearised equations
  double motion = 0.0;     ///< for the exact linearised motion
  long steps = 0;          ///< number of steps of the measurement
};
/// Measures a growth rate; `update` is the step length in the printed form, h or 1.
Rate measure_rate(const CaseContext& context, const PrintedForm& printed, double h, double update,
                  double damping_factor = 1.0);
/// Returns the same growth rate from a solution of the printed equations by an external solver.
double reference_rate(const PrintedForm& printed);

/// Motion of a lattice pressed from t = 0, sampled at pressed_times().
struct Pressed {
  std::vector<double> time{};      ///< [s]
  Eigen::MatrixXd displacement{};  ///< free coordinates x times [m]
  bool diverged = false;
  double diverged_at = 0.0;  ///< [s]
};
inline constexpr long sample_count = 100;
std::vector<double> pressed_times();
/// Runs the pressed lattice; `ticks` must be a multiple of sample_count.
Pressed run_pressed(const CaseContext& context, const PrintedForm& printed, long ticks);
/// Solves the pressed lattice with ARKODE.
Eigen::MatrixXd solve_pressed(const std::vector<double>& times, const PrintedForm& printed);
/// Returns the largest difference over the peak of the truth; NaN if a run ended early.
double distance(const Eigen::MatrixXd& found, const Eigen::MatrixXd& truth);

/// Row of the summary.
struct Finding {
  std::string erratum{};
  std::string printed{};   ///< place in the paper
  std::string effect{};    ///< in words
  std::string quantity{};  ///< with unit
  double measured = 0.0;
  double predicted = 0.0;
};

// Pressed lattice with and without an erratum, with the same scheme and step, compared with ARKODE.

/// Judges the corrected model, measures the printed form, and adds the table and the figure.
void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name);

// Cases of the individual errata. Each adds its quantities, tables and figures and returns its row
// of the summary.

Finding measure_sign(const CaseContext& context, Outcome& outcome);
Finding measure_reversed(const CaseContext& context, Outcome& outcome);
Finding measure_no_time_step(const CaseContext& context, Outcome& outcome);
Finding measure_all_printed(const CaseContext& context, Outcome& outcome);
Finding measure_direction(const CaseContext& context, Outcome& outcome);
Finding measure_half_force(const CaseContext& context, Outcome& outcome);
Finding measure_lagged_velocity(const CaseContext& context, Outcome& outcome);

}  // namespace palpate::errata

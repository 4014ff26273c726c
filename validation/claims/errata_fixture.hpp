// SPDX-License-Identifier: MIT
#pragma once
/// What the errata cases share: a small lattice, its linearisation written out a second time from
/// the printed equations, and the growth or decay of a mode read off a run of the model.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "reference/solution.hpp"
#include "validation/case.hpp"

namespace palpate::errata {

inline constexpr double step = 1e-4;      ///< h [s], a tenth of the stable step
inline constexpr double duration = 0.05;  ///< [s] of a pressed lattice
inline constexpr double press = 0.02;     ///< [N] on the middle of the top, inwards
inline constexpr int pressed_node = 4;

/// 3 x 3 x 3 nodes of 1 g, 5 mm apart, 26 neighbours, 50 N/m and 0.02 N s/m each, bottom fixed.
Scene lattice_scene(double h, double seconds, const std::string& integrator = "euler-cromer");
Scene pressed_scene(double h, double seconds, const PrintedForm& printed = {});

/// u'' = -K u - C v for small displacements, mass divided out.
struct Linear {
  Eigen::MatrixXd stiffness{};  ///< M^-1 K [1/s^2]
  Eigen::MatrixXd damping{};    ///< M^-1 C [1/s]
};

/// From the springs and the printed equations alone; no force law of the model is used.
/// damping_factor: what the lag of Eq. 9 multiplies C by when steps are not of its h.
Linear linearise(const SpringNetwork& network, const PrintedForm& printed,
                 double damping_factor = 1.0);

/// A mode of s(n+1) = S s(n), or of s' = S s: with S^T w = z w, w^T s multiplies by z, whatever
/// else s holds.
struct Mode {
  Eigen::VectorXcd left{};  ///< w, turned so that its largest position weight is real
  std::complex<double> value{};
};
/// Euler-Cromer with steps of h: the mode that grows most, or decays least.
Mode dominant_mode(const Linear& linear, double h);
/// The motion itself: the mode that grows most, or decays least.
Mode dominant_mode(const Linear& linear);

/// The free nodes displaced along the position weights of a mode, `amplitude` [m] at most.
SpringNetwork displaced(SpringNetwork network, const Mode& mode, double amplitude);

/// log |w^T s(last) / w^T s(0)|; NaN when the motion is not finite or ended early.
double log_growth(const Mode& mode, const SpringNetwork& network, const Eigen::MatrixXd& position,
                  const Eigen::MatrixXd& velocity);

/// A rate of growth [1/s], measured on the model and predicted.
struct Rate {
  double measured = 0.0;
  double predicted = 0.0;  ///< of Euler-Cromer with this step on the linearised equations
  double motion = 0.0;     ///< of the linearised equations themselves
  long steps = 0;          ///< over which it was measured
};
/// update: the length of step that the printed form takes, h or 1.
Rate measure_rate(const CaseContext& context, const PrintedForm& printed, double h, double update,
                  double damping_factor = 1.0);
/// The same growth in a solution of the printed equations by somebody else's solver.
double reference_rate(const PrintedForm& printed);

/// A lattice that is pressed from t = 0 on, sampled at pressed_times().
struct Pressed {
  std::vector<double> time{};      ///< [s]
  Eigen::MatrixXd displacement{};  ///< free coordinates x times [m]
  bool diverged = false;
  double diverged_at = 0.0;  ///< [s]
};
inline constexpr long sample_count = 100;
std::vector<double> pressed_times();
/// `ticks`: a multiple of sample_count.
Pressed run_pressed(const CaseContext& context, const PrintedForm& printed, long ticks);
/// The same by ARKODE.
Eigen::MatrixXd solve_pressed(const std::vector<double>& times, const PrintedForm& printed);
/// Largest difference over the peak of the truth; NaN when a run ended early.
double distance(const Eigen::MatrixXd& found, const Eigen::MatrixXd& truth);

/// One line of the summary.
struct Finding {
  std::string erratum{};
  std::string printed{};   ///< where
  std::string effect{};    ///< in words
  std::string quantity{};  ///< with unit
  double measured = 0.0;
  double predicted = 0.0;
};

// A pressed lattice with and without an erratum, at the same scheme and step, beside ARKODE.

/// Judges the corrected model, measures the printed form, adds the table and the figure.
void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name);

// The errata one by one; each adds what it judges, tables and figures, and gives its line of the
// summary.

Finding measure_sign(const CaseContext& context, Outcome& outcome);
Finding measure_reversed(const CaseContext& context, Outcome& outcome);
Finding measure_no_time_step(const CaseContext& context, Outcome& outcome);
Finding measure_all_printed(const CaseContext& context, Outcome& outcome);
Finding measure_direction(const CaseContext& context, Outcome& outcome);
Finding measure_half_force(const CaseContext& context, Outcome& outcome);
Finding measure_lagged_velocity(const CaseContext& context, Outcome& outcome);

}  // namespace palpate::errata

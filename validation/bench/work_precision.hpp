// SPDX-License-Identifier: MIT
#pragma once
/// Work-precision frontier: minimum cost for an error and minimum error for a cost.

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "validation/case.hpp"

namespace palpate::bench {

// Error as a function of cost: every scheme with every number of substeps, and solvers of other
// libraries at every tolerance, on one scene.

/// Signal that the errors refer to: rows of Trace::position [m], or without rows the column
/// "tool.force_n" [N].
struct Signal {
  Eigen::Index first = 0;
  Eigen::Index count = 0;

  [[nodiscard]] Eigen::MatrixXd of(const Trace& run) const;  ///< components x ticks
};

/// Reference motion and the distance between two references. The traces have the column "energy_j".
struct Truth {
  Trace run{};
  Signal signal{};
  double peak = 0.0;             ///< peak of the signal
  double travel = 0.0;           ///< largest displacement of any coordinate [m]
  double energy = 0.0;           ///< largest change of energy [J]
  std::vector<bool> left_out{};  ///< ticks at jumps of the signal; empty: none
  double floor = 0.0;            ///< error of the second reference in the signal
};

/// Errors relative to the peak, travel and energy of the truth: maximum over time, or root mean
/// square.
struct Errors {
  double tool = 0.0;
  double tool_mean = 0.0;
  double tool_at_end = 0.0;  ///< error of the largest component of the final signal, relative to it
  double trajectory = 0.0;
  double trajectory_mean = 0.0;
  double energy = 0.0;
};

/// Result of one method at one setting.
struct Point {
  std::string method{};   ///< "rk4", "rk4, float", "cvode-adams"
  std::string setting{};  ///< "4 substeps", "1e-06"
  enum class Kind { in_double, in_float, automatic, elsewhere } kind = Kind::in_double;
  bool far_field = false;  ///< a reduced-order model is used away from the tool
  double seconds = 0.0;    ///< least
  double median = 0.0;     ///< [s]
  /// Minimum time before the first tick [s]; only for methods of this program.
  double loading = std::numeric_limits<double>::quiet_NaN();
  long evaluations = 0;
  Errors errors{};

  [[nodiscard]] bool here() const { return kind != Kind::elsewhere; }
};

/// Returns the minimum cost of any method in force evaluations for an error at the tool, by linear
/// interpolation between its points in logarithmic coordinates. If the cheapest point of a method
/// is more accurate, its cost counts. NaN if no method reaches the error.
double cost_at(std::span<const Point> points, double error);

/// Returns the decimal digits of the best method for a cost, interpolated likewise; beyond its most
/// expensive point a method has the digits of that point. NaN if no method is so cheap.
double digits_at(std::span<const Point> points, double cost);

/// Settings of the reduced-order model.
struct Reduction {
  double near_radius = 0.0;  ///< radius of the full model [m]; 0: no reduced-order model
  int far_modes = 0;
};

/// Scene with the methods that are compared on it.
struct Study {
  Scene scene{};
  std::string tool = "tip";  ///< signal that the error refers to
  std::vector<std::string> schemes{};
  std::vector<std::string> solvers{};
  Reduction reduction{};
  std::vector<std::string> schemes_of_reduction{};
  int least_substeps = 1;
  int most_substeps = 64;
  bool in_float = true;
  std::function<Trace(const std::string& solver, double tolerance)> there{};
  Truth truth{};
};

/// Runs the model on a scene and counts its force evaluations.
Trace run_here(const CaseContext& context, const Scene& scene);

/// Computes the scales of the errors, and the floor from a second reference.
Truth truth_of(Trace first, const Trace& second, const Signal& signal,
               std::vector<bool> left_out = {});
/// Infinite for a run that diverged, ended early or is not finite.
Errors errors_of(const Trace& run, const Truth& truth);

/// Measures every setting of the study. The last point is integrator = "auto", preceded by its
/// choice with a reduced-order model. Omitted are settings that diverge, have an error larger than
/// the peak, or would take longer than `patience` [s].
std::vector<Point> measure_points(const CaseContext& context, const Study& study, double patience,
                                  int rounds);

/// Points that are searched: all of the model, those of the model in double with every node, which
/// solve the problem of the libraries, or those of the libraries.
enum class Among { here, here_as_libraries, libraries };

/// Returns the fastest of these points with at most this error at the tool; nullptr if none.
const Point* cheapest(const std::vector<Point>& points, double error, Among among);

/// Returns true if no point of its kind is both faster and more accurate. "auto" is compared with
/// double-precision points; points with a reduced-order model are compared with each other.
bool on_frontier(const std::vector<Point>& points, const Point& point);

/// Returns the largest ratio of the time of "auto" to that of the fastest double-precision setting
/// of its kind with at most its error. To exclude noise, the median of that setting is compared
/// with the minimum of "auto". NaN without an "auto".
double automatic_over_best(const std::vector<Point>& points);

/// Returns the largest error of all "auto" points at the tool; NaN without one.
double largest_error_of_automatic(const std::vector<Point>& points);

/// Returns the relative difference of run times that is not significant: the 90th percentile over
/// the settings of the difference between minimum and median of the rounds, at least 0.1 as for
/// kernels.
double noise_of(const std::vector<Point>& points);

void add_tables(const std::vector<Point>& points, const Study& study, Outcome& outcome);
void add_figures(const std::vector<Point>& points, const Study& study, Outcome& outcome);

}  // namespace palpate::bench

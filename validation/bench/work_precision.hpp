// SPDX-License-Identifier: MIT
#pragma once
/// The edge of what is possible: the least cost for an error, and the least error for a cost.

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "validation/case.hpp"

namespace palpate::bench {

/// One way of computing a motion.
struct Effort {
  std::string method{};
  double cost = 0.0;   ///< > 0, evaluations of the force
  double error = 0.0;  ///< > 0, over the peak
};

/// Least cost of any method for an error, on the straight lines between its points where both axes
/// are logarithmic. A method whose cheapest point is nearer still costs what that one costs; NaN
/// where none comes so near.
double cost_at(std::span<const Effort> efforts, double error);

/// Decimal digits that the best method has for a cost, likewise; beyond its dearest point it has
/// those of that one. NaN where none is so cheap.
double digits_at(std::span<const Effort> efforts, double cost);

// Error against what it costs: every scheme with every number of substeps, and solvers of other
// libraries at every tolerance, on one scene.

/// A motion sampled at the ticks.
struct MethodRun {
  Eigen::MatrixXd
      tool{};  ///< what a hand feels or sees: a point's place [m] or a force [N], x ticks
  Eigen::MatrixXd position{};  ///< coordinates x ticks [m]
  Eigen::VectorXd energy{};    ///< stored and kinetic [J]
  double seconds = 0.0;        ///< for the whole motion
  long evaluations = 0;        ///< of the force
  bool failed = false;
};

/// The motion itself, and how far two references are apart.
struct Truth {
  MethodRun run{};
  double peak = 0.0;             ///< of the tool's signal
  double travel = 0.0;           ///< largest displacement of any coordinate [m]
  double energy = 0.0;           ///< largest change of energy [J]
  std::vector<bool> left_out{};  ///< ticks where the tool's signal jumps; empty: none
  double floor = 0.0;            ///< error of the second reference at the tool
};

/// Over the truth's peak, travel and energy: largest over time, or root mean square.
struct Errors {
  double tool = 0.0;
  double tool_mean = 0.0;
  double tool_at_end = 0.0;  ///< of the signal's largest component then, over that component
  double trajectory = 0.0;
  double trajectory_mean = 0.0;
  double energy = 0.0;
};

/// One way of computing the motion.
struct Point {
  std::string method{};   ///< "rk4", "rk4, float", "cvode-adams"
  std::string setting{};  ///< "4 substeps", "1e-06"
  enum class Kind { in_double, in_float, automatic, elsewhere } kind = Kind::in_double;
  bool far_field = false;  ///< what is far from the tool is reduced
  double seconds = 0.0;    ///< least
  double median = 0.0;     ///< [s]
  /// Before the first tick, least [s]; only of what is computed here.
  double loading = std::numeric_limits<double>::quiet_NaN();
  long evaluations = 0;
  Errors errors{};

  [[nodiscard]] bool here() const { return kind != Kind::elsewhere; }
};

/// What is left to a far field beside computing every node.
struct Reduction {
  double near_radius = 0.0;  ///< [m]; 0: nothing
  int far_modes = 0;
};

/// A scene, and everybody who computes it.
struct Study {
  Scene scene{};
  std::string tool = "tip";  ///< whose error is meant
  std::vector<std::string> schemes{};
  std::vector<std::string> solvers{};
  Reduction reduction{};
  std::vector<std::string> schemes_of_reduction{};
  int least_substeps = 1;
  int most_substeps = 64;
  bool in_float = true;
  std::function<MethodRun(const Scene&)> here{};
  std::function<MethodRun(const std::string& solver, double tolerance)> there{};
  Truth truth{};
};

/// Fills in the sizes that errors are taken over, and the floor from a second reference.
Truth truth_of(MethodRun first, const MethodRun& second, std::vector<bool> left_out = {});
Errors errors_of(const MethodRun& run, const Truth& truth);

/// Every setting of the study; the last is what integrator = "auto" chooses, and before it what it
/// chooses where there is a far field. Settings that diverge or are further off than the peak are
/// left out, and so is what would take longer than `patience` [s].
std::vector<Point> measure_points(const Study& study, double patience, int rounds);

/// The quickest of a kind whose error at the tool is no larger; nullptr if none.
const Point* cheapest(const std::vector<Point>& points, double error, bool here);

/// Whether nothing of its kind is both quicker and nearer; "auto" belongs to what is computed in
/// double, and what has a far field stands against its like.
bool on_frontier(const std::vector<Point>& points, const Point& point);

/// How much longer "auto" takes than the quickest setting in double of its kind that is no further
/// off, at worst. What could be chance does not count: that setting's median against the least of
/// "auto". NaN without an "auto".
double automatic_over_best(const std::vector<Point>& points);

/// Of every "auto", at the tool; NaN without one.
double largest_error_of_automatic(const std::vector<Point>& points);

/// What difference of run times says nothing: how far the least and the median of a setting's
/// rounds are apart in this table, at the worst of nine in ten, and a tenth at least, as for
/// kernels.
double noise_of(const std::vector<Point>& points);

void add_tables(const std::vector<Point>& points, const Study& study, Outcome& outcome);
void add_figures(const std::vector<Point>& points, const Study& study, Outcome& outcome);

}  // namespace palpate::bench

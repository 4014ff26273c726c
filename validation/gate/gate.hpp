// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of results with a baseline (docs/gate.md). Bitwise equal results pass. Results that
/// are not finite or incomplete fail before any norm is computed. Then rounding, errors, costs and
/// curves are compared.

#include <string>
#include <string_view>
#include <vector>

#include "validation/gate/baseline.hpp"
#include "validation/outcome.hpp"

namespace palpate::gate {

/// Kinds of change in order of severity; "worse" and the following ones fail.
enum class ChangeKind {
  same,      ///< bitwise equal
  rounding,  ///< the difference is within the measured effect of rounding
  within,    ///< the difference is within what is allowed
  better,    ///< an error or a cost became smaller
  worse,     ///< an error or a cost became larger
  moved,     ///< changed by more than is allowed, without a better direction
  broken     ///< cannot be compared: missing, not finite, of another unit, judged by another bound
};
std::string_view name_of(ChangeKind kind);

struct Change {
  std::string item{};  ///< name of a quantity or a curve; empty: the case itself
  ChangeKind kind = ChangeKind::same;
  double before = 0.0;
  double now = 0.0;
  std::string unit{};
  std::string moved{};        ///< "0.31 digits worse", or what cannot be compared
  std::string allowed{};      ///< "0.1 digits"
  double excess = 0.0;        ///< what moved, over what is allowed; 0: not a number
  std::string text_before{};  ///< of a text that changed, such as a key of the scene
  std::string text_now{};

  [[nodiscard]] bool fails() const { return kind >= ChangeKind::worse; }
};

// Limits of the allowed changes (docs/gate.md).

/// Number of decimal digits that errors, and all quantities with a better direction, may lose.
inline constexpr double allowed_digits = 0.1;
/// Relative change that is allowed for counts of work and numbers without a bound.
inline constexpr double allowed_share = 0.01;
/// Share of a two-sided bound's half width below which the distance from its middle is ignored.
inline constexpr double least_offset = 0.01;
/// Factor on the measured spread of rounding, which varies by a decade from build to build.
inline constexpr double spread_margin = 10.0;

/// An error may become smaller than its rounding only if it was not larger than that by 1 over
/// this share: what vanishes was probably compared with itself.
inline constexpr double vanishing = 1e-3;

/// Returns the difference in a unit that rounding alone may cause around zero, however small the
/// values are; 0 for a unit without such a difference. docs/gate.md has the table with reasons.
double floor_of(std::string_view unit);

/// Compares two quantities; `spread` is the measured effect of rounding [unit of the quantity]. A
/// quantity without a bound that has an uncertainty, such as the time of an event, may move by its
/// uncertainty and the spread.
Change compare_quantity(const Quantity& before, const Quantity& now, double spread);

// Distance of a curve from the tube around another curve.

/// Curve with increasing x, in the coordinates that are compared.
struct Path {
  std::vector<double> x{};
  std::vector<double> y{};
};

/// Half widths of a tube, in the coordinates of the paths.
struct Tube {
  double x = 0.0;
  double y = 0.0;
};

/// Largest distance between two curves: distance of a point of one from the range of the other
/// within the half width of the tube in x.
struct Excess {
  double y = 0.0;  ///< distance from the range of the other curve; 0: inside
  double x = 0.0;  ///< position of the largest distance
};

/// Returns the largest excess of a point of either curve over the other. x increases in both,
/// neither is empty, all values are finite. A point beyond the end of a curve by more than tube.x
/// has infinite distance.
Excess largest_excess(const Path& before, const Path& now, double half_width_x);

// Rule for curves: a curve must stay in the tube around the accepted one and must not be early or
// late (docs/gate.md).

/// Half widths of the tube as shares of the ranges. In x: one sample of a second at 1 kHz, because
/// rounding may move an event by one tick; at most `tube_samples` of a longer curve. In y: a fifth
/// of the effect of one per cent of stiffness, and at least floor_of() the unit.
inline constexpr double tube_x = 1e-3;
inline constexpr double tube_samples = 2.0;
inline constexpr double tube_y = 2e-3;
/// Minimum range of a curve as a share of the largest range in its figure.
inline constexpr double least_range = 0.01;
/// Half width of the tube on a logarithmic axis [decimal digits], the same as for errors.
inline constexpr double tube_digits = 0.1;
/// Lag of a whole curve that is allowed, in samples, if it has enough samples to measure the lag.
inline constexpr double allowed_lag = 0.5;
inline constexpr std::size_t least_samples_for_lag = 100;

/// Returns the tube of a series in the coordinates of the axes: decimal logarithms on a logarithmic
/// axis.
Tube tube_around(const Figure& figure, std::size_t series);

/// Compares the series with the same index and label of two figures; `spread` is the measured
/// effect of rounding on y, see curve_difference().
Change compare_curve(const Figure& before, const Figure& now, std::size_t series, double spread);

/// Returns the largest difference in y of two series, for a curve on linear axes the largest excess
/// over the tube in x: an event that moved by one tick is no difference. NaN if they cannot be
/// compared.
double curve_difference(const Figure& before, const Figure& now, std::size_t series);

/// Returns the lag of `now` in samples, from a least-squares fit of the difference by a lag, a gain
/// and an offset. NaN if the curve does not determine it, or if the lag explains less than half of
/// the difference.
double lag_in_samples(const std::vector<double>& x, const std::vector<double>& before,
                      const std::vector<double>& now);

/// One case compared with its baseline.
struct CaseChanges {
  Outcome outcome{};  ///< verdict that the case is not worse; reasons are the changes that fail
  bool identical = false;         ///< every number and every sample is equal
  std::vector<Change> changes{};  ///< all differences, worst first

  [[nodiscard]] bool fails() const { return outcome.status == Status::fail; }
  [[nodiscard]] bool better() const;  ///< at least one improvement and no failure
};

/// Numbers of cases by how they changed.
struct ChangeCounts {
  int identical = 0;
  int unchanged = 0;  ///< changed by rounding, or within the limits
  int better = 0;
  int failed = 0;
};

struct GateResult {
  std::vector<CaseChanges> cases{};  ///< in the order of the baseline, then those it lacks
  /// Reasons why the comparison as a whole is not valid: nothing selected, results of another
  /// command.
  std::vector<std::string> faults{};

  [[nodiscard]] ChangeCounts counts() const;
  /// Returns the verdict: error if there are faults, fail if a case fails.
  [[nodiscard]] Outcome outcome() const;
  /// Returns one outcome for each fault, then that of each case.
  [[nodiscard]] std::vector<Outcome> outcomes() const;
  [[nodiscard]] bool holds() const { return outcome().status == Status::pass; }
};

/// The results that a gate compares with the baseline.
struct Candidate {
  std::string command{};  ///< command line that produced the results
  std::vector<Outcome> outcomes{};
};

/// Splits a command line as a shell does, at spaces that are not quoted; nothing is expanded.
std::vector<std::string> shell_words(const std::string& line);

/// Returns how a command line that made results differs from that of a baseline, apart from the
/// order of cases and from options without an effect on judged results; empty if they agree. With
/// `in_part`, cases may differ.
std::string command_problem(const std::string& accepted, const std::string& candidate,
                            bool in_part);

/// Compares a candidate with a baseline. `only` selects cases by name on both sides; empty: all. A
/// case that is on one side only fails.
GateResult compare(const Baseline& baseline, const Candidate& candidate,
                   const std::vector<std::string>& only = {});

/// Compares one case with the accepted one; both as comparable() returns them.
CaseChanges compare_case(const AcceptedCase& accepted, const Outcome& now);

}  // namespace palpate::gate

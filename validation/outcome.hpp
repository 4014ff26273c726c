// SPDX-License-Identifier: MIT
#pragma once
/// The verdict type of the whole program. A validation case, a comparison with recordings, a
/// calibration, a gate and a real-time certificate each produce outcomes: a claim, the quantities
/// that were judged, a status and its reasons, with tables and figures as plain data.

#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace palpate {

enum class Status {
  pass,
  fail,
  inconclusive,  ///< the uncertainty is too large to decide, or a precondition is not met
  skip,          ///< not judged; the reason says why
  error          ///< judging was not possible; the reason says why
};
std::string_view name_of(Status status);

/// The more severe of two: error, fail, inconclusive, pass, skip.
Status worse(Status a, Status b);

inline constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A measured number and the interval that must contain it. NaN never passes.
struct Quantity {
  std::string name{};
  double value = 0.0;
  std::string unit = "1";
  double lower = -unbounded;
  double upper = unbounded;
  std::string bound_from{};  ///< theory, error of a reference, a publication; empty: not judged
  double uncertainty = 0.0;  ///< expanded uncertainty U of the value, in its unit

  [[nodiscard]] bool judged() const {
    return lower > -unbounded || upper < unbounded || !bound_from.empty();
  }
  /// pass: value - U to value + U lies within the bounds; fail: it lies outside; inconclusive: it
  /// contains a bound. Does not check judged().
  [[nodiscard]] Status status() const;
  [[nodiscard]] bool holds() const { return status() == Status::pass; }
};

/// Largest of the values added so far. NaN once one of them is NaN, unlike std::max, so that a
/// judged maximum fails its bound.
class Largest {
 public:
  explicit Largest(double at_least = 0.0) : value_(at_least) {}
  void add(double value) {
    if (!(value <= value_ || std::isnan(value_))) { value_ = value; }
  }
  [[nodiscard]] double value() const { return value_; }

 private:
  double value_;
};

/// Smallest of the values added so far. NaN once one of them is NaN.
class Smallest {
 public:
  explicit Smallest(double at_most = unbounded) : value_(at_most) {}
  void add(double value) {
    if (!(value >= value_ || std::isnan(value_))) { value_ = value; }
  }
  [[nodiscard]] double value() const { return value_; }

 private:
  double value_;
};

struct Series {
  /// band: faint, for what is allowed or uncertain; area: strong, for parts stacked on each other;
  /// thin: one of several alike curves, in the colour of the first series
  enum class Style { line, points, line_and_points, dashed, band, area, thin };
  std::string label{};
  Style style = Style::line;
  std::vector<double> x{};
  std::vector<double> y{};   ///< band and area: the lower edge
  std::vector<double> y2{};  ///< band and area: the upper edge

  [[nodiscard]] bool filled() const { return style == Style::band || style == Style::area; }
  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
};
Series curve(std::string label, std::vector<double> x, std::vector<double> y,
             Series::Style style = Series::Style::line);

struct Axis {
  std::string label{};  ///< with unit, "time (s)"
  bool logarithmic = false;
  std::optional<double> minimum{};
  std::optional<double> maximum{};
};
Axis logarithmic(std::string label);

/// Values on a regular grid, drawn as colours; z is row-major, z[row * columns + column].
struct HeatMap {
  std::string label{};
  std::vector<double> x{};
  std::vector<double> y{};
  std::vector<double> z{};
};

/// A named interval of the x axis, drawn as a tint behind the curves.
struct Zone {
  std::string label{};
  double begin = 0.0;
  double end = 0.0;
};

/// A vertical line at an event; marks of one label share a sign in the legend.
struct Mark {
  std::string label{};
  double x = 0.0;
};

struct Figure {
  std::string id{};  ///< unique within its case, [a-z0-9-]
  std::string title{};
  std::string caption{};  ///< one sentence that says what the figure shows
  Axis x{};
  Axis y{};
  std::deque<Series> series{};
  std::optional<HeatMap> heat_map{};
  std::vector<Zone> zones{};  ///< neighbours in alternating tints
  std::vector<Mark> marks{};
  bool square = false;  ///< equal scales on both axes
  bool timing = false;  ///< shows run times, which differ from run to run

  /// Adds a curve. References to curves stay valid when further ones are added.
  Series& add(std::string label, Series::Style style = Series::Style::line) {
    return series.emplace_back(Series{.label = std::move(label), .style = style});
  }
  Series& add(std::string label, std::vector<double> at, std::vector<double> value,
              Series::Style style = Series::Style::line);
};
Figure plot(std::string id, std::string title, std::string caption, Axis x, Axis y,
            std::deque<Series> series = {});

template <class T>
concept Arithmetic = std::is_arithmetic_v<T>;

/// A number of any arithmetic type, as double.
struct Number {
  double value = 0.0;
  template <Arithmetic T> Number(T number) : value(static_cast<double>(number)) {}
};

/// A text or a number of any arithmetic type.
struct Cell : std::variant<std::string, double> {
  Cell(std::string text) : variant(std::move(text)) {}
  Cell(std::string_view text) : variant(std::string(text)) {}
  Cell(const char* text) : variant(std::string(text)) {}
  template <Arithmetic T> Cell(T number) : variant(static_cast<double>(number)) {}
};

struct Table {
  std::string id{};
  std::string title{};
  std::string caption{};
  std::vector<std::string> columns{};  ///< with units
  std::vector<std::vector<Cell>> rows{};
  bool timing = false;
};
Table make_table(std::string id, std::string title, std::string caption,
                 std::vector<std::string> columns, std::vector<std::vector<Cell>> rows = {});

/// A measured run time or cost. It is not judged, and is left out when two runs are compared.
struct Timing {
  std::string name{};
  double value = 0.0;
  std::string unit = "s";
};

struct Outcome {
  std::string name{};   ///< "oscillator/order/leapfrog"
  std::string suite{};  ///< accuracy, stability, haptics, clinical, timing, model
  std::string claim{};  ///< the sentence that is judged
  Status status = Status::pass;
  std::vector<std::string> reasons{};  ///< why it is not a pass, worst first; explains a pass
  double seconds = 0.0;
  std::vector<Quantity> quantities{};
  std::deque<Table> tables{};
  std::deque<Figure> figures{};
  std::vector<Timing> timings{};
  std::vector<std::string> notes{};

  /// Adds a table without rows. References to tables stay valid when further ones are added.
  Table& table(std::string id, std::string title, std::string caption,
               std::vector<std::string> columns);
  /// Adds a figure without curves. References to figures stay valid as well.
  Figure& plot(std::string id, std::string title, std::string caption, Axis x, Axis y);
  void judge(Quantity quantity) { quantities.push_back(std::move(quantity)); }
  // Judge a value; `from` says where the bound comes from.
  void judge_at_least(std::string what, Number value, double lower, std::string from,
                      std::string unit = "1");
  void judge_at_most(std::string what, Number value, double upper, std::string from,
                     std::string unit = "1");
  void judge_between(std::string what, Number value, double lower, double upper, std::string from,
                     std::string unit = "1");
  void judge_near(std::string what, Number value, double expected, double tolerance,
                  std::string from, std::string unit = "1");
  void judge_equal(std::string what, Number value, Number expected, std::string from,
                   std::string unit = "1");
  /// Judges a condition as a quantity of 1 (true) or 0.
  void judge_true(std::string what, bool holds, std::string from);
  /// Adds a value that is not judged.
  void report(std::string what, Number value, std::string unit = "1");
  void skip(std::string why) {
    status = Status::skip;
    reasons = {std::move(why)};
  }
  /// All reasons, one a line.
  [[nodiscard]] std::string reason() const;
};

/// Sets the status from the quantities: fail if one fails or none is judged, else inconclusive if
/// one is inconclusive, else pass. Leaves skip and error as they are.
void conclude(Outcome& outcome);

/// The status of one part of a claim and its explanation.
struct Reason {
  Status status = Status::skip;
  std::string text{};  ///< empty: no explanation is needed
};

/// Sets the status to the worst of the parts (skip without any), and the reasons to theirs,
/// worst first; parts of one status keep their order.
void conclude(Outcome& outcome, std::vector<Reason> parts);

/// Number of outcomes of each status.
struct Tally {
  int passed = 0;
  int failed = 0;
  int inconclusive = 0;
  int errors = 0;
  int skipped = 0;

  void add(Status status);
  [[nodiscard]] int all() const { return ran() + skipped; }
  [[nodiscard]] int ran() const { return passed + not_passed(); }
  [[nodiscard]] int not_passed() const { return failed + inconclusive + errors; }
  /// Every outcome that is not skipped passes, and there is at least one.
  [[nodiscard]] bool holds() const { return not_passed() == 0 && passed > 0; }
};
Tally tally(const std::vector<Outcome>& outcomes);

}  // namespace palpate

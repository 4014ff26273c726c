// SPDX-License-Identifier: MIT
#pragma once
/// What a case of the harness finds: numbers with bounds, tables and figures, all plain data.
/// results.json and the trace files are written from it, and report.html from those.

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace palpate {

enum class Status { pass, fail, skip, error };
std::string_view name_of(Status status);

inline constexpr double unbounded = std::numeric_limits<double>::infinity();

/// A measured number and the interval it must lie in; NaN lies in none.
struct Quantity {
  std::string name{};
  double value = 0.0;
  std::string unit = "1";
  double lower = -unbounded;
  double upper = unbounded;
  std::string bound_from{};  ///< theory, a reference's own error, a publication; empty: not judged

  [[nodiscard]] bool judged() const {
    return lower > -unbounded || upper < unbounded || !bound_from.empty();
  }
  [[nodiscard]] bool holds() const { return value >= lower && value <= upper; }
};

struct Series {
  /// band: faint, for what is allowed or uncertain; area: strong, for parts stacked on each other
  enum class Style { line, points, line_and_points, dashed, band, area };
  std::string label{};
  Style style = Style::line;
  std::vector<double> x{};
  std::vector<double> y{};   ///< band and area: the lower edge
  std::vector<double> y2{};  ///< band and area: the upper edge

  [[nodiscard]] bool filled() const { return style == Style::band || style == Style::area; }
};

struct Axis {
  std::string label{};  ///< with unit, "time (s)"
  bool logarithmic = false;
  std::optional<double> minimum{};
  std::optional<double> maximum{};
};

/// Values on a regular grid, drawn as colours; z is row-major, z[row * columns + column].
struct HeatMap {
  std::string label{};
  std::vector<double> x{};
  std::vector<double> y{};
  std::vector<double> z{};
};

/// A stretch of the x axis with a name, drawn as a tint behind the curves.
struct Zone {
  std::string label{};
  double begin = 0.0;
  double end = 0.0;
};

/// A vertical line where something happened; marks of one label share a sign in the legend.
struct Mark {
  std::string label{};
  double x = 0.0;
};

struct Figure {
  std::string id{};  ///< unique within its case, [a-z0-9-]
  std::string title{};
  std::string caption{};  ///< one sentence: what it shows
  Axis x{};
  Axis y{};
  std::vector<Series> series{};
  std::optional<HeatMap> heat_map{};
  std::vector<Zone> zones{};  ///< neighbours in alternating tints
  std::vector<Mark> marks{};
  bool square = false;  ///< equal scales on both axes
  bool timing = false;  ///< shows run times, so differs from run to run
};

using Cell = std::variant<std::string, double>;

struct Table {
  std::string id{};
  std::string title{};
  std::string caption{};
  std::vector<std::string> columns{};  ///< with units
  std::vector<std::vector<Cell>> rows{};
  bool timing = false;
};

/// A measured run time or cost; never judged here, and left out when two runs are compared.
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
  std::string reason{};  ///< of a skip or an error
  double seconds = 0.0;
  std::vector<Quantity> quantities{};
  std::vector<Table> tables{};
  std::vector<Figure> figures{};
  std::vector<Timing> timings{};
  std::vector<std::string> notes{};

  void judge(Quantity quantity) { quantities.push_back(std::move(quantity)); }
  void skip(std::string why) {
    status = Status::skip;
    reason = std::move(why);
  }
};

/// Status from the quantities: fail when one does not hold or when nothing was judged at all.
void conclude(Outcome& outcome);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/gnuplot_zones.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "reports/figure_look.hpp"
#include "reports/gnuplot_text.hpp"
#include "reports/markup.hpp"
#include "reports/zone_labels.hpp"

namespace palpate {

namespace {

constexpr double left = 66.0;  // margins [px]
constexpr double right = 14.0;
constexpr double bottom = 56.0;
constexpr double plot_width = picture_width - left - right;
constexpr double sign_row = 9.0;  // signs of marks stand in rows above the plot
constexpr int most_sign_rows = 3;
constexpr double tallest_label = 104.0;
constexpr double label_pad = 4.0;  // above a label, and between it and the curves

/// Pixels from the left edge of the plot.
double across(const Figure& figure, const Range& x, double value) {
  return plot_width * axis_share(figure.x, x, value);
}

struct Placed {
  std::vector<ZoneSpan> spans;
  std::vector<ZoneLabel> labels;
};

Placed place(const Figure& figure, const Range& x) {
  Placed placed;
  for (const Zone& zone : figure.zones) {
    double begin = across(figure, x, zone.begin);
    double end = across(figure, x, zone.end);
    if (begin > end) { std::swap(begin, end); }
    begin = std::max(begin, 0.0);
    end = std::min(end, plot_width);
    // Every zone keeps its place in the list, so that tints alternate; NaN is no zone.
    placed.spans.push_back(end > begin ? ZoneSpan{zone.label, begin, end} : ZoneSpan{});
  }
  placed.labels = place_zone_labels(placed.spans, plot_width, tallest_label);
  return placed;
}

struct Sign {
  double x;  ///< [px] across the plot
  int row;
  Shape shape;
};

std::vector<Sign> signs_of(const Figure& figure, const Range& x) {
  const std::vector<std::string> labels = mark_labels(figure);
  std::vector<Sign> signs;
  std::vector<Mark> marks = figure.marks;
  std::ranges::stable_sort(marks, {}, &Mark::x);
  std::array<double, most_sign_rows> taken{};
  taken.fill(-unbounded);
  for (const Mark& mark : marks) {
    const double at = across(figure, x, mark.x);
    if (!(at >= -0.5 && at <= plot_width + 0.5)) { continue; }
    const auto* free =
        std::ranges::find_if(taken, [&](double last) { return at - last >= sign_row; });
    const auto* row = free == taken.end() ? taken.begin() : free;
    taken.at(static_cast<std::size_t>(row - taken.begin())) = at;
    const auto place = std::ranges::find(labels, mark.label) - labels.begin();
    signs.push_back({at, static_cast<int>(row - taken.begin()),
                     shape_of_mark(static_cast<std::size_t>(place))});
  }
  return signs;
}

std::string at(double x, double y) {
  return "graph " + plain_number(x / plot_width, 7) + ", screen " + plain_number(y, 7);
}

/// Position of a pixel counted from the top of the plot.
struct Frame {
  double top;
  double tall;

  [[nodiscard]] double screen(double down) const { return 1.0 - (top + down) / tall; }
};

std::string tints(const Placed& placed) {
  std::string text;
  for (std::size_t n = 0; n < placed.spans.size(); ++n) {
    const ZoneSpan& span = placed.spans[n];
    if (!(span.end > span.begin)) { continue; }
    text += "set object rectangle from graph " + plain_number(span.begin / plot_width, 7) +
            ", graph 0 to graph " + plain_number(span.end / plot_width, 7) +
            ", graph 1 behind fs solid 1.0 noborder" +
            colour(n % 2 == 0 ? StandIn::zone_a : StandIn::zone_b, "fc") + "\n";
  }
  return text;
}

std::string written(const ZoneLabel& label, const Frame& frame) {
  std::string text;
  for (std::size_t n = 0; n < label.lines.size(); ++n) {
    const double line = zone_line * (0.5 + static_cast<double>(n));  // its middle
    const double x = label.upright ? label.middle - 0.5 * label.width + line : label.middle;
    const double down = label_pad + (label.upright ? 0.5 * label.height : line);
    text += "set label " + quoted(label.lines[n]) + " at " + at(x, frame.screen(down)) +
            (label.upright ? " center rotate by 90" : " center") + " noenhanced front font \"," +
            plain_number(zone_font) + "\"" + colour(StandIn::note, "tc") + "\n";
  }
  return text;
}

std::string drawn(const std::vector<Sign>& signs, const Frame& frame) {
  std::string text;
  for (const Sign& sign : signs) {
    const double up = -0.5 * sign_row - sign_row * sign.row;
    const std::string x = plain_number(sign.x / plot_width, 7);
    text += "set arrow from graph " + x + ", graph 0 to " + at(sign.x, frame.screen(up)) +
            " nohead back lw 0.9 dt (5,5)" + colour(StandIn::note, "lc") + "\n";
    text += "set label '' at " + at(sign.x, frame.screen(up)) + " point pt " +
            std::to_string(point_type(sign.shape)) + " ps 0.55" + colour(StandIn::note, "lc") +
            " front\n";
  }
  return text;
}

double top_margin(const std::vector<Sign>& signs) {
  int rows = 0;
  for (const Sign& sign : signs) { rows = std::max(rows, sign.row + 1); }
  return 6.0 + sign_row * rows;
}

/// Highest point of what is drawn between two places [px]; nothing there: -infinity.
double highest(const Figure& figure, const Range& x, double from, double to) {
  double most = -unbounded;
  for (const Series& series : figure.series) {
    for (std::size_t n = 0; n < std::min(series.x.size(), series.y.size()); ++n) {
      const double place = across(figure, x, series.x[n]);
      if (!(place >= from && place <= to)) { continue; }
      if (std::isfinite(series.y[n])) { most = std::max(most, series.y[n]); }
      if (n < series.y2.size() && std::isfinite(series.y2[n])) {
        most = std::max(most, series.y2[n]);
      }
    }
  }
  return most;
}

}  // namespace

bool is_annotated(const Figure& figure) { return !figure.zones.empty() || !figure.marks.empty(); }

int annotated_height(const Figure& figure) { return figure.zones.empty() ? 310 : 350; }

std::vector<std::string> mark_labels(const Figure& figure) {
  std::vector<std::string> labels;
  for (const Mark& mark : figure.marks) {
    if (std::ranges::find(labels, mark.label) == labels.end()) { labels.push_back(mark.label); }
  }
  return labels;
}

Range range_below_labels(const Figure& figure, const Range& x, const Range& y) {
  if (figure.y.logarithmic || figure.y.maximum || figure.square || y.empty) { return y; }
  Range range = y;
  if (range.high == range.low) { range.high += range.high == 0.0 ? 1.0 : std::abs(range.high); }
  const double span = range.high - range.low;
  if (!figure.y.minimum && range.low < 0.0) { range.low -= 0.04 * span; }
  range.high += 0.05 * span;
  const double tall = annotated_height(figure) - bottom - top_margin(signs_of(figure, x));
  const double most = range.low + (range.high - range.low) / 0.55;  // curves keep their half
  double high = range.high;
  for (const ZoneLabel& label : place(figure, x).labels) {
    const double reach = 0.5 * label.width + 2.0;
    const double below = highest(figure, x, label.middle - reach, label.middle + reach);
    const double share = (label.height + 3.0 * label_pad) / tall;
    if (below > range.low) {
      high = std::max(high, range.low + (below - range.low) / (1.0 - share));
    }
  }
  range.high = std::min(high, std::max(most, range.high));
  return range;
}

std::string annotation_commands(const Figure& figure, const Range& x) {
  const std::vector<Sign> signs = signs_of(figure, x);
  const double tall = annotated_height(figure);
  const Frame frame{top_margin(signs), tall};
  const auto screen = [](double share) {
    return "margin at screen " + plain_number(share, 7) + "\n";
  };
  std::string text = "set l" + screen(left / picture_width) + "set r" +
                     screen(1.0 - right / picture_width) + "set b" + screen(bottom / tall) +
                     "set t" + screen(frame.screen(0.0));
  const Placed placed = place(figure, x);
  text += tints(placed) + drawn(signs, frame);
  for (const ZoneLabel& label : placed.labels) { text += written(label, frame); }
  return text;
}

}  // namespace palpate

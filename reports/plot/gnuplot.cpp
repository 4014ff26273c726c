// SPDX-License-Identifier: MIT

#include "reports/plot/gnuplot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "reports/html/html_page.hpp"
#include "reports/plot/axis_range.hpp"
#include "reports/plot/figure_look.hpp"
#include "reports/plot/thinning.hpp"
#include "reports/plot/zone_labels.hpp"

namespace palpate {

std::string colour(int stand_in, const char* what) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), " %s rgb \"#%02x%02x%02x\"", what, StandIn::red,
                StandIn::green, stand_in);
  return buffer.data();
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (std::string_view("\"'\\`@").find(c) == std::string_view::npos) {
      out += c == '\n' ? ' ' : c;
      continue;
    }
    std::array<char, 8> code{};
    std::snprintf(code.data(), code.size(), "\\%03o", static_cast<unsigned>(c));
    out += code.data();
  }
  return out + "\"";
}

int point_type(Shape shape) {
  constexpr std::array<int, shape_count> types{7, 5, 9, 13, 6, 4};
  return types.at(static_cast<std::size_t>(shape));
}

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

namespace {

constexpr double plot_height = 240.0;
constexpr std::size_t most_markers = 60;

std::string lc(int stand_in) { return colour(stand_in); }

std::string lc(const Look& look) {
  return lc(look.colour == ink_colour ? StandIn::ink : StandIn::first_series + look.colour);
}

void add_row(std::string& block, std::initializer_list<double> values) {
  for (const double value : values) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.7g ", value);
    block += buffer.data();
  }
  block += '\n';
}

Projection projection(const Figure& figure) {
  return [&figure, x = x_range(figure), y = y_range(figure)](double a, double b) {
    return Pixel{plot_width * axis_share(figure.x, x, a), plot_height * axis_share(figure.y, y, b)};
  };
}

std::string data_block(const Figure& figure, std::size_t index) {
  const Series& series = figure.series[index];
  const Projection project = projection(figure);
  std::string block = "$s" + std::to_string(index) + " << EOD\n";
  for (const std::size_t n : thinned(series, project)) {
    const Pixel at = project(series.x[n], series.y[n]);
    if (!std::isfinite(at.x) || !std::isfinite(at.y)) {
      block += "\n";  // a gap in the line
    } else if (series.filled()) {
      add_row(block, {series.x[n], series.y[n], series.y2[n]});
    } else {
      add_row(block, {series.x[n], series.y[n]});
    }
  }
  return block + "EOD\n";
}

/// `halo` widens the drawing so that it shows as a rim behind the series.
std::string style_of(const Look& look, std::size_t samples, const std::string& colour, bool halo) {
  if (look.opacity > 0.0) {
    return " with filledcurves fs transparent solid " + plain_number(look.opacity) + " noborder" +
           colour;
  }
  const std::string lines = halo ? " lw 4.2" : " lw 1.7";
  const std::string points =
      std::string(halo ? " ps 0.85" : " ps 0.55") + " pt " + std::to_string(point_type(look.shape));
  const std::string dash = look.dash == 0 ? "" : look.dash == 1 ? " dt (10,6)" : " dt (10,5,2,5)";
  // Markers on a line tell series apart; too many would hide what lies beneath.
  const std::string every = " pointinterval " + std::to_string(samples / most_markers + 1);
  if (look.line && look.points) {
    return " with linespoints" + lines + points + every + dash + colour;
  }
  return look.line ? " with lines" + lines + dash + colour : " with points" + points + colour;
}

/// `fixed`: the axis ends with its range, not at the next tick.
std::string axis_commands(const char* name, const Axis& axis, const Range& range, bool fixed) {
  const std::string n(name);
  std::string text = "set " + n + "label " + quoted(without_unit_one(axis.label)) + " noenhanced\n";
  if (range.empty) { return text; }
  if (fixed && range.low != range.high) {
    text +=
        "set " + n + "range [" + exact_number(range.low) + ":" + exact_number(range.high) + "]\n";
  }
  if (!axis.logarithmic) { return text; }
  text += "set logscale " + n + "\nset " + n + "tics (";
  for (const Tick& tick : logarithmic_ticks(range)) {
    text += (text.back() == '(' ? "" : ", ") + ("\"" + tick.label) + "\" " +
            exact_number(tick.value) + (tick.label.empty() ? " 1" : " 0");
  }
  return text + ")\n";
}

std::string heat_map_block(const HeatMap& map) {
  std::string block = "$heat << EOD\n";
  for (std::size_t row = 0; row < map.y.size(); ++row) {
    for (std::size_t column = 0; column < map.x.size(); ++column) {
      const double z = map.z.at(row * map.x.size() + column);
      block += exact_number(map.x[column]) + " " + exact_number(map.y[row]) + " " +
               (std::isfinite(z) ? exact_number(z) : "NaN") + "\n";
    }
    block += "\n";
  }
  return block + "EOD\n";
}

/// From blue over pale to orange about zero when the values have both signs, else viridis.
std::string palette(const HeatMap& map) {
  double least = unbounded;
  double most = -unbounded;
  for (const double z : map.z) {
    if (std::isfinite(z)) { least = std::min(least, z), most = std::max(most, z); }
  }
  std::string text = "set palette maxcolors 64 ";
  if (!(least < 0.0 && most > 0.0)) {
    text +=
        "defined (0 '#440154', 1 '#414487', 2 '#2a788e', 3 '#22a884', 4 '#7ad151', 5 '#fde725')\n";
    const bool flat = least == most;
    return text + (flat ? "set cbrange [" + exact_number(least - 0.5) + ":" +
                              exact_number(most + 0.5) + "]\n"
                        : "");
  }
  const std::string reach = exact_number(std::max(-least, most));
  return text +
         "defined (0 '#17406d', 1 '#3f7fb8', 2 '#a9cbe3', 3 '#f4f1ea', 4 '#f3bd8f', 5 "
         "'#d9722e', 6 '#7f2d0c')\nset cbrange [-" +
         reach + ":" + reach + "]\n";
}

std::string heat_map_commands(const Figure& figure, const Range& x, const Range& y) {
  const auto span = [](const char* axis, const Range& range) {
    return std::string("set ") + axis + "range [" + exact_number(range.low) + ":" +
           exact_number(range.high) + "]\n";
  };
  return heat_map_block(*figure.heat_map) + "set cblabel " +
         quoted(without_unit_one(figure.heat_map->label)) + " noenhanced\n" +
         palette(*figure.heat_map) + span("x", x) + span("y", y) +
         "unset grid\nset border 15 front\nset tics front\nset colorbox noborder\n";
}

bool has_limits(const Axis& axis) { return axis.logarithmic || axis.minimum || axis.maximum; }

int height(const Figure& figure, const Range& x, const Range& y) {
  if (is_annotated(figure)) { return annotated_height(figure); }
  if (!figure.square || x.empty || y.empty || x.high == x.low) { return 300; }
  const double ratio = std::abs((y.high - y.low) / (x.high - x.low));
  return static_cast<int>(std::clamp(60.0 + plot_width * ratio, 220.0, 480.0));
}

std::string layout_commands(const Figure& figure, int tall) {
  std::string text = "reset\nset encoding utf8\nset minussign\nset terminal svg size " +
                     std::to_string(picture_width) + "," + std::to_string(tall) +
                     " dynamic enhanced font \"sans-serif,13.5\"\n";
  text += "set border 3 lw 1" + lc(StandIn::ink) + "\nset tics nomirror out scale 0.5,0.25\n" +
          "set grid lt 1 lw 1" + lc(StandIn::grid) + "\nunset key\n" +
          "set xtics offset 0,0.25\nset ytics offset 0.4,0\nset xlabel offset 0,0.5\n" +
          "set ylabel offset 0.6,0\nset format \"%g\"\n";
  text += figure.heat_map ? "set cbtics offset -0.6,0\nset cblabel offset 1.2,0\n"
                          : "set rmargin 2.5\n";
  // Curves fill the width; points alone keep off the edges.
  const bool curves = std::ranges::any_of(
      figure.series, [](const Series& each) { return each.style != Series::Style::points; });
  if (curves && !figure.square) { text += "set autoscale xfix\n"; }
  if (figure.square) { text += "set size ratio -1\n"; }
  return text;
}

}  // namespace

std::string gnuplot_script(const Figure& in_si, const std::string& output) {
  const Figure figure = in_field_units(in_si);
  const Range x = x_range(figure);
  // Labels and signs need to know where a value lies, so the axes end with their ranges.
  const bool annotated = is_annotated(figure) && !figure.heat_map && !x.empty && x.high > x.low;
  const Range y = annotated ? range_below_labels(figure, x, y_range(figure)) : y_range(figure);
  const std::vector<Look> looks = looks_of(figure);
  std::string text = layout_commands(figure, height(figure, x, y));
  text += "set output " + quoted(output) + "\n";
  text += axis_commands("x", figure.x, x, annotated || has_limits(figure.x)) +
          axis_commands("y", figure.y, y, annotated || has_limits(figure.y));
  if (annotated) { text += annotation_commands(figure, x); }
  std::string plots;
  const auto add = [&plots](const std::string& plot) {
    plots += (plots.empty() ? "" : ", ") + plot;
  };
  if (figure.heat_map && x.high > x.low && y.high > y.low) {
    text += heat_map_commands(figure, x, y);
    add("$heat using 1:2:3 with image");
  }
  for (const bool bands : {true, false}) {  // what is filled lies behind the rest
    for (std::size_t n = 0; n < figure.series.size(); ++n) {
      if ((looks[n].opacity > 0.0) != bands || x.empty || y.empty) { continue; }
      const std::string block = data_block(figure, n);
      const auto samples = static_cast<std::size_t>(std::ranges::count(block, '\n'));
      if (block.find_first_of("0123456789", block.find('\n')) == std::string::npos) { continue; }
      text += block;
      const std::string source = "$s" + std::to_string(n) + (bands ? " using 1:2:3" : " using 1:2");
      if (figure.heat_map && !bands) {
        add(source + style_of(looks[n], samples, lc(StandIn::paper), true));
      }
      add(source + style_of(looks[n], samples, lc(looks[n]), false));
    }
  }
  // An empty frame is better than no picture: it shows that there was nothing to draw.
  if (plots.empty()) {
    text += "unset logscale\nset tics autofreq\n";
    add("[0:1] [0:1] -1");
  }
  return text + "plot " + plots + "\nunset output\n";
}

}  // namespace palpate

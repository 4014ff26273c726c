// SPDX-License-Identifier: MIT
#include "reports/gnuplot_script.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "reports/axis_range.hpp"
#include "reports/field_units.hpp"
#include "reports/figure_look.hpp"
#include "reports/gnuplot_text.hpp"
#include "reports/gnuplot_zones.hpp"
#include "reports/markup.hpp"
#include "reports/thinning.hpp"

namespace palpate {

namespace {

constexpr double plot_width = 400.0;  // less margins; thinning needs no more than about right
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

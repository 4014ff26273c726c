// SPDX-License-Identifier: MIT
#include "reports/gnuplot_script.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "reports/markup.hpp"

namespace palpate {

namespace {

constexpr std::size_t picture_columns = 320;

std::string colour(int red, int green, int blue) {
  std::array<char, 16> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "\"#%02x%02x%02x\"", red, green, blue);
  return buffer.data();
}

/// Single-quoted; gnuplot doubles a quote inside.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) { out += c == '\'' ? "''" : std::string(1, c); }
  return out + "'";
}

bool drawable(const Figure& figure, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!figure.x.logarithmic || x > 0.0) &&
         (!figure.y.logarithmic || y > 0.0);
}

void add_row(std::string& block, std::initializer_list<double> values) {
  for (const double value : values) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.7g ", value);
    block += buffer.data();
  }
  block += '\n';
}

/// Indices to draw: all of a short series, the first, least, greatest and last of each stretch of a
/// long one.
std::vector<std::size_t> thinned(const std::vector<double>& y) {
  std::vector<std::size_t> kept;
  const std::size_t stretch = std::max<std::size_t>(1, y.size() / picture_columns);
  if (stretch < 4) {
    for (std::size_t n = 0; n < y.size(); ++n) { kept.push_back(n); }
    return kept;
  }
  for (std::size_t begin = 0; begin < y.size(); begin += stretch) {
    const std::size_t end = std::min(begin + stretch, y.size());
    const auto [low, high] = std::minmax_element(y.begin() + static_cast<long>(begin),
                                                 y.begin() + static_cast<long>(end));
    std::array<std::size_t, 4> picks{begin, static_cast<std::size_t>(low - y.begin()),
                                     static_cast<std::size_t>(high - y.begin()), end - 1};
    std::ranges::sort(picks);
    for (const std::size_t n : picks) {
      if (kept.empty() || kept.back() != n) { kept.push_back(n); }
    }
  }
  return kept;
}

std::string data_block(const Figure& figure, const Series& series, std::size_t index) {
  std::string block = "$s" + std::to_string(index) + " << EOD\n";
  const bool band = series.style == Series::Style::band;
  for (const std::size_t n : thinned(series.y)) {
    if (n >= series.x.size() || (band && n >= series.y2.size())) { break; }
    if (!drawable(figure, series.x[n], series.y[n])) {
      block += "\n";  // a gap in the line
      continue;
    }
    if (band) {
      add_row(block, {series.x[n], series.y[n], series.y2[n]});
    } else {
      add_row(block, {series.x[n], series.y[n]});
    }
  }
  return block + "EOD\n";
}

std::string style_of(const Series& series, std::size_t index) {
  const std::string lc = " lc rgb " + StandIn::series(index);
  const std::string dash = index >= series_colours ? " dt 4" : "";
  const std::string point = " pt " + std::to_string(std::array{7, 5, 9, 13, 6, 4, 8, 12}[index % 8]);
  switch (series.style) {
    case Series::Style::points: return "with points ps 0.55" + point + lc;
    case Series::Style::line_and_points: return "with linespoints lw 1.8 ps 0.5" + point + dash + lc;
    case Series::Style::dashed: return "with lines lw 1.8 dt 2" + lc;
    case Series::Style::band: return "with filledcurves fs transparent solid 0.22 noborder" + lc;
    case Series::Style::line: break;
  }
  return "with lines lw 1.8" + dash + lc;
}

std::string axis_commands(const char* name, const Axis& axis) {
  const std::string n(name);
  std::string text = "set " + n + "label " + quoted(axis.label) + " noenhanced\n";
  if (axis.logarithmic) {
    text += "set logscale " + n + "\nset format " + n + " \"10^{%L}\"\n";
  } else {
    text += "set format " + n + " \"%g\"\n";
  }
  if (axis.minimum || axis.maximum) {
    text += "set " + n + "range [" + (axis.minimum ? exact_number(*axis.minimum) : "*") + ":" +
            (axis.maximum ? exact_number(*axis.maximum) : "*") + "]\n";
  }
  return text;
}

std::string heat_map_block(const HeatMap& map) {
  std::string block = "$heat << EOD\n";
  for (std::size_t row = 0; row < map.y.size(); ++row) {
    for (std::size_t column = 0; column < map.x.size(); ++column) {
      const double z = map.z[row * map.x.size() + column];
      block += exact_number(map.x[column]) + " " + exact_number(map.y[row]) + " " +
               (std::isfinite(z) ? exact_number(z) : "NaN") + "\n";
    }
    block += "\n";
  }
  return block + "EOD\n";
}

std::string layout_commands(const Figure& figure) {
  const auto labelled = static_cast<int>(std::ranges::count_if(
      figure.series, [](const Series& series) { return !series.label.empty(); }));
  // The key stands above the plot, in as many columns as fit a phone's width of text.
  std::size_t longest = 1;
  for (const Series& series : figure.series) { longest = std::max(longest, series.label.size()); }
  const int columns = std::clamp(static_cast<int>(66 / (longest + 7)), 1, 4);
  const int rows = (labelled + columns - 1) / columns;
  const int plot_height = figure.square ? 560 : 360;
  const int height = plot_height + 20 * std::max(rows, 0) + 14;
  std::string text = "reset\nset encoding utf8\nset terminal svg size 640," + std::to_string(height) +
                     " dynamic enhanced font \"sans-serif,15\" name \"plot\"\n";
  text += "set border 3 lw 0.8 lc rgb " + StandIn::ink() + "\nset tics nomirror out scale 0.6\n";
  text += "set grid lt 1 lw 0.6 lc rgb " + StandIn::grid() + "\n";
  text += labelled == 0 ? std::string("unset key\n")
                        : "set key noenhanced above left Left reverse samplen 2 spacing 1.1 maxcols " +
                              std::to_string(columns) + " maxrows " + std::to_string(rows) + "\n";
  if (figure.square) { text += "set size ratio -1\n"; }
  return text;
}

}  // namespace

std::string StandIn::ink() { return colour(1, 2, 1); }
std::string StandIn::grid() { return colour(1, 2, 2); }
std::string StandIn::series(std::size_t index) {
  return colour(1, 2, 16 + static_cast<int>(index % series_colours));
}

std::string gnuplot_script(const Figure& figure, const std::string& output) {
  std::string text = layout_commands(figure);
  text += "set output " + quoted(output) + "\n";
  text += axis_commands("x", figure.x) + axis_commands("y", figure.y);
  std::string plots;
  if (figure.heat_map) {
    text += heat_map_block(*figure.heat_map);
    text += "set cblabel " + quoted(figure.heat_map->label) + " noenhanced" +
            "\nset palette defined (0 '#440154', 1 '#414487', 2 '#2a788e', 3 '#22a884', 4 "
            "'#7ad151', 5 '#fde725')\nset autoscale fix\nset colorbox noborder\n";
    plots = "$heat using 1:2:3 with image notitle";
  }
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    const Series& series = figure.series[n];
    const bool anything = std::ranges::any_of(series.y, [](double y) { return std::isfinite(y); });
    if (!anything) { continue; }
    text += data_block(figure, series, n);
    plots += (plots.empty() ? "" : ", ") + std::string("$s") + std::to_string(n) + " " +
             (series.style == Series::Style::band ? "using 1:2:3 " : "using 1:2 ") +
             style_of(series, n) + " title " + quoted(series.label);
  }
  // An empty frame is better than no picture: it shows that there was nothing to draw.
  if (plots.empty()) {
    text += "unset logscale\n";
    plots = "[0:1] [0:1] -1 notitle";
  }
  return text + "plot " + plots + "\nunset output\n";
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/figure_svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include <sys/wait.h>

#include "fixtures/io/file_bytes.hpp"
#include "reports/gnuplot_script.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

/// A folder that is gone with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "palpate-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw DrawingError("no temporary folder for figures in " + pattern);
    }
    path_ = pattern;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void run_gnuplot(const std::filesystem::path& script) {
  const std::string command =
      "gnuplot '" + script.string() + "' 2>'" + script.string() + ".log' </dev/null";
  const int status = std::system(command.c_str());
  if (status == 0) { return; }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    throw DrawingError("gnuplot is not installed; scripts/setup installs it");
  }
  std::ifstream log(script.string() + ".log");
  std::stringstream text;
  text << log.rdbuf();
  throw DrawingError("gnuplot failed: " + text.str().substr(0, 500));
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// "rgb(  1,   2,  16)" and "rgb(1,2,16)" become "var(--series-0)".
void follow_theme(std::string& svg) {
  const auto exchange = [&svg](int blue, const std::string& variable) {
    std::array<char, 32> wide{};
    std::snprintf(wide.data(), wide.size(), "rgb(  1,   2, %3d)", blue);
    replace_all(svg, wide.data(), variable);
    std::snprintf(wide.data(), wide.size(), "rgb(1,2,%d)", blue);
    replace_all(svg, wide.data(), variable);
  };
  exchange(1, "var(--ink)");
  exchange(2, "var(--grid)");
  for (int n = 0; n < series_colours; ++n) {
    exchange(16 + n, "var(--series-" + std::to_string(n) + ")");
  }
  replace_all(svg, "color=\"black\"", "color=\"var(--ink)\"");
  replace_all(svg, "color=\"gray\"", "color=\"var(--grid)\"");
  replace_all(svg, "fill=\"black\"", "fill=\"var(--ink)\"");
}

void cut(std::string& text, std::string_view begin, std::string_view end) {
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) { return; }
  const std::size_t to = text.find(end, from);
  if (to != std::string::npos) { text.erase(from, to + end.size() - from); }
}

/// Groups that hold nothing, which are most of what gnuplot writes.
void drop_empty_groups(std::string& svg) {
  static const std::regex empty("<g [^>]*>\\s*</g>\\s*");
  std::string before;
  while (before.size() != svg.size()) {
    before = svg;
    svg = std::regex_replace(svg, empty, "");
  }
}

/// Inside tags: one decimal is a tenth of a pixel, and runs of space say nothing. Text between tags
/// stays as it is.
std::string compact(const std::string& svg) {
  std::string out;
  bool in_tag = false;
  int decimals = -1;  // digits since the point of a number; -1: before any point
  for (const char c : svg) {
    if (c == '<') { in_tag = true; }
    if (c == '>') { in_tag = false; }
    const bool digit = c >= '0' && c <= '9';
    decimals = c == '.' ? 0 : digit && decimals >= 0 ? decimals + 1 : digit ? decimals : -1;
    const bool space = c == ' ' || c == '\t' || c == '\n';
    if (in_tag && digit && decimals > 1) { continue; }
    if (space && !out.empty() && (out.back() == ' ' || out.back() == '>')) { continue; }
    out += space && in_tag ? ' ' : c;
  }
  return out;
}

/// One of gnuplot's markers: which shape, how large, what colour, and where.
struct Marker {
  int shape = 0;
  double scale = 0.0;
  std::string colour;
  std::string at;  ///< "x,y"
};

/// Path of a marker around the current point, filled by its own outline's colour.
std::string marker_path(const Marker& marker) {
  const auto number = [&](double factor) { return short_number(std::round(10.0 * factor * marker.scale) / 10.0); };
  const std::string r = number(0.9);
  const std::string d = number(1.8);
  switch (marker.shape) {
    case 3:
    case 4: return "m-" + r + ",-" + r + "h" + d + "v" + d + "h-" + d + "z";
    case 7:
    case 8: return "m0,-" + number(1.3) + "l-" + number(1.3) + "," + d + "h" + number(2.6) + "z";
    case 11:
    case 12: return "m0,-" + number(1.4) + "l" + number(1.4) + "," + number(1.4) + "l-" + number(1.4) + "," + number(1.4) + "l-" + number(1.4) + ",-" + number(1.4) + "z";
    default: return "m-" + number(1.0) + ",0a" + number(1.0) + "," + number(1.0) + " 0 1 0 " + number(2.0) + ",0a" + number(1.0) + "," + number(1.0) + " 0 1 0 -" + number(2.0) + ",0z";
  }
}

/// Open shapes are outlines, the others are filled.
bool is_open(int shape) { return shape == 3 || shape == 5 || shape == 7 || shape == 11; }

/// Runs of equal markers become one path each: a point costs its place and its outline, not an
/// element.
std::string merge_markers(const std::string& svg) {
  static const std::regex marker(
      "<use href='#gpPt([0-9]+)' transform='translate\\(([-0-9.,]+)\\) scale\\(([0-9.]+)\\)' color='([^']*)'/>");
  std::string out;
  Marker open;
  std::string path;
  const auto close = [&] {
    if (path.empty()) { return; }
    const bool outline = is_open(open.shape);
    out += "<path d='" + path + "' fill='" + (outline ? "none" : open.colour) + "' stroke='" +
           (outline ? open.colour : "none") + "'/>";
    path.clear();
  };
  std::size_t done = 0;
  for (std::sregex_iterator each(svg.begin(), svg.end(), marker), end; each != end; ++each) {
    const auto begin = static_cast<std::size_t>(each->position());
    const Marker found{std::stoi((*each)[1]), std::stod((*each)[3]), (*each)[4], (*each)[2]};
    const bool continues = begin == done && found.shape == open.shape && found.scale == open.scale &&
                           found.colour == open.colour;
    if (!continues) {
      close();
      out += svg.substr(done, begin - done);
    }
    open = found;
    path += "M" + found.at + marker_path(found);
    done = begin + static_cast<std::size_t>(each->length());
  }
  close();
  return out + svg.substr(done);
}

std::string for_page(std::string svg, const Figure& figure) {
  cut(svg, "<?xml", "?>");
  cut(svg, "<title>", "</title>");
  cut(svg, "<desc>", "</desc>");
  cut(svg, "<defs>", "</defs>");
  cut(svg, "xmlns:xlink=\"", "\"");
  cut(svg, "xmlns=\"", "\"");
  replace_all(svg, "xlink:href", "href");
  replace_all(svg, "id=\"gnuplot_canvas\"", "");
  replace_all(svg, "id=\"plot_plot_", "data-plot=\"");
  replace_all(svg, "font-family=\"sans-serif\"", "");
  follow_theme(svg);
  drop_empty_groups(svg);
  for (const char* is_default : {" class=\"gridline\"", " stroke-linecap=\"butt\"", " stroke-linejoin=\"miter\""}) {
    replace_all(svg, is_default, "");
  }
  svg = merge_markers(compact(svg));
  const std::size_t begin = svg.find("<svg");
  const std::string label = escape_markup(figure.title + ". " + figure.caption);
  return "<svg role=\"img\" aria-label=\"" + label + "\"" + svg.substr(std::min(begin + 4, svg.size()));
}

}  // namespace

std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures) {
  if (figures.empty()) { return {}; }
  const ScratchFolder scratch;
  const auto picture = [&](std::size_t n) { return scratch.path() / (std::to_string(n) + ".svg"); };
  std::string script;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    script += gnuplot_script(*figures[n], picture(n).string());
  }
  const std::filesystem::path file = scratch.path() / "figures.gp";
  io::replace_file(file, script);
  run_gnuplot(file);
  std::vector<std::string> drawings;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    drawings.push_back(for_page(io::read_text(picture(n), 64U << 20U), *figures[n]));
  }
  return drawings;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/figure_svg.hpp"

#include <array>
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
  replace_all(svg, "<svg", "<svg role=\"img\" aria-label=\"" + escape_markup(figure.title + ". " + figure.caption) + "\"");
  follow_theme(svg);
  drop_empty_groups(svg);
  const std::size_t begin = svg.find("<svg");
  return begin == std::string::npos ? svg : svg.substr(begin);
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

std::string figure_definitions() {
  return "<svg width=\"0\" height=\"0\" aria-hidden=\"true\" style=\"position:absolute\"><defs>"
         "<circle id=\"gpDot\" r=\"0.5\" stroke-width=\"0.5\" stroke=\"currentColor\"/>"
         "<rect id=\"gpPt3\" fill=\"none\" stroke-width=\"0.25\" stroke=\"currentColor\" x=\"-1\" y=\"-1\" width=\"2\" height=\"2\"/>"
         "<rect id=\"gpPt4\" stroke-width=\"0.19\" stroke=\"currentColor\" fill=\"currentColor\" x=\"-1\" y=\"-1\" width=\"2\" height=\"2\"/>"
         "<circle id=\"gpPt5\" fill=\"none\" stroke-width=\"0.25\" stroke=\"currentColor\" r=\"1\"/>"
         "<circle id=\"gpPt6\" fill=\"currentColor\" stroke=\"none\" r=\"1\"/>"
         "<path id=\"gpPt7\" fill=\"none\" stroke-width=\"0.25\" stroke=\"currentColor\" d=\"M0,-1.33 L-1.33,0.67 L1.33,0.67 z\"/>"
         "<path id=\"gpPt8\" fill=\"currentColor\" stroke=\"none\" d=\"M0,-1.33 L-1.33,0.67 L1.33,0.67 z\"/>"
         "<path id=\"gpPt11\" fill=\"none\" stroke-width=\"0.25\" stroke=\"currentColor\" d=\"M0,-1.4 L1.4,0 L0,1.4 L-1.4,0 z\"/>"
         "<path id=\"gpPt12\" fill=\"currentColor\" stroke=\"none\" d=\"M0,-1.4 L1.4,0 L0,1.4 L-1.4,0 z\"/>"
         "</defs></svg>";
}

}  // namespace palpate

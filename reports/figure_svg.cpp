// SPDX-License-Identifier: MIT
#include "reports/figure_svg.hpp"

#include <algorithm>
#include <filesystem>
#include <sys/wait.h>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scratch_folder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/figure_look.hpp"
#include "reports/gnuplot_script.hpp"
#include "reports/gnuplot_svg.hpp"
#include "reports/gnuplot_zones.hpp"
#include "reports/markup.hpp"
#include "reports/svg_path.hpp"

namespace palpate {

namespace {

std::string file_text(const std::filesystem::path& path) {
  try {
    return io::read_text(path, 256U << 20U);
  } catch (const InputError& problem) {
    throw DrawingError(std::string("gnuplot drew nothing: ") + problem.what());
  }
}

/// Own and user's settings of gnuplot are left out, so that every machine draws the same.
void run_gnuplot(const std::filesystem::path& folder) {
  const std::string in = "'" + folder.string() + "/";
  const std::string command =
      "GNUTERM=svg LC_ALL=C.UTF-8 gnuplot -d " + in + "figures.gp' 2>" + in + "log' </dev/null";
  const int status = std::system(command.c_str());
  if (status == 0) { return; }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    throw DrawingError("gnuplot is not installed; scripts/setup installs it");
  }
  throw DrawingError("gnuplot failed: " + file_text(folder / "log").substr(0, 500));
}

/// A stroke of the series, its marker, or a filled box.
std::string sample(const Look& look) {
  const std::string colour = look.colour == ink_colour ? "k" : "s" + std::to_string(look.colour);
  std::string svg = "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">";
  if (look.opacity > 0.0) {
    svg += "<path class=\"f " + colour + "\" opacity=\"" + svg_number(look.opacity + 0.08) +
           "\" d=\"M1 1h26v10h-26z\"/>";
  }
  if (look.line) {
    const char* dashes[] = {"", " stroke-dasharray=\"6 3.5\"", " stroke-dasharray=\"7 3 1.5 3\""};
    svg += "<path class=\"l " + colour + "\" stroke-width=\"2\"" + dashes[look.dash] +
           " d=\"M1 6h26\"/>";
  }
  if (look.points) {
    constexpr double r = 3.0;
    SvgPath path;
    path.marker(look.shape, 14.0, 6.0, r);
    svg += "<path " + marker_attributes(look.shape, colour, r) + " d=\"" + path.data() + "\"/>";
  }
  return svg + "</svg>";
}

/// Line and sign of a kind of mark.
std::string sample(Shape shape) {
  constexpr double r = 3.0;
  SvgPath path;
  path.marker(shape, 14.0, 3.5, r);
  return "<svg class=\"sample\" viewBox=\"0 0 28 12\" aria-hidden=\"true\">"
         "<path class=\"l n\" stroke-width=\".9\" stroke-dasharray=\"1.5 1.5\" d=\"M14 6v6\"/>"
         "<path " + marker_attributes(shape, "n", r) + " d=\"" + path.data() + "\"/></svg>";
}

}  // namespace

std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures) {
  if (figures.empty()) { return {}; }
  const io::ScratchFolder scratch;
  const auto picture = [&](std::size_t n) { return scratch.path() / (std::to_string(n) + ".svg"); };
  std::string script;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    script += gnuplot_script(*figures[n], picture(n).string());
  }
  io::replace_file(scratch.path() / "figures.gp", script);
  run_gnuplot(scratch.path());
  std::vector<std::string> drawings;
  for (std::size_t n = 0; n < figures.size(); ++n) {
    const std::string label = figures[n]->title + ". " + figures[n]->caption;
    drawings.push_back(svg_for_page(file_text(picture(n)), label));
  }
  return drawings;
}

std::string html_legend(const Figure& figure) {
  const std::vector<Look> looks = looks_of(figure);
  std::string items;
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    if (figure.series[n].label.empty()) { continue; }
    items += "<li>" + sample(looks[n]) + escape_markup(figure.series[n].label) + "</li>";
  }
  const std::vector<std::string> kinds = mark_labels(figure);
  for (std::size_t n = 0; n < kinds.size(); ++n) {
    items += "<li>" + sample(shape_of_mark(n)) + escape_markup(kinds[n]) + "</li>";
  }
  return items.empty() ? items : "<ul class=\"legend\">" + items + "</ul>";
}

}  // namespace palpate

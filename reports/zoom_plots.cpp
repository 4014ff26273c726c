// SPDX-License-Identifier: MIT
#include "reports/zoom_plots.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "report_assets.hpp"

#include "reports/field_units.hpp"
#include "reports/figure_look.hpp"
#include "reports/markup.hpp"
#include "reports/thinning.hpp"

namespace palpate {

namespace {

/// Text as a script literal that cannot end the script.
std::string script_text(const std::string& text) {
  std::string literal =
      nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  for (std::size_t at = literal.find('<'); at != std::string::npos; at = literal.find('<', at)) {
    literal.replace(at, 1, "\\u003c");
  }
  return literal;
}

std::set<std::size_t> rows_of(const Figure& figure) {
  constexpr double columns = 2000.0;
  std::set<std::size_t> rows;
  for (const Series& series : figure.series) {
    const double begin = series.x.front();
    const double span = std::max(series.x.back() - begin, 1e-300);
    const Projection project = [&](double x, double y) {
      return Pixel{columns * (x - begin) / span, y};
    };
    for (const std::size_t row : thinned(series, project)) { rows.insert(row); }
  }
  return rows;
}

std::string data_of(const Figure& figure) {
  constexpr int digits = 7;
  std::string text = "[";
  for (const std::size_t row : rows_of(figure)) {
    text += (text.size() == 1 ? "[" : ",[") + plain_number(figure.series.front().x[row], 9);
    for (const Series& series : figure.series) {
      const bool finite = row < series.y.size() && std::isfinite(series.y[row]);
      text += "," + (finite ? plain_number(series.y[row], digits) : "null");
    }
    text += "]";
  }
  return text + "]";
}

std::string plot_of(const Figure& figure) {
  std::string labels = script_text(figure.x.label);
  std::string colours;
  for (const Series& series : figure.series) { labels += "," + script_text(series.label); }
  for (const Look& look : looks_of(figure)) {
    colours += (colours.empty() ? "" : ",") + std::to_string(look.colour);
  }
  return "plot('zoom-" + figure.id + "'," + data_of(figure) + ",[" + labels + "],[" + colours +
         "]," + script_text(figure.y.label) + ");\n";
}

}  // namespace

std::string html_zoom_section(const std::vector<Figure>& figures) {
  if (figures.empty()) { return {}; }
  std::string html = "<style>" + std::string(assets::dygraph_css) +
                     "</style>\n<details class=\"zooms\"><summary>Zoom into the traces</summary>\n"
                     "<p class=\"soft\">Drag to zoom, drag with shift to move, double click to see "
                     "all again.</p>\n<noscript><p>This part needs scripts; the pictures above do "
                     "not.</p></noscript>\n";
  for (const Figure& figure : figures) {
    html += "<h3>" + escape_markup(figure.title) + "</h3><div class=\"zoom-legend\" id=\"zoom-" +
            figure.id + "-legend\"></div><div class=\"zoom\" id=\"zoom-" + figure.id +
            "\"></div>\n";
  }
  return html + "</details>\n";
}

std::string zoom_script(const std::vector<Figure>& figures) {
  if (figures.empty()) { return {}; }
  std::string script(assets::zoom_js);
  script += "zoomPlots(function (plot) {\n";
  for (const Figure& figure : figures) { script += plot_of(in_field_units(figure)); }
  return script + "});\n";
}

}  // namespace palpate

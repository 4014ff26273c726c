// SPDX-License-Identifier: MIT
#include "reports/run_report.hpp"

#include "report_assets.hpp"

#include "reports/figure_svg.hpp"
#include "reports/markup.hpp"
#include "reports/trace_figures.hpp"
#include "reports/zoom_plots.hpp"

namespace palpate {

namespace {

std::string notes_under(const std::string& heading, const std::vector<std::string>& items) {
  return items.empty() ? std::string() : "<h2>" + heading + "</h2>\n" + html_notes(items);
}

std::string events_of(const Trace& trace) {
  if (trace.events.empty()) { return {}; }
  Table table{.title = "In order of time", .columns = {"time (s)", "event", "detail"}};
  for (const Event& event : trace.events) {
    table.rows.push_back({event.time, event.kind, event.detail});
  }
  return "<h2>Events</h2>\n" + html_table(table);
}

std::string pictures_of(const std::vector<Figure>& figures) {
  if (figures.empty()) { return {}; }
  std::vector<const Figure*> pointers;
  for (const Figure& figure : figures) { pointers.push_back(&figure); }
  const std::vector<std::string> drawings = draw_figures(pointers);
  std::string html = "<h2>Traces</h2>\n<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < figures.size(); ++n) { html += html_figure(figures[n], drawings[n]); }
  return html + "</div>\n";
}

}  // namespace

std::string to_html(const RunReport& report, const Trace& trace) {
  const std::vector<Figure> over_time = figures_over_time(trace);
  std::vector<Figure> figures = over_time;
  if (auto snapshot = snapshot_figure(trace)) { figures.push_back(std::move(*snapshot)); }
  std::string body = html_banner({.title = report.title,
                                  .small_print = {report.command},
                                  .held = report.held,
                                  .verdict = report.verdict,
                                  .detail = report.detail});
  body += "<main>\n" + notes_under("Warnings", report.warnings) + "<h2>Key facts</h2>\n" +
          html_facts(report.facts) + events_of(trace) + pictures_of(figures) +
          html_zoom_section(over_time) +
          notes_under("Skipped, because the scene does not need it", report.skipped) + "</main>\n" +
          html_provenance(report.provenance, report.command);
  if (over_time.empty()) { return html_page(report.title, body, {}); }
  const std::string zoom = zoom_script(over_time);
  return html_page(report.title, body, {assets::dygraph_js, zoom});
}

}  // namespace palpate

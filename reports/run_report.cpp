// SPDX-License-Identifier: MIT
#include "reports/run_report.hpp"

#include <span>

#include "report_assets.hpp"

#include "reports/figure_svg.hpp"
#include "reports/markup.hpp"
#include "reports/tool_facts.hpp"
#include "reports/tool_figures.hpp"
#include "reports/trace_figures.hpp"
#include "reports/view_page.hpp"
#include "reports/zoom_plots.hpp"

namespace palpate {

namespace {

std::string notes_under(const std::string& heading, const std::vector<std::string>& items) {
  return items.empty() ? std::string() : "<h2>" + heading + "</h2>\n" + html_notes(items);
}

std::string events_of(const Trace& trace) {
  return trace.events.empty() ? "" : "<h2>Events</h2>\n" + html_table(events_table(trace));
}

/// Sections of pictures with their headings, drawn together.
struct Sections {
  std::string tool;
  std::string traces;
};

std::string section(const char* heading, std::span<const Figure> figures,
                    std::span<const std::string> drawings) {
  if (figures.empty()) { return {}; }
  std::string html = std::string("<h2>") + heading + "</h2>\n<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < figures.size(); ++n) { html += html_figure(figures[n], drawings[n]); }
  return html + "</div>\n";
}

Sections sections_of(const std::vector<Figure>& tool, const std::vector<Figure>& traces) {
  std::vector<const Figure*> all;
  for (const Figure& figure : tool) { all.push_back(&figure); }
  for (const Figure& figure : traces) { all.push_back(&figure); }
  const std::vector<std::string> drawings = draw_figures(all);
  const std::span<const std::string> drawn(drawings);
  return {section("Forces on the tool", tool, drawn.first(tool.size())),
          section("Traces", traces, drawn.subspan(tool.size()))};
}

}  // namespace

std::string to_html(const RunReport& report, const Trace& trace) {
  const std::vector<Figure> over_time = figures_over_time(trace);
  std::vector<Figure> tool = tool_figures(trace);
  tool.insert(tool.end(), report.tool_figures.begin(), report.tool_figures.end());
  std::vector<Figure> figures = over_time;
  if (auto snapshot = snapshot_figure(trace)) { figures.push_back(std::move(*snapshot)); }
  std::vector<Figure> zooms = tool_traces(trace);
  zooms.insert(zooms.end(), over_time.begin(), over_time.end());
  const Sections sections = sections_of(tool, figures);
  std::string body = html_banner({.title = report.title,
                                  .small_print = {report.command},
                                  .held = report.held,
                                  .verdict = report.verdict,
                                  .detail = report.detail});
  body += "<main>\n" + notes_under("Warnings", report.warnings) + "<h2>Key facts</h2>\n" +
          html_facts(report.facts) + (report.view ? html_view(*report.view) : "") + sections.tool + events_of(trace) + sections.traces +
          html_zoom_section(zooms) +
          notes_under("Skipped, because the scene does not need it", report.skipped) + "</main>\n" +
          html_provenance(report.provenance, report.command);
  const std::string zoom = zoom_script(zooms);
  const std::string view = report.view ? view_script() : "";
  std::vector<std::string_view> scripts;
  if (!zooms.empty()) { scripts = {assets::dygraph_js, zoom}; }
  if (report.view) { scripts.push_back(view); }
  return html_page(report.title, body, scripts);
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/run_report.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "reports/figure_svg.hpp"
#include "reports/markup.hpp"
#include "report_assets.hpp"

namespace palpate {

namespace {

/// Columns of one record and unit belong in one picture: "tip.x_m", "tip.y_m", "tip.z_m".
struct Group {
  std::string name;
  std::string unit;
  std::vector<const Column*> columns;
};

std::vector<Group> grouped(const Trace& trace) {
  std::vector<Group> groups;
  for (const Column& column : trace.columns) {
    const std::size_t dot = column.name.rfind('.');
    const std::string name = dot == std::string::npos ? "" : column.name.substr(0, dot);
    if (groups.empty() || groups.back().name != name || groups.back().unit != column.unit) {
      groups.push_back({name, column.unit, {}});
    }
    groups.back().columns.push_back(&column);
  }
  return groups;
}

/// Positions are drawn as displacement from the first tick: what moves is far smaller than where
/// it is.
bool as_displacement(const Group& group) { return group.unit == "m" && !group.name.empty(); }

std::string what(const Group& group) {
  if (as_displacement(group)) { return "displacement"; }
  if (group.unit == "m") { return "position"; }
  if (group.unit == "m/s") { return "velocity"; }
  return group.unit == "N" ? "force" : "value";
}

Figure figure_of(const Group& group, const Trace& trace, std::size_t index) {
  Figure figure{.id = "trace-" + std::to_string(index),
                .title = (group.name.empty() ? "" : group.name + ": ") + what(group),
                .caption = as_displacement(group)
                               ? "Displacement from the first tick, over time."
                               : "The " + what(group) + " at every tick, over time.",
                .x = {.label = "time (s)"},
                .y = {.label = what(group) + " (" + group.unit + ")"}};
  for (const Column* column : group.columns) {
    Series series{.label = column->name, .x = trace.time, .y = column->values};
    if (as_displacement(group)) {
      for (double& y : series.y) { y -= column->values.front(); }
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

/// Rows "t,a,b;" for dygraphs, thinned to at most 4000 ticks so that a page stays small.
std::string zoom_data(const Figure& figure) {
  const auto& time = figure.series.front().x;
  const std::size_t stride = std::max<std::size_t>(1, time.size() / 4000);
  std::string rows = "[";
  for (std::size_t n = 0; n < time.size(); n += stride) {
    rows += (n == 0 ? "[" : ",[") + exact_number(time[n]);
    for (const Series& series : figure.series) {
      rows += "," + (std::isfinite(series.y[n]) ? short_number(series.y[n]) : "null");
    }
    rows += "]";
  }
  return rows + "]";
}

/// Text as a script literal that cannot end the script.
std::string script_text(const std::string& text) {
  std::string literal = nlohmann::json(text).dump();
  for (std::size_t at = literal.find("</"); at != std::string::npos; at = literal.find("</", at + 3)) {
    literal.replace(at, 2, "<\\/");
  }
  return literal;
}

std::string zoom_plot(const Figure& figure) {
  std::string labels = "[\"time (s)\"";
  std::string colours = "[";
  for (std::size_t n = 0; n < figure.series.size(); ++n) {
    labels += "," + script_text(figure.series[n].label);
    colours += (n == 0 ? "" : ",") + std::string("c(") + std::to_string(n) + ")";
  }
  return "new Dygraph(document.getElementById('zoom-" + figure.id + "')," + zoom_data(figure) +
         ",{labels:" + labels + "],colors:" + colours + "],xlabel:'time (s)',ylabel:" +
         script_text(figure.y.label) +
         ",strokeWidth:1.6,legend:'follow',gridLineColor:v('--grid'),axisLineColor:v('--soft'),"
         "axes:{y:{axisLabelWidth:76,axisLabelFormatter:function(y){return String(+y.toPrecision(4))}}}});\n";
}

std::string zoom_script(const std::vector<Figure>& figures) {
  std::string script =
      "(function () {\nvar style = getComputedStyle(document.documentElement);\n"
      "function v(name) { return style.getPropertyValue(name).trim(); }\n"
      "function c(n) { return v('--series-' + (n % 8)); }\n";
  for (const Figure& figure : figures) { script += zoom_plot(figure); }
  return script + "})();\n";
}

std::string list_of(const std::string& heading, const std::vector<std::string>& items) {
  if (items.empty()) { return {}; }
  std::string html = "<h2>" + heading + "</h2>\n<ul class=\"notes\">";
  for (const std::string& item : items) { html += "<li>" + escape_markup(item) + "</li>"; }
  return html + "</ul>\n";
}

std::string events_of(const Trace& trace) {
  if (trace.events.empty()) { return {}; }
  Table table{.title = "Events", .columns = {"time (s)", "event", "detail"}};
  for (const Event& event : trace.events) { table.rows.push_back({event.time, event.kind, event.detail}); }
  return html_table(table);
}

}  // namespace

std::string to_html(const RunReport& report, const Trace& trace) {
  std::vector<Figure> figures;
  if (trace.time.size() > 1) {
    for (const Group& group : grouped(trace)) {
      figures.push_back(figure_of(group, trace, figures.size()));
    }
  }
  std::vector<const Figure*> pointers;
  for (const Figure& figure : figures) { pointers.push_back(&figure); }
  const std::vector<std::string> drawings = draw_figures(pointers);
  std::string body = "<header class=\"top\"><h1>" + escape_markup(report.title) + "</h1>\n<p class=\"soft\">" +
                     escape_markup(report.command) + "</p>\n<div class=\"verdict " +
                     (report.held ? "pass" : "fail") + "\"><strong>" + escape_markup(report.verdict) +
                     "</strong>" + escape_markup(report.detail) + "</div></header>\n<main>\n" +
                     html_facts(report.facts) + list_of("Warnings", report.warnings) + events_of(trace);
  if (!figures.empty()) { body += "<h2>Traces</h2>\n<div class=\"figures\">\n"; }
  for (std::size_t n = 0; n < figures.size(); ++n) { body += html_figure(figures[n], drawings[n]); }
  if (!figures.empty()) {
    body += "</div>\n<details><summary>Zoom into the traces (drag to zoom, double click to leave)</summary>\n";
    for (const Figure& figure : figures) {
      body += "<h4>" + escape_markup(figure.title) + "</h4><div class=\"zoom\" id=\"zoom-" + figure.id + "\"></div>\n";
    }
    body += "</details>\n";
  }
  body += list_of("Skipped, because the scene does not need it", report.skipped) + "</main>\n" +
          html_provenance(report.provenance, report.command);
  std::vector<std::string_view> scripts;
  std::string zoom;
  if (!figures.empty()) {
    body += "<style>" + std::string(assets::dygraph_css) + "</style>\n";
    // The plots need a size, so they are made when their section is opened.
    zoom = "document.querySelector('details:has(.zoom)').addEventListener('toggle', function () {\n" +
           zoom_script(figures) + "}, { once: true });\n";
    scripts = {assets::dygraph_js, zoom};
  }
  return html_page(report.title, body, scripts);
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/calibration_report.hpp"

#include "reports/figure_svg.hpp"
#include "reports/html_page.hpp"
#include "reports/markup.hpp"

namespace palpate {
namespace {

std::string figures_markup(const std::vector<Figure>& figures) {
  std::vector<const Figure*> all;
  for (const Figure& figure : figures) { all.push_back(&figure); }
  const std::vector<std::string> drawings = draw_figures(all);
  std::string html = "<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < figures.size(); ++n) { html += html_figure(figures[n], drawings[n]); }
  return html + "</div>\n";
}

std::vector<Fact> facts_of(const CalibrationReport& report) {
  const calibration::Calibration& result = report.result;
  const calibration::Fit& fit = result.fit;
  const std::size_t freedom = fit.data.degrees_of_freedom();
  return {
      {"scene", report.scene, ""},
      {"search", fit.converged ? "converged" : "did not converge",
       "in " + std::to_string(fit.iterations) + " iterations, " + std::to_string(result.simulations) +
           " simulations of a coarser block"},
      {"cost of the coarser block", quantity(result.shortcut_cost(), ""),
       "largest difference to the whole scene, in uncertainties"},
      {"intervals", freedom == 0 ? "normal" : "Student's t",
       freedom == 0 ? "too few subjects for a spread"
                    : "spread between subjects with " + std::to_string(freedom) + " degrees of freedom"}};
}

std::string kind_banner(const CalibrationReport& report) {
  return std::to_string(report.recordings.size()) +
         (report.recordings.size() == 1 ? " recording, " : " recordings, ") +
         (report.reconstructed() ? "reconstructed, not measured" : "measured");
}

}  // namespace

std::string to_html(const CalibrationReport& report) {
  std::string body = html_banner({.title = "Calibration of " + report.scene,
                                  .small_print = {kind_banner(report)},
                                  .held = report.result.held(),
                                  .verdict = calibration_verdict(report),
                                  .detail = calibration_detail(report)});
  const std::vector<Table> tables = calibration_tables(report);
  body += "<main>\n<h2>Before you believe it</h2>\n" + html_notes(calibration_warnings(report)) +
          "<h2>Key facts</h2>\n" + html_facts(facts_of(report)) + "<h2>What was fitted</h2>\n" +
          html_table(tables.front()) + "<h2>Fit against recordings</h2>\n" +
          figures_markup(calibration_figures(report));
  body += "<div class=\"exhibits\">\n";
  for (std::size_t n = 1; n < tables.size(); ++n) { body += html_table(tables[n]); }
  body += "</div>\n";
  if (report.result.held_out.empty()) {
    body += html_notes({"Groups were not left out in turn: that needs two groups or more."});
  }
  body += "</main>\n";
  std::vector<Fact> facts;
  for (const auto& [name, value] : report.provenance) { facts.push_back({name, value, ""}); }
  return html_page("Calibration", body + html_provenance(facts, report.command), {});
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/html_case.hpp"

#include <algorithm>
#include <cctype>

#include "reports/html_page.hpp"
#include "reports/margin.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

std::string quantity_row(const Quantity& q) {
  const std::string head = "<tr><th scope=\"row\">" + escape_markup(q.name) +
                           "</th><td class=\"number\" title=\"" + exact_number(q.value) + "\">" +
                           escape_markup(measured_text(q)) + "</td>";
  if (!q.judged()) {
    return head + "<td class=\"soft\" colspan=\"4\">for information, not judged</td></tr>\n";
  }
  const std::string precise = exact_number(q.lower) + " to " + exact_number(q.upper);
  return head + "<td class=\"number\" title=\"" + precise + "\">" + escape_markup(allowed_text(q)) +
         "</td><td class=\"number\">" + share_text(q) + "</td><td>" +
         html_badge(q.holds() ? Status::pass : Status::fail) + "</td><td class=\"why\">" +
         escape_markup(q.bound_from) + "</td></tr>\n";
}

/// Few, or some that do not hold: shown. Many that all hold: folded.
std::string quantities_of(const Outcome& outcome) {
  constexpr std::size_t few = 6;
  if (outcome.quantities.size() <= few || outcome.status == Status::fail) {
    return html_quantities(outcome);
  }
  return "<details><summary>" + std::to_string(outcome.quantities.size()) +
         " quantities</summary>\n" + html_quantities(outcome) + "</details>\n";
}

std::string cost_of(const Outcome& outcome) {
  if (outcome.timings.empty()) { return {}; }
  Table table{.title = "Cost on this machine",
              .caption = "Measured once, and not judged here.",
              .columns = {"what", "value", "unit"}};
  for (const Timing& timing : outcome.timings) {
    table.rows.push_back({timing.name, timing.value, timing.unit});
  }
  return html_table(table);
}

std::string seconds_text(double seconds) {
  constexpr double worth_telling = 0.1;
  return seconds >= worth_telling
             ? "<span class=\"seconds\">" + short_number(seconds, 2) + "\u00a0s</span>"
             : "";
}

std::string exhibits(const Outcome& outcome, const std::vector<std::string>& drawings) {
  std::string html;
  for (std::size_t n = 0; n < outcome.figures.size(); ++n) {
    html += html_figure(outcome.figures[n], drawings.at(n));
  }
  for (const Table& table : outcome.tables) { html += html_table(table); }
  html += cost_of(outcome);
  const bool many = outcome.figures.size() > 4;
  return html.empty() ? html
                      : "<div class=\"exhibits" + std::string(many ? " many" : "") + "\">\n" +
                            html + "</div>\n";
}

}  // namespace

std::string case_anchor(const std::string& case_name) {
  std::string id = "case-" + case_name;
  std::ranges::replace_if(
      id, [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '_'; }, '-');
  return id;
}

std::string html_quantities(const Outcome& outcome) {
  std::string html =
      "<div class=\"scroll\"><table class=\"quantities\"><thead><tr><th scope=\"col\">quantity</th>"
      "<th scope=\"col\" class=\"number\">measured</th><th scope=\"col\" class=\"number\">allowed"
      "</th><th scope=\"col\" class=\"number\">bound used</th><th scope=\"col\">verdict</th>"
      "<th scope=\"col\">where the bound comes from</th></tr></thead><tbody>\n";
  for (const Quantity& q : outcome.quantities) { html += quantity_row(q); }
  return html + "</tbody></table></div>\n";
}

std::string html_case(const Outcome& outcome, const std::vector<std::string>& drawings) {
  std::string html = "<article id=\"" + case_anchor(outcome.name) + "\">\n<h3>" +
                     html_badge(outcome.status) + " <span>" + escape_markup(outcome.name) +
                     "</span>" + seconds_text(outcome.seconds) + "</h3>\n<p class=\"claim\">" +
                     escape_markup(outcome.claim) + "</p>\n";
  if (!outcome.reason.empty()) {
    html += "<p class=\"reason\">" + escape_markup(outcome.reason) + "</p>\n";
  }
  html += html_notes(outcome.notes);
  if (!outcome.quantities.empty()) { html += quantities_of(outcome); }
  return html + exhibits(outcome, drawings) + "</article>\n";
}

}  // namespace palpate

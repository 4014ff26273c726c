// SPDX-License-Identifier: MIT
#include "reports/html_report.hpp"

#include <algorithm>
#include <cctype>

#include "report_assets.hpp"

#include "reports/figure_svg.hpp"
#include "reports/html_case.hpp"
#include "reports/html_overview.hpp"
#include "reports/html_page.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

using Drawings = std::map<const Outcome*, std::vector<std::string>>;

Drawings draw_all(const std::vector<Outcome>& outcomes) {
  std::vector<const Figure*> figures;
  for (const Outcome& outcome : outcomes) {
    for (const Figure& figure : outcome.figures) { figures.push_back(&figure); }
  }
  std::vector<std::string> svgs = draw_figures(figures);
  auto next = svgs.begin();
  Drawings drawings;
  for (const Outcome& outcome : outcomes) {
    for (std::size_t n = 0; n < outcome.figures.size(); ++n) {
      drawings[&outcome].push_back(std::move(*next++));
    }
  }
  return drawings;
}

std::string capitalised(std::string text) {
  if (!text.empty()) {
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  }
  return text;
}

std::string known(const Results& results, const std::string& name) {
  const auto found = results.provenance.find(name);
  return found == results.provenance.end() ? std::string() : found->second;
}

std::string detail_text(const std::vector<Outcome>& outcomes, const Tally& sum) {
  std::ptrdiff_t judged = 0;
  for (const Outcome& outcome : outcomes) {
    judged += std::ranges::count_if(outcome.quantities, &Quantity::judged);
  }
  const std::string quantities = std::to_string(judged) + " quantities were judged";
  if (sum.passed == sum.all()) { return quantities + "; each lies within its bound."; }
  std::string text;
  const auto add = [&text](int count, const std::string& what) {
    if (count > 0) { text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what; }
  };
  add(sum.passed, "passed");
  add(sum.failed, "failed");
  add(sum.errors, "ended in an error");
  add(sum.skipped, "skipped, each with its reason");
  return text + "; " + quantities + ".";
}

std::string suite_section(const Suite& suite, const Drawings& drawings) {
  std::string html = "<section id=\"" + suite_anchor(suite) + "\">\n<h2>" +
                     escape_markup(capitalised(suite.name)) + "</h2>\n";
  const std::string about = about_suite(suite.name);
  if (!about.empty()) { html += "<p class=\"soft\">" + about + "</p>\n"; }
  static const std::vector<std::string> none;
  for (const Outcome* outcome : suite.outcomes) {
    const auto drawn = drawings.find(outcome);
    html += html_case(*outcome, drawn == drawings.end() ? none : drawn->second);
  }
  return html + "</section>\n";
}

}  // namespace

std::string to_html(const Results& results) {
  const Tally sum = tally(results.outcomes);
  const std::vector<Suite> suites = suites_of(results.outcomes);
  const Drawings drawings = draw_all(results.outcomes);
  const std::string version = known(results, "version");
  std::string body = html_banner(
      {.title = results.title,
       .small_print = {results.command, known(results, "date"),
                       version.empty() ? "" : "version " + version, known(results, "commit")},
       .held = sum.holds(),
       .verdict = verdict_text(sum),
       .detail = detail_text(results.outcomes, sum)});
  body +=
      "<main>\n" + html_suites(suites) + html_case_table(results.outcomes) + html_contents(suites);
  for (const Suite& suite : suites) { body += suite_section(suite, drawings); }
  std::vector<Fact> facts;
  for (const auto& [name, value] : results.provenance) { facts.push_back({name, value, {}}); }
  body += "</main>\n" + html_provenance(facts, results.command);
  return html_page(results.title, body, {assets::report_js});
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "reports/html/results_page.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "report_assets.hpp"

#include "reports/html/html_page.hpp"
#include "reports/plot/figure_svg.hpp"
#include "reports/results/results.hpp"

namespace palpate {

namespace {

std::string unit_text(const std::string& unit) {
  return unit == "1" || unit.empty() ? "" : "\u00a0" + unit;
}

/// Measured value and bounds must not read the same when they differ.
int digits_of(const Quantity& q) {
  return std::max({digits_apart(q.value, q.lower), digits_apart(q.value, q.upper),
                   digits_apart(q.lower, q.upper)});
}

}  // namespace

double share_of_bound(const Quantity& q) {
  if (std::isnan(q.value)) { return unbounded; }
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  const double met = q.holds() ? 1.0 : unbounded;  // where no share can be told
  if (above && below) {
    const double half = 0.5 * (q.upper - q.lower);
    const double away = std::abs(q.value - 0.5 * (q.upper + q.lower));
    if (!(half > 0.0)) { return met; }
    // Rounding must not let a share contradict the verdict.
    return q.holds() ? std::min(away / half, 1.0) : std::max(away / half, std::nextafter(1.0, 2.0));
  }
  if (below) { return q.upper > 0.0 ? std::max(0.0, q.value / q.upper) : met; }
  if (above) { return q.value > 0.0 ? std::max(0.0, q.lower / q.value) : met; }
  return std::isfinite(q.value) ? 0.0 : met;
}

bool met_exactly(const Quantity& q) {
  return q.holds() && (q.value == q.lower || q.value == q.upper) && q.value == std::round(q.value);
}

const Quantity* tightest_quantity(const Outcome& outcome) {
  const Quantity* tightest = nullptr;
  const auto rank = [](const Quantity& q) {
    return std::tuple(!q.holds(), std::isnan(q.value), !met_exactly(q), share_of_bound(q));
  };
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged()) { continue; }
    if (tightest == nullptr || rank(q) > rank(*tightest)) { tightest = &q; }
  }
  return tightest;
}

std::string allowed_text(const Quantity& q) {
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  const std::string unit = unit_text(q.unit);
  const int digits = digits_of(q);
  const std::string upper = short_number(q.upper, digits) + unit;
  if (above && below) {
    if (q.lower == q.upper) { return "= " + upper; }
    return short_number(q.lower, digits) + " to " + upper;
  }
  if (below) { return "≤ " + upper; }
  return above ? "≥ " + short_number(q.lower, digits) + unit : "finite";
}

std::string measured_text(const Quantity& q) {
  const std::string number = short_number(q.value, digits_of(q));
  return std::isnan(q.value) ? number : number + unit_text(q.unit);
}

std::string share_text(const Quantity& q) {
  if (std::isnan(q.value)) { return "–"; }
  if (met_exactly(q)) { return "exact"; }
  const double share = share_of_bound(q);
  if (!std::isfinite(share)) { return "beyond"; }
  if (!q.holds()) { return share < 10.0 ? short_number(share, 2) + " times" : "over 10 times"; }
  return share < 0.001 ? "< 0.1\u00a0%"
                       : short_number(100.0 * share, share < 0.1 ? 2 : 3) + "\u00a0%";
}

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

// What a reader needs before any detail: the verdict, suite by suite, and every case on one line
// with the worst first.

/// Outcomes of one suite, in their order.
struct Suite {
  std::string name{};
  std::vector<const Outcome*> outcomes{};
};
std::vector<Suite> suites_of(const std::vector<Outcome>& outcomes);
std::string suite_anchor(const Suite& suite);
/// What the suites of the program are about; empty for any other.
std::string about_suite(const std::string& name);

/// "PASS: 61 of 61 cases hold; 2 skipped".
std::string verdict_text(const Tally& tally);

std::string html_suites(const std::vector<Suite>& suites);
std::string html_case_table(const std::vector<Outcome>& outcomes);
std::string html_contents(const std::vector<Suite>& suites);

namespace {

std::string count_of(int count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Errors and failures first, then what is closest to its bound, then what was not run.
std::vector<const Outcome*> worst_first(const std::vector<Outcome>& outcomes) {
  std::vector<const Outcome*> order;
  for (const Outcome& outcome : outcomes) { order.push_back(&outcome); }
  const auto rank = [](const Outcome* outcome) {
    const Quantity* tight = tightest_quantity(*outcome);
    const double share = tight == nullptr || met_exactly(*tight) ? 0.0 : share_of_bound(*tight);
    switch (outcome->status) {
      case Status::error: return std::pair(0, 0.0);
      case Status::fail: return std::pair(1, -share);
      case Status::pass: return std::pair(2, -share);
      case Status::skip: break;
    }
    return std::pair(3, 0.0);
  };
  std::ranges::stable_sort(order, {}, rank);
  return order;
}

/// The bar is full when the bound is reached.
std::string share_cell(const Quantity& q) {
  const double share = met_exactly(q) ? 0.0 : std::min(1.0, share_of_bound(q));
  const std::string bar = plain_number(std::round(1000.0 * share) / 10.0);
  return "<td class=\"share\" data-label=\"bound used\"><span class=\"bar" +
         std::string(q.holds() ? "" : " over") + "\"><i style=\"width:" + bar + "%\"></i></span>" +
         share_text(q) + "</td>";
}

std::string numbers_of(const Outcome& outcome) {
  const Quantity* q = tightest_quantity(outcome);
  if (q == nullptr || outcome.status == Status::skip || outcome.status == Status::error) {
    return "<td class=\"why\" colspan=\"4\">" + escape_markup(outcome.reason) + "</td>";
  }
  return "<td class=\"quantity\">" + escape_markup(q->name) + "<small>" +
         escape_markup(q->bound_from) +
         "</small></td><td class=\"number\" data-label=\"measured\" " + "title=\"" +
         exact_number(q->value) + "\">" + escape_markup(measured_text(*q)) +
         "</td><td class=\"number\" data-label=\"allowed\">" + escape_markup(allowed_text(*q)) +
         "</td>" + share_cell(*q);
}

std::string case_rows(const Outcome& outcome) {
  std::string rows = "<tbody data-status=\"" + std::string(name_of(outcome.status)) +
                     "\"><tr><td>" + html_badge(outcome.status) +
                     "</td><th scope=\"row\"><a href=\"#" + case_anchor(outcome.name) + "\">" +
                     escape_markup(outcome.name) + "</a><small>" + escape_markup(outcome.claim) +
                     "</small></th>" + numbers_of(outcome) + "</tr>\n";
  if (outcome.quantities.size() > 1) {
    rows += "<tr class=\"more\"><td></td><td colspan=\"5\"><details><summary>all " +
            std::to_string(outcome.quantities.size()) + " quantities</summary>\n" +
            html_quantities(outcome) + "</details></td></tr>";
  }
  return rows + "</tbody>\n";
}

std::string filters(const Tally& sum) {
  const auto button = [](const std::string& status, const std::string& label, int count,
                         bool pressed) {
    return "<button type=\"button\" data-status=\"" + status + "\" aria-pressed=\"" +
           (pressed ? "true" : "false") + "\">" + label + " <span>" + std::to_string(count) +
           "</span></button>";
  };
  return "<div class=\"filters\" hidden><input type=\"search\" placeholder=\"Filter by case, claim "
         "or "
         "quantity\" aria-label=\"Filter cases\">" +
         button("", "all", sum.all(), true) + button("fail", "failed", sum.failed, false) +
         button("error", "errors", sum.errors, false) +
         button("pass", "passed", sum.passed, false) +
         button("skip", "skipped", sum.skipped, false) + "</div>\n";
}

/// "oscillator/order" and "rk4" of "oscillator/order/rk4".
std::pair<std::string, std::string> split_name(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  if (slash == std::string::npos) { return {"", name}; }
  return {name.substr(0, slash), name.substr(slash + 1)};
}

std::string contents_of(const Suite& suite) {
  std::vector<std::pair<std::string, std::string>> groups;  // parent, links
  for (const Outcome* outcome : suite.outcomes) {
    const auto [parent, leaf] = split_name(outcome->name);
    auto group = std::ranges::find(groups, parent, &std::pair<std::string, std::string>::first);
    if (group == groups.end()) { group = groups.insert(groups.end(), {parent, {}}); }
    group->second += "<a class=\"" + std::string(name_of(outcome->status)) + "\" href=\"#" +
                     case_anchor(outcome->name) + "\">" + escape_markup(leaf) + "</a> ";
  }
  std::string html = "<dl>";
  for (const auto& [parent, links] : groups) {
    html += "<div><dt>" + escape_markup(parent) + "</dt><dd>" + links + "</dd></div>\n";
  }
  return html + "</dl>\n";
}

}  // namespace

std::vector<Suite> suites_of(const std::vector<Outcome>& outcomes) {
  std::vector<Suite> suites;
  for (const Outcome& outcome : outcomes) {
    auto found = std::ranges::find(suites, outcome.suite, &Suite::name);
    if (found == suites.end()) { found = suites.insert(suites.end(), {.name = outcome.suite}); }
    found->outcomes.push_back(&outcome);
  }
  return suites;
}

std::string suite_anchor(const Suite& suite) { return "suite" + case_anchor(suite.name).substr(4); }

std::string about_suite(const std::string& name) {
  static const std::map<std::string, std::string> about{
      {"accuracy", "The model against closed forms and independent solutions."},
      {"stability", "Which steps and scenes keep the motion bounded, and which do not."},
      {"haptics", "What the device asks for and what the hand feels."},
      {"clinical", "The model against what was recorded at the bedside."},
      {"timing", "What a step costs, and whether it comes in time."},
      {"model", "The laws that the model is built on."}};
  const auto found = about.find(name);
  return found == about.end() ? std::string() : found->second;
}

std::string verdict_text(const Tally& sum) {
  const int ran = sum.all() - sum.skipped;
  const std::string skipped =
      sum.skipped == 0 ? "" : "; " + std::to_string(sum.skipped) + " skipped";
  if (ran == 0) { return "FAIL: no case ran" + skipped; }
  if (sum.holds()) {
    return "PASS: " + std::to_string(sum.passed) + " of " +
           count_of(ran, "case holds", "cases hold") + skipped;
  }
  return "FAIL: " + std::to_string(sum.failed + sum.errors) + " of " +
         count_of(ran, "case falls short", "cases fall short") + skipped;
}

std::string html_suites(const std::vector<Suite>& suites) {
  std::string html = "<ul class=\"suites\">\n";
  for (const Suite& suite : suites) {
    std::vector<Outcome> bare;
    double seconds = 0.0;
    for (const Outcome* outcome : suite.outcomes) {
      bare.push_back({.status = outcome->status});
      seconds += outcome->seconds;
    }
    const Tally sum = tally(bare);
    const int ran = sum.all() - sum.skipped;
    const bool fell = sum.failed + sum.errors > 0;
    html += "<li class=\"" +
            std::string(fell             ? "fail"
                        : sum.passed > 0 ? "pass"
                                         : "skip") +
            "\"><a href=\"#" + suite_anchor(suite) + "\">" + escape_markup(suite.name) + "</a><b>" +
            std::to_string(sum.passed) + " of " + std::to_string(ran) + "</b><small>" +
            (sum.skipped > 0 ? std::to_string(sum.skipped) + " skipped, " : "") +
            short_number(seconds, 2) + "\u00a0s</small></li>\n";
  }
  return html + "</ul>\n";
}

std::string html_case_table(const std::vector<Outcome>& outcomes) {
  std::string html =
      "<h2 id=\"cases\">Cases, worst first</h2>\n" + filters(tally(outcomes)) +
      "<div class=\"scroll\"><table class=\"cases\"><thead><tr><th scope=\"col\">verdict</th>"
      "<th scope=\"col\">case and claim</th><th scope=\"col\">tightest quantity, and where its "
      "bound "
      "comes from</th><th scope=\"col\" class=\"number\">measured</th><th scope=\"col\" "
      "class=\"number\">allowed</th><th scope=\"col\">bound used</th></tr></thead>\n";
  for (const Outcome* outcome : worst_first(outcomes)) { html += case_rows(*outcome); }
  return html + "</table></div>\n<p class=\"soft none\" hidden>No case matches.</p>\n";
}

std::string html_contents(const std::vector<Suite>& suites) {
  std::string html =
      "<nav class=\"contents\" aria-label=\"Contents\" id=\"contents\">\n<h2>Contents</h2>\n";
  for (const Suite& suite : suites) {
    html += "<h3><a href=\"#" + suite_anchor(suite) + "\">" + escape_markup(suite.name) +
            "</a></h3>\n" + contents_of(suite);
  }
  return html + "<h3><a href=\"#provenance\">Where this comes from</a></h3>\n</nav>\n";
}

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

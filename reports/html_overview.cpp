// SPDX-License-Identifier: MIT
#include "reports/html_overview.hpp"

#include <algorithm>
#include <cmath>

#include "reports/html_case.hpp"
#include "reports/html_page.hpp"
#include "reports/margin.hpp"
#include "reports/markup.hpp"

namespace palpate {

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
      case Status::error:
        return std::pair(0, 0.0);
      case Status::fail:
        return std::pair(1, -share);
      case Status::pass:
        return std::pair(2, -share);
      case Status::skip:
        break;
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

}  // namespace palpate

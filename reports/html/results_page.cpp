// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cctype>
#include <cmath>
#include <tuple>

#include "html_templates.hpp"
#include "report_assets.hpp"

#include "reports/html/html_page.hpp"
#include "reports/html/html_template.hpp"
#include "reports/results/results.hpp"

namespace palpate {
namespace {

std::string unit_text(const std::string& unit) {
  return unit == "1" || unit.empty() ? "" : "\u00a0" + unit;
}

/// Number of digits with which the value and the bounds are displayed differently if they differ.
int digits_of(const Quantity& q) {
  return std::max({digits_apart(q.value, q.lower), digits_apart(q.value, q.upper),
                   digits_apart(q.lower, q.upper)});
}

/// Returns true for counts and Boolean values that equal their bound. For these a fraction of 1 is
/// not a narrow margin.
bool met_exactly(const Quantity& q) {
  return q.holds() && (q.value == q.lower || q.value == q.upper) && q.value == std::round(q.value);
}

/// Fraction of an upper bound. A value of -20 with the bound -1 has a fraction of 5 %. For a bound
/// of 0 there is no scale: a value of 0 gives 1, a negative value gives 0.
double share_of_upper(double value, double bound) {
  if (bound > 0.0) { return std::max(0.0, value / bound); }
  if (bound < 0.0) { return value < 0.0 ? bound / value : unbounded; }
  return value < 0.0 ? 0.0 : value > 0.0 ? unbounded : 1.0;
}

std::string share_text(const Quantity& q) {
  if (std::isnan(q.value)) { return "–"; }
  if (met_exactly(q)) { return "exact"; }
  const double share = share_of_bound(q);
  if (!std::isfinite(share)) { return "beyond"; }
  if (!q.holds()) { return share < 10.0 ? short_number(share, 2) + " times" : "> 10 times"; }
  return share < 0.001 ? "< 0.1\u00a0%"
                       : short_number(100.0 * share, share < 0.1 ? 2 : 3) + "\u00a0%";
}

Data quantity_values(const Quantity& q) {
  Data values = record("name", q.name, "exact", exact_number(q.value), "measured", measured_text(q),
                       "judged", q.judged());
  if (q.judged()) {
    add_names(values, "bounds", exact_number(q.lower) + " to " + exact_number(q.upper), "allowed",
              allowed_text(q), "share", share_text(q), "badge", html_badge({q.status()}), "from",
              q.bound_from);
  }
  return values;
}

std::string status_text(const Outcome& outcome) { return std::string(name_of(outcome.status)); }

std::string seconds_text(double seconds) {
  constexpr double worth_telling = 0.1;
  return seconds >= worth_telling ? short_number(seconds, 2) + "\u00a0s" : "";
}

Table cost_table(const Outcome& outcome) {
  Table table = make_table("", "Cost on this machine", "Measured once, and not judged here.",
                           {"what", "value", "unit"});
  for (const Timing& timing : outcome.timings) {
    table.rows.push_back({timing.name, timing.value, timing.unit});
  }
  return table;
}

/// HTML id of the section of a case: "case-oscillator-order-rk4".
std::string case_anchor(const std::string& case_name) {
  std::string id = "case-" + case_name;
  std::ranges::replace_if(
      id, [](unsigned char c) { return std::isalnum(c) == 0 && c != '.' && c != '_'; }, '-');
  return id;
}

std::string html_quantities(const Outcome& outcome) {
  return fill(templates::quantities,
              record("quantities", data_of(outcome.quantities, quantity_values)));
}

/// Table of quantities, collapsed if there are many and all pass.
PagePart quantities_part(const Outcome& outcome) {
  constexpr std::size_t few = 6;
  const bool failed = outcome.status == Status::fail || outcome.status == Status::inconclusive;
  const std::size_t count = outcome.quantities.size();
  return folded_if(count > few && !failed, std::to_string(count) + " quantities",
                   Markup{html_quantities(outcome)});
}

Section case_section(const Outcome& outcome) {
  Section section{.kind = Section::Kind::article,
                  .heading = outcome.name,
                  .id = case_anchor(outcome.name),
                  .badge = {outcome.status},
                  .aside = seconds_text(outcome.seconds)};
  section.parts.emplace_back(Paragraph{outcome.claim, "claim"});
  for (const std::string& reason : outcome.reasons) {
    section.parts.emplace_back(Paragraph{reason, "reason"});
  }
  section.parts.emplace_back(Notes{outcome.notes});
  if (!outcome.quantities.empty()) { section.parts.push_back(quantities_part(outcome)); }
  Section exhibits = exhibits_of({outcome.figures.begin(), outcome.figures.end()});
  exhibits.style = outcome.figures.size() > 4 ? "many" : "";
  exhibits.parts.insert(exhibits.parts.end(), outcome.tables.begin(), outcome.tables.end());
  if (!outcome.timings.empty()) { exhibits.parts.emplace_back(cost_table(outcome)); }
  section.parts.emplace_back(std::move(exhibits));
  return section;
}

struct Suite {
  std::string name{};
  std::vector<const Outcome*> outcomes{};
};

/// Sorts errors and failures first, then passes by the fraction of the bound, then skips.
std::vector<const Outcome*> worst_first(const std::vector<Outcome>& outcomes) {
  std::vector<const Outcome*> order;
  for (const Outcome& outcome : outcomes) { order.push_back(&outcome); }
  const auto rank = [](const Outcome* outcome) {
    const Quantity* tight = tightest_quantity(*outcome);
    const double share = tight == nullptr || met_exactly(*tight) ? 0.0 : share_of_bound(*tight);
    switch (outcome->status) {
      case Status::error: return std::pair(0, 0.0);
      case Status::fail: return std::pair(1, -share);
      case Status::inconclusive: return std::pair(2, -share);
      case Status::pass: return std::pair(3, -share);
      case Status::skip: break;
    }
    return std::pair(4, 0.0);
  };
  std::ranges::stable_sort(order, {}, rank);
  return order;
}

/// Row of the table of cases. A full bar means that the bound is reached.
Data case_values(const Outcome* of_case) {
  const Outcome& outcome = *of_case;
  const Quantity* q = tightest_quantity(outcome);
  Data tightest(false);
  if (q != nullptr && outcome.status != Status::skip && outcome.status != Status::error) {
    const double share = met_exactly(*q) ? 0.0 : std::min(1.0, share_of_bound(*q));
    tightest = quantity_values(*q);
    add_names(tightest, "over", !q->holds(), "width",
              plain_number(std::round(1000.0 * share) / 10.0));
  }
  Data more(false);
  if (outcome.quantities.size() > 1) {
    more = record("count", std::to_string(outcome.quantities.size()), "table",
                  html_quantities(outcome));
  }
  return record("name", outcome.name, "status", status_text(outcome), "badge",
                html_badge({outcome.status}), "anchor", case_anchor(outcome.name), "claim",
                outcome.claim, "reason", outcome.reason(), "tightest", tightest, "more", more);
}

Data buttons_of(const Tally& sum) {
  Data buttons(Data::type::list);
  const auto add = [&buttons](const char* status, const char* label, int count) {
    buttons.push_back(record("status", status, "label", label, "count", std::to_string(count),
                             "pressed", *status == '\0' ? "true" : "false"));
  };
  add("", "all", sum.all());
  add("fail", "failed", sum.failed);
  if (sum.inconclusive > 0) { add("inconclusive", "inconclusive", sum.inconclusive); }
  add("error", "errors", sum.errors);
  add("pass", "passed", sum.passed);
  add("skip", "skipped", sum.skipped);
  return buttons;
}

std::string suite_anchor(const Suite& suite) { return "suite" + case_anchor(suite.name).substr(4); }

/// One sentence about each built-in suite; empty for any other.
std::string about_suite(const std::string& name) {
  static const std::map<std::string, std::string> about{
      {"accuracy", "The model compared with closed forms and independent solutions."},
      {"stability",
       "Steps and scenes for which the motion stays bounded, and those for which not."},
      {"haptics", "The requested device force and the force at the hand."},
      {"clinical", "The model compared with recordings of patients."},
      {"timing", "The cost of a step, and whether it ends in time."},
      {"model", "The laws that the model is built on."}};
  const auto found = about.find(name);
  return found == about.end() ? std::string() : found->second;
}

/// Summary of the results: "PASS: 61 of 61 cases hold; 2 skipped".
std::string verdict_text(const Tally& sum) {
  const std::string skipped =
      sum.skipped == 0 ? "" : "; " + std::to_string(sum.skipped) + " skipped";
  if (sum.ran() == 0) { return "FAIL: no case ran" + skipped; }
  if (sum.holds()) {
    return "PASS: " + std::to_string(sum.passed) + " of " +
           counted(sum.ran(), "case holds", "cases hold") + skipped;
  }
  return "FAIL: " + std::to_string(sum.not_passed()) + " of " +
         counted(sum.ran(), "case falls short", "cases fall short") + skipped;
}

Data suite_values(const Suite& suite) {
  Tally sum;
  double seconds = 0.0;
  for (const Outcome* outcome : suite.outcomes) {
    sum.add(outcome->status);
    seconds += outcome->seconds;
  }
  return record("name", suite.name, "colour",
                sum.not_passed() > 0 ? "fail"
                : sum.passed > 0     ? "pass"
                                     : "skip",
                "anchor", suite_anchor(suite), "passed", std::to_string(sum.passed), "ran",
                std::to_string(sum.ran()), "skipped",
                sum.skipped > 0 ? Data(std::to_string(sum.skipped)) : Data(false), "seconds",
                short_number(seconds, 2));
}

/// Splits a case name: "oscillator/order/rk4" into "oscillator/order" and "rk4".
std::pair<std::string, std::string> split_name(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  if (slash == std::string::npos) { return {"", name}; }
  return {name.substr(0, slash), name.substr(slash + 1)};
}

Data contents_of(const Suite& suite) {
  std::vector<std::pair<std::string, Data>> groups;  // group name, links
  for (const Outcome* outcome : suite.outcomes) {
    const auto [parent, leaf] = split_name(outcome->name);
    auto group = std::ranges::find(groups, parent, &std::pair<std::string, Data>::first);
    if (group == groups.end()) {
      group = groups.insert(groups.end(), {parent, Data(Data::type::list)});
    }
    group->second.push_back(record("leaf", leaf, "status", status_text(*outcome), "anchor",
                                   case_anchor(outcome->name)));
  }
  const auto values = [](const auto& group) {
    return record("name", group.first, "links", group.second);
  };
  return record("name", suite.name, "anchor", suite_anchor(suite), "groups",
                data_of(groups, values));
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
  add(sum.inconclusive, "inconclusive");
  add(sum.errors, "ended in an error");
  add(sum.skipped, "skipped, each with its reason");
  return text + "; " + quantities + ".";
}

Section suite_section(const Suite& suite) {
  Section section{.kind = Section::Kind::section,
                  .heading = capitalised(suite.name),
                  .id = suite_anchor(suite)};
  if (const std::string about = about_suite(suite.name); !about.empty()) {
    section.parts.emplace_back(Paragraph{about});
  }
  for (const Outcome* outcome : suite.outcomes) {
    section.parts.emplace_back(case_section(*outcome));
  }
  return section;
}

}  // namespace

double share_of_bound(const Quantity& q) {
  if (std::isnan(q.value)) { return unbounded; }
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  double share = std::isfinite(q.value) ? 0.0 : unbounded;
  if (above && below) {
    const double half = 0.5 * (q.upper - q.lower);
    const double away = std::abs(q.value - 0.5 * (q.upper + q.lower)) + q.uncertainty;
    share = half > 0.0 ? away / half : unbounded;
  } else if (below) {
    share = share_of_upper(q.value + q.uncertainty, q.upper);
  } else if (above) {
    share = share_of_upper(q.uncertainty - q.value, -q.lower);
  }
  // Rounding must not make the displayed fraction contradict the verdict.
  return q.holds() ? std::min(share, 1.0) : std::max(share, std::nextafter(1.0, 2.0));
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

std::string to_html(const Results& results) {
  const Tally sum = tally(results.outcomes);
  std::vector<Suite> suites;
  for (const Outcome& outcome : results.outcomes) {
    auto found = std::ranges::find(suites, outcome.suite, &Suite::name);
    if (found == suites.end()) { found = suites.insert(suites.end(), {.name = outcome.suite}); }
    found->outcomes.push_back(&outcome);
  }
  const std::string version = entry(results.provenance, "version");
  Page page{
      .banner = {.title = results.title,
                 .small_print = {results.command, entry(results.provenance, "date"),
                                 version.empty() ? "" : "version " + version,
                                 entry(results.provenance, "commit")},
                 .status = sum.holds() ? Status::pass : Status::fail,
                 .verdict = verdict_text(sum),
                 .detail = detail_text(results.outcomes, sum)},
      .parts = {Markup{fill(templates::suites, record("suites", data_of(suites, suite_values)))},
                Markup{fill(templates::cases,
                            record("buttons", buttons_of(sum), "cases",
                                   data_of(worst_first(results.outcomes), case_values)))},
                Markup{fill(templates::contents, record("suites", data_of(suites, contents_of)))}},
      .provenance = facts_of_map(results.provenance),
      .command = results.command,
      .scripts = {std::string(assets::report_js)}};
  for (const Suite& suite : suites) { page.parts.emplace_back(suite_section(suite)); }
  return render(page);
}

}  // namespace palpate

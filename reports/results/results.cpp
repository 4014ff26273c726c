// SPDX-License-Identifier: MIT

#include "reports/results/results.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "html_templates.hpp"

#include "reports/html/html_template.hpp"
#include "validation/number_text.hpp"

namespace palpate {

Results without_what_varies(Results results) {
  results.provenance.clear();
  for (Outcome& outcome : results.outcomes) {
    outcome.seconds = 0.0;
    outcome.timings.clear();
    std::erase_if(outcome.tables, [](const Table& table) { return table.timing; });
    std::erase_if(outcome.figures, [](const Figure& figure) { return figure.timing; });
  }
  return results;
}

namespace {

std::string seconds_attribute(double seconds) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3f", seconds);
  return buffer.data();
}

std::string counts(const std::vector<const Outcome*>& outcomes) {
  Tally sum;
  double seconds = 0.0;
  for (const Outcome* outcome : outcomes) {
    sum.add(outcome->status);
    seconds += outcome->seconds;
  }
  return " tests=\"" + std::to_string(sum.all()) + "\" failures=\"" +
         std::to_string(sum.failed + sum.inconclusive) + "\" errors=\"" +
         std::to_string(sum.errors) + "\" skipped=\"" + std::to_string(sum.skipped) + "\" time=\"" +
         seconds_attribute(seconds) + "\"";
}

std::string failed_quantities(const Outcome& outcome) {
  std::string text = outcome.reason();
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged() || q.holds()) { continue; }
    text += (text.empty() ? "" : "\n") + q.name + " = " + exact_number(q.value) + " " + q.unit +
            "; allowed " + exact_number(q.lower) + " to " + exact_number(q.upper) + " (" +
            q.bound_from + ")";
  }
  return text;
}

Data properties_of(const Outcome& outcome) {
  Data list(Data::type::list);
  const auto property = [&list](const std::string& name, const std::string& value) {
    list.push_back(record("name", name, "value", value));
  };
  for (const Quantity& q : outcome.quantities) {
    property(q.name, exact_number(q.value));
    property(q.name + ".unit", q.unit);
    if (!q.judged()) { continue; }
    property(q.name + ".lower", exact_number(q.lower));
    property(q.name + ".upper", exact_number(q.upper));
    property(q.name + ".bound_from", q.bound_from);
    if (q.uncertainty > 0.0) { property(q.name + ".uncertainty", exact_number(q.uncertainty)); }
  }
  return list;
}

Data case_of(const Outcome* of_case) {
  const Outcome& outcome = *of_case;
  const std::string message = failed_quantities(outcome);
  const bool inconclusive = outcome.status == Status::inconclusive;
  return record(
      "suite", outcome.suite, "name", outcome.name, "time", seconds_attribute(outcome.seconds),
      "judged", !outcome.quantities.empty(), "properties", properties_of(outcome), "skip",
      outcome.status == Status::skip, "failure", outcome.status == Status::fail || inconclusive,
      "error", outcome.status == Status::error, "type", inconclusive ? "inconclusive" : "bound",
      "claim", outcome.claim, "first", message.substr(0, message.find('\n')), "message", message);
}

}  // namespace

std::string to_junit(const Results& results) {
  std::vector<std::pair<std::string, std::vector<const Outcome*>>> suites;
  std::vector<const Outcome*> all;
  for (const Outcome& outcome : results.outcomes) {
    auto suite =
        std::ranges::find(suites, outcome.suite, [](const auto& each) { return each.first; });
    if (suite == suites.end()) { suite = suites.insert(suite, {outcome.suite, {}}); }
    suite->second.push_back(&outcome);
    all.push_back(&outcome);
  }
  const auto values = [](const auto& suite) {
    return record("name", suite.first, "counts", counts(suite.second), "cases",
                  data_of(suite.second, case_of));
  };
  return fill(templates::junit, record("title", results.title, "counts", counts(all), "suites",
                                       data_of(suites, values)));
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "reports/results/results.hpp"

#include <array>
#include <cstdio>

#include "reports/html/html_page.hpp"

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

std::string verdict(const Outcome& outcome) {
  const std::string message = escape_markup(failed_quantities(outcome));
  switch (outcome.status) {
    case Status::pass: return {};
    case Status::skip: return "      <skipped message=\"" + message + "\"/>\n";
    case Status::fail:
    case Status::inconclusive:
      return "      <failure type=\"" +
             std::string(outcome.status == Status::fail ? "bound" : "inconclusive") +
             "\" message=\"" + message.substr(0, message.find('\n')) + "\">" +
             escape_markup(outcome.claim) + "\n" + message + "</failure>\n";
    case Status::error: break;
  }
  return "      <error type=\"exception\" message=\"" + message + "\"/>\n";
}

std::string properties(const Outcome& outcome) {
  if (outcome.quantities.empty()) { return {}; }
  std::string text = "      <properties>\n";
  const auto property = [&text](const std::string& name, const std::string& value) {
    text += "        <property name=\"" + escape_markup(name) + "\" value=\"" +
            escape_markup(value) + "\"/>\n";
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
  return text + "      </properties>\n";
}

}  // namespace

std::string to_junit(const Results& results) {
  std::vector<std::string> suites;
  std::map<std::string, std::vector<const Outcome*>> members;
  std::vector<const Outcome*> all;
  for (const Outcome& outcome : results.outcomes) {
    if (members[outcome.suite].empty()) { suites.push_back(outcome.suite); }
    members[outcome.suite].push_back(&outcome);
    all.push_back(&outcome);
  }
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"" +
                    escape_markup(results.title) + "\"" + counts(all) + ">\n";
  for (const std::string& suite : suites) {
    xml += "  <testsuite name=\"" + escape_markup(suite) + "\"" + counts(members[suite]) + ">\n";
    for (const Outcome* outcome : members[suite]) {
      xml += "    <testcase classname=\"palpate." + escape_markup(suite) + "\" name=\"" +
             escape_markup(outcome->name) + "\" time=\"" + seconds_attribute(outcome->seconds) +
             "\">\n" + properties(*outcome) + verdict(*outcome) + "    </testcase>\n";
    }
    xml += "  </testsuite>\n";
  }
  return xml + "</testsuites>\n";
}

}  // namespace palpate

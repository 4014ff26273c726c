// SPDX-License-Identifier: MIT
#include "reports/html_report.hpp"

#include "reports/run_report.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

Trace short_trace() {
  Trace trace{.time = {0.0, 0.1, 0.2}};
  trace.columns = {{"tip</script>.x_m", "m", {1.0, 1.1, std::nan("")}}, {"tip</script>.y_m", "m", {0.0, 0.0, 0.0}}};
  return trace;
}

}  // namespace

TEST("a report makes no request and escapes what it shows") {
  for (const std::string& html : {to_html(sample::results()), to_html(RunReport{.title = "<run>"}, short_trace())}) {
    for (const char* request : {"src=\"http", "href=\"http", "url(http", "@import", "sourceMappingURL", "<run>", "<tags>"}) {
      CHECK(!contains(html, request));
    }
  }
}

TEST("the verdict is red when a case fell short and green when all hold") {
  Results results = sample::results();
  CHECK(contains(to_html(results), "class=\"verdict fail\""));
  results.outcomes.resize(1);
  CHECK(contains(to_html(results), "class=\"verdict pass\""));
  results.outcomes.clear();
  CHECK(contains(to_html(results), "class=\"verdict fail\""));
}

TEST("the worst case stands first in the table") {
  const std::string html = to_html(sample::results());
  const auto row = [&](const char* name) { return html.find(name, html.find("<tbody>")); };
  CHECK(row("stability/drift") < row("network/patch-test"));
  CHECK(row("network/patch-test") < row("oscillator/order/rk4"));
}

TEST("the share of a bound is below one exactly when the quantity holds") {
  for (const Quantity& q : {Quantity{.value = 1.0, .lower = 0.5, .upper = 1.2}, Quantity{.value = 1.3, .lower = 0.5, .upper = 1.2},
                            Quantity{.value = 1e-9, .upper = 1e-8}, Quantity{.value = 1e-7, .upper = 1e-8},
                            Quantity{.value = 9.0, .lower = 8.0}, Quantity{.value = 7.0, .lower = 8.0},
                            Quantity{.value = std::nan(""), .upper = 1.0}}) {
    CHECK((share_of_bound(q) <= 1.0) == q.holds());
  }
}

TEST("the same results give the same bytes") { CHECK(to_html(sample::results()) == to_html(sample::results())); }

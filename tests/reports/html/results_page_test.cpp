// SPDX-License-Identifier: MIT

#include <cmath>
#include <regex>
#include <set>

#include "reports/html/html_page.hpp"
#include "reports/results/results.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

namespace {

using namespace palpate;

TEST("the share of a bound is at most one exactly when the quantity holds") {
  const double values[] = {-9.0,        -1.0, -1e-300, 0.0,       1e-12,
                           0.5,         0.85, 0.95,    1.0,       std::nextafter(1.2, 2.0),
                           1.2,         1.3,  9.0,     unbounded, -unbounded,
                           std::nan("")};
  const double bounds[][2] = {
      {0.5, 1.2},       {-unbounded, 1e-8}, {-unbounded, -1.0},     {-unbounded, 0.0},
      {8.0, unbounded}, {-2.0, unbounded},  {0.0, unbounded},       {1.0, 1.0},
      {0.85, 1.15},     {-1e-300, 1.2},     {-unbounded, unbounded}};
  for (const double value : values) {
    for (const auto& [lower, upper] : bounds) {
      const Quantity q{.value = value, .lower = lower, .upper = upper, .bound_from = "theory"};
      CHECK((share_of_bound(q) <= 1.0) == q.holds());
    }
  }
}

TEST("a bound below zero is used up by values that come near it") {
  CHECK_NEAR(share_of_bound({.value = -24.53, .upper = -1.0}), 1.0 / 24.53, 1e-15);
  CHECK_NEAR(share_of_bound({.value = -1.0, .lower = -2.0}), 0.5, 1e-15);
  CHECK_NEAR(share_of_bound({.value = 3.0, .lower = -2.0}), 0.0, 1e-15);
  CHECK(share_of_bound({.value = -3.0, .upper = 0.0}) == 0.0);
  CHECK(share_of_bound({.value = 0.0, .upper = 0.0}) == 1.0);
}

TEST(
    "the share of a bound counts the uncertainty, so an inconclusive quantity uses more than all") {
  const Quantity near{.value = 0.9, .upper = 1.0, .bound_from = "theory", .uncertainty = 0.2};
  CHECK(near.status() == Status::inconclusive);
  CHECK_NEAR(share_of_bound(near), 1.1, 1e-15);
}

TEST("a count that is met says nothing about how near another quantity is") {
  Outcome outcome;
  outcome.judge({.name = "cases found", .value = 9.0, .lower = 9.0});
  outcome.judge({.name = "error", .value = 0.3, .upper = 1.0});
  CHECK(tightest_quantity(outcome)->name == "error");
  outcome.judge({.name = "cases lost", .value = 1.0, .upper = 0.0});
  CHECK(tightest_quantity(outcome)->name == "cases lost");
  outcome.judge({.name = "nothing", .value = std::nan(""), .upper = 1.0});
  CHECK(tightest_quantity(outcome)->name == "nothing");
}

TEST("a value and a bound that differ never read the same") {
  const Quantity q{.value = 6.0205999131, .unit = "dB", .lower = 6.0205999128};
  CHECK(measured_text(q) != allowed_text(q).substr(4));
  CHECK(allowed_text(q).starts_with("≥ 6.02059991"));
  CHECK(allowed_text({.value = 1.0, .lower = 1.0, .upper = 1.0}) == "= 1");
}

TEST("text cannot leave the place it is put into") {
  CHECK(escape_markup("<a b='c' d=\"e\"> & \x01") ==
        "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt; &amp; ?");
  CHECK(escape_markup("µ ω 10⁻³") == "µ ω 10⁻³");
  CHECK(escape_markup("a\xff\xc3") == "a\ufffd\ufffd");
}

std::vector<std::string> all_matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator each(text.begin(), text.end(), expression), end; each != end; ++each) {
    found.push_back((*each)[1]);
  }
  return found;
}

TEST("a report makes no request and escapes what it shows") {
  const std::string html = to_html(sample::results());
  for (const char* request : {"src=\"http", "href=\"http", "url(http", "@import",
                              "sourceMappingURL", "<tags>", "<fast>", "<over>"}) {
    CHECK(!check::contains(html, request));
  }
}

TEST("the verdict comes first, red when a case fell short and green when all hold") {
  Results results = sample::results();
  CHECK_CONTAINS(
      to_html(results),
      "class=\"verdict fail\" role=\"status\"><strong>FAIL: 2 of 3 cases fall short; 1 skipped<");
  results.outcomes.resize(1);
  CHECK_CONTAINS(to_html(results),
                 "class=\"verdict pass\" role=\"status\"><strong>PASS: 1 of 1 case holds<");
  results.outcomes.clear();
  CHECK_CONTAINS(to_html(results), "<strong>FAIL: no case ran<");
}

TEST("the worst case stands first in the table") {
  const std::string html = to_html(sample::results());
  const auto row = [&](const char* name) { return html.find(name, html.find("<tbody")); };
  CHECK(row("stability/drift") < row("network/patch-test"));
  CHECK(row("network/patch-test") < row("oscillator/order/rk4"));
  CHECK(row("oscillator/order/rk4") < row("patient/lumbar"));
}

TEST("cases that hold are sorted by the share of the bound that they use") {
  Results results;
  const auto add = [&results](const char* name, Quantity quantity) {
    Outcome outcome{.name = name, .suite = "accuracy", .claim = "It holds."};
    outcome.judge(std::move(quantity));
    conclude(outcome);
    results.outcomes.push_back(std::move(outcome));
  };
  add("far-below", {.name = "log10 of growth", .value = -24.53, .upper = -1.0});
  add("near", {.name = "error", .value = 0.9, .upper = 1.0});
  add("between", {.name = "error", .value = 0.5, .upper = 1.0});
  const std::string html = to_html(results);
  const auto row = [&](const char* name) { return html.find(name, html.find("<tbody")); };
  CHECK(row("near") < row("between"));
  CHECK(row("between") < row("far-below"));
}

TEST("every link leads to one place on the page") {
  const std::string html = to_html(sample::results());
  const std::vector<std::string> ids = all_matches(html, " id=\"([^\"]*)\"");
  const std::set<std::string> unique(ids.begin(), ids.end());
  CHECK(unique.size() == ids.size());
  for (const std::string& target : all_matches(html, "href=\"#([^\"]*)\"")) {
    CHECK(unique.contains(target));
  }
}

TEST("every class that a figure uses is in the style sheet") {
  const std::string html = to_html(sample::results());
  for (const std::string& classes : all_matches(html, "<path class=\"([^\"]*)\"")) {
    for (const std::string& one : all_matches(classes, "([a-z0-9]+)")) {
      CHECK_CONTAINS(html, "." + one + " {");
    }
  }
}

TEST("a skipped case and an error say why") {
  const std::string html = to_html(sample::results());
  CHECK_CONTAINS(html, "the folder lumbar_network is absent");
  CHECK_CONTAINS(html, "solver: flag -4");
}

TEST("the same results give the same bytes") {
  CHECK(to_html(sample::results()) == to_html(sample::results()));
}

}  // namespace

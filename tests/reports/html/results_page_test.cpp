// SPDX-License-Identifier: MIT

#include <regex>
#include <set>

#include "reports/html/html_page.hpp"
#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

namespace PALPATE_FILE {

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

TEST("the share of a bound has its closed form, also below zero and with an uncertainty") {
  CHECK_NEAR(share_of_bound({.value = -24.53, .upper = -1.0}), 1.0 / 24.53, 1e-15);
  CHECK_NEAR(share_of_bound({.value = -1.0, .lower = -2.0}), 0.5, 1e-15);
  CHECK_NEAR(share_of_bound({.value = 3.0, .lower = -2.0}), 0.0, 1e-15);
  CHECK(share_of_bound({.value = -3.0, .upper = 0.0}) == 0.0);
  CHECK(share_of_bound({.value = 0.0, .upper = 0.0}) == 1.0);
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

TEST("a value and a bound that differ have different texts") {
  const Quantity q{.value = 6.0205999131, .unit = "dB", .lower = 6.0205999128};
  CHECK(measured_text(q) != allowed_text(q).substr(4));
  CHECK(allowed_text(q).starts_with("≥ 6.02059991"));
  CHECK(allowed_text({.value = 1.0, .lower = 1.0, .upper = 1.0}) == "= 1");
}

TEST("markup in text is escaped, and invalid bytes are replaced") {
  CHECK(escape_markup("<a b='c' d=\"e\"> & \x01") ==
        "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt; &amp; ?");
  CHECK(escape_markup("µ ω 10⁻³") == "µ ω 10⁻³");
  CHECK(escape_markup("a\xff\xc3") == "a\ufffd\ufffd");
  CHECK(escape_markup("a\uffff\ufffe") == "a\ufffd\ufffd");  // no characters of XML
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
  CHECK_LACKS(to_html(sample::results()), "src=\"http", "href=\"http", "url(http", "@import",
              "sourceMappingURL", "<tags>", "<fast>", "<over>");
}

TEST("the verdict comes first, red if a case fails and green if all hold") {
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

TEST("the worst case is first in the table; cases that hold are sorted by the used share") {
  const auto table = [](const Results& shown) {
    const std::string html = to_html(shown);
    return html.substr(html.find("<tbody"));
  };
  CHECK_ORDER(table(sample::results()), "stability/drift", "network/patch-test",
              "oscillator/order/rk4", "patient/lumbar");
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
  CHECK_ORDER(table(results), "near", "between", "far-below");
}

TEST("links and classes are defined, a skipped case and an error say why, and bytes are the same") {
  const std::string html = to_html(sample::results());
  const std::vector<std::string> ids = all_matches(html, " id=\"([^\"]*)\"");
  const std::set<std::string> unique(ids.begin(), ids.end());
  CHECK(unique.size() == ids.size());
  for (const std::string& target : all_matches(html, "href=\"#([^\"]*)\"")) {
    CHECK(unique.contains(target));
  }
  for (const std::string& classes : all_matches(html, "<path class=\"([^\"]*)\"")) {
    for (const std::string& one : all_matches(classes, "([a-z0-9]+)")) {
      CHECK_CONTAINS(html, "." + one + " {");
    }
  }
  CHECK_CONTAINS(html, "the folder lumbar_network is absent", "solver: flag -4");
  CHECK(to_html(sample::results()) == to_html(sample::results()));
}

}  // namespace PALPATE_FILE

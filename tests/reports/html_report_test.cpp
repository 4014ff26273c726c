// SPDX-License-Identifier: MIT
#include "reports/html_report.hpp"

#include <regex>
#include <set>

#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

std::vector<std::string> all_matches(const std::string& text, const char* pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator each(text.begin(), text.end(), expression), end; each != end; ++each) {
    found.push_back((*each)[1]);
  }
  return found;
}

}  // namespace

TEST("a report makes no request and escapes what it shows") {
  const std::string html = to_html(sample::results());
  for (const char* request : {"src=\"http", "href=\"http", "url(http", "@import",
                              "sourceMappingURL", "<tags>", "<fast>", "<over>"}) {
    CHECK(!contains(html, request));
  }
}

TEST("the verdict comes first, red when a case fell short and green when all hold") {
  Results results = sample::results();
  CHECK(contains(
      to_html(results),
      "class=\"verdict fail\" role=\"status\"><strong>FAIL: 2 of 3 cases fall short; 1 skipped<"));
  results.outcomes.resize(1);
  CHECK(contains(to_html(results),
                 "class=\"verdict pass\" role=\"status\"><strong>PASS: 1 of 1 case holds<"));
  results.outcomes.clear();
  CHECK(contains(to_html(results), "<strong>FAIL: no case ran<"));
}

TEST("the worst case stands first in the table") {
  const std::string html = to_html(sample::results());
  const auto row = [&](const char* name) { return html.find(name, html.find("<tbody")); };
  CHECK(row("stability/drift") < row("network/patch-test"));
  CHECK(row("network/patch-test") < row("oscillator/order/rk4"));
  CHECK(row("oscillator/order/rk4") < row("patient/lumbar"));
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
      CHECK(contains(html, "." + one + " {"));
    }
  }
}

TEST("a skipped case and an error say why") {
  const std::string html = to_html(sample::results());
  CHECK(contains(html, "the folder lumbar_network is absent") && contains(html, "solver: flag -4"));
}

TEST("the same results give the same bytes") {
  CHECK(to_html(sample::results()) == to_html(sample::results()));
}

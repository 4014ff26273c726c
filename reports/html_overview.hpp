// SPDX-License-Identifier: MIT
#pragma once
/// What a reader needs before any detail: the verdict, suite by suite, and every case on one line
/// with the worst first.

#include <string>
#include <vector>

#include "reports/results.hpp"

namespace palpate {

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

}  // namespace palpate

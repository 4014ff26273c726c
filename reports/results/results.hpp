// SPDX-License-Identifier: MIT
#pragma once
/// Everything a command found, as data: results.json, results.xml, traces/ and report.html are
/// written from one Results and from nothing else.

#include <map>
#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

struct Results {
  std::string title{};
  std::string command{};
  std::map<std::string, std::string> provenance{};
  std::vector<Outcome> outcomes{};
};

/// How many outcomes there are of each status.
struct Tally {
  int passed = 0;
  int failed = 0;
  int errors = 0;
  int skipped = 0;

  [[nodiscard]] int all() const { return passed + failed + errors + skipped; }
  /// Every check that ran holds, and at least one ran.
  [[nodiscard]] bool holds() const { return failed == 0 && errors == 0 && passed > 0; }
};
Tally tally(const std::vector<Outcome>& outcomes);

/// The same without what may differ between two runs of one program on one input: seconds,
/// timings, provenance, and the tables and figures that show run times.
Results without_what_varies(Results results);

// results.xml: JUnit as CI servers read it, with every quantity as a property of its case.

std::string to_junit(const Results& results);

}  // namespace palpate

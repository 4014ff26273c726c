// SPDX-License-Identifier: MIT
#pragma once
/// The outcomes of a command as data. results.json, results.xml, traces/ and report.html are
/// written from it alone.

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

/// The same without what may differ between two runs of one program on one input: seconds,
/// timings, provenance, and the tables and figures that show run times.
Results without_what_varies(Results results);

// results.xml: JUnit as CI servers read it, with every quantity as a property of its case.

std::string to_junit(const Results& results);

}  // namespace palpate

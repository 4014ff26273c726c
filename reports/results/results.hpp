// SPDX-License-Identifier: MIT
#pragma once
/// Outcomes of a command as data. It is the only source for results.json, results.xml, traces/ and
/// report.html.

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

/// Returns the results without the data that differ between two runs of one program on one input:
/// seconds, timings, provenance, and tables and figures of run times.
Results without_what_varies(Results results);

// results.xml in JUnit format for CI servers, with every quantity as a property of its case.

std::string to_junit(const Results& results);

}  // namespace palpate

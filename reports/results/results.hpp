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

/// Returns an entry of a provenance; empty if it has none.
inline std::string entry(const std::map<std::string, std::string>& provenance,
                         const std::string& key) {
  const auto found = provenance.find(key);
  return found == provenance.end() ? std::string() : found->second;
}

/// Returns the results without the data that differ between two runs of one program on one input:
/// seconds, timings, provenance, and tables and figures of run times.
Results without_what_varies(Results results);

// results.xml in JUnit format for CI servers, with every quantity as a property of its case.

std::string to_junit(const Results& results);

/// Fraction of the bound that a quantity uses, including its uncertainty: at most 1 exactly if the
/// quantity passes. For an interval, the distance from its midpoint over half its width. Infinite
/// for NaN.
double share_of_bound(const Quantity& quantity);

/// Returns the judged quantity with the largest violation of its bound, else the one closest to its
/// bound; quantities that are met exactly come last. Returns nullptr if none is judged.
const Quantity* tightest_quantity(const Outcome& outcome);

/// Bound and measured value as displayed text: "≤ 0.002 m", "0.85 to 1.15", "= 0", "finite".
std::string allowed_text(const Quantity& quantity);
std::string measured_text(const Quantity& quantity);

/// Returns one outcome that compares simulators on the same cases: verdicts, coverage, and the cost
/// at equal error of S26. Each element is the results of one subject; its name is the entry
/// "subject" of the provenance, and the model of this project has none.
Results subject_matrix(const std::vector<Results>& subjects);

/// Returns report.html. Output is deterministic: the same results give the same bytes.
std::string to_html(const Results& results);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/results.hpp"

namespace palpate {

Tally tally(const std::vector<Outcome>& outcomes) {
  Tally sum;
  for (const Outcome& outcome : outcomes) {
    switch (outcome.status) {
      case Status::pass:
        ++sum.passed;
        break;
      case Status::fail:
        ++sum.failed;
        break;
      case Status::skip:
        ++sum.skipped;
        break;
      case Status::error:
        ++sum.errors;
        break;
    }
  }
  return sum;
}

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

}  // namespace palpate

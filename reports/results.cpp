// SPDX-License-Identifier: MIT
#include "reports/results.hpp"

namespace palpate {

Tally tally(const std::vector<Outcome>& outcomes) {
  Tally sum;
  for (const Outcome& outcome : outcomes) {
    switch (outcome.status) {
      case Status::pass: ++sum.passed; break;
      case Status::fail: ++sum.failed; break;
      case Status::skip: ++sum.skipped; break;
      case Status::error: ++sum.errors; break;
    }
  }
  return sum;
}

}  // namespace palpate

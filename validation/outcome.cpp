// SPDX-License-Identifier: MIT

#include "validation/outcome.hpp"

#include <algorithm>

namespace palpate {

std::string_view name_of(Status status) {
  switch (status) {
    case Status::pass: return "pass";
    case Status::fail: return "fail";
    case Status::skip: return "skip";
    case Status::error: break;
  }
  return "error";
}

void conclude(Outcome& outcome) {
  if (outcome.status == Status::skip || outcome.status == Status::error) { return; }
  const auto judged = std::ranges::count_if(outcome.quantities, &Quantity::judged);
  const bool all_hold = std::ranges::all_of(
      outcome.quantities, [](const Quantity& q) { return !q.judged() || q.holds(); });
  outcome.status = judged > 0 && all_hold ? Status::pass : Status::fail;
  if (judged == 0) { outcome.reason = "nothing was judged"; }
}

}  // namespace palpate

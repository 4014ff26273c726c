// SPDX-License-Identifier: MIT
#include "reports/margin.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "reports/markup.hpp"

namespace palpate {

namespace {

std::string unit_text(const std::string& unit) {
  return unit == "1" || unit.empty() ? "" : "\u00a0" + unit;
}

/// Measured value and bounds must not read the same when they differ.
int digits_of(const Quantity& q) {
  return std::max({digits_apart(q.value, q.lower), digits_apart(q.value, q.upper),
                   digits_apart(q.lower, q.upper)});
}

}  // namespace

double share_of_bound(const Quantity& q) {
  if (std::isnan(q.value)) { return unbounded; }
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  const double met = q.holds() ? 1.0 : unbounded;  // where no share can be told
  if (above && below) {
    const double half = 0.5 * (q.upper - q.lower);
    const double away = std::abs(q.value - 0.5 * (q.upper + q.lower));
    if (!(half > 0.0)) { return met; }
    // Rounding must not let a share contradict the verdict.
    return q.holds() ? std::min(away / half, 1.0) : std::max(away / half, std::nextafter(1.0, 2.0));
  }
  if (below) { return q.upper > 0.0 ? std::max(0.0, q.value / q.upper) : met; }
  if (above) { return q.value > 0.0 ? std::max(0.0, q.lower / q.value) : met; }
  return std::isfinite(q.value) ? 0.0 : met;
}

bool met_exactly(const Quantity& q) {
  return q.holds() && (q.value == q.lower || q.value == q.upper) && q.value == std::round(q.value);
}

const Quantity* tightest_quantity(const Outcome& outcome) {
  const Quantity* tightest = nullptr;
  const auto rank = [](const Quantity& q) {
    return std::tuple(!q.holds(), std::isnan(q.value), !met_exactly(q), share_of_bound(q));
  };
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged()) { continue; }
    if (tightest == nullptr || rank(q) > rank(*tightest)) { tightest = &q; }
  }
  return tightest;
}

std::string allowed_text(const Quantity& q) {
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  const std::string unit = unit_text(q.unit);
  const int digits = digits_of(q);
  const std::string upper = short_number(q.upper, digits) + unit;
  if (above && below) {
    if (q.lower == q.upper) { return "= " + upper; }
    return short_number(q.lower, digits) + " to " + upper;
  }
  if (below) { return "≤ " + upper; }
  return above ? "≥ " + short_number(q.lower, digits) + unit : "finite";
}

std::string measured_text(const Quantity& q) {
  const std::string number = short_number(q.value, digits_of(q));
  return std::isnan(q.value) ? number : number + unit_text(q.unit);
}

std::string share_text(const Quantity& q) {
  if (std::isnan(q.value)) { return "–"; }
  if (met_exactly(q)) { return "exact"; }
  const double share = share_of_bound(q);
  if (!std::isfinite(share)) { return "beyond"; }
  if (!q.holds()) { return share < 10.0 ? short_number(share, 2) + " times" : "over 10 times"; }
  return share < 0.001 ? "< 0.1\u00a0%"
                       : short_number(100.0 * share, share < 0.1 ? 2 : 3) + "\u00a0%";
}

}  // namespace palpate

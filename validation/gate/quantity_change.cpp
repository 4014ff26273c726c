// SPDX-License-Identifier: MIT
#include "validation/gate/quantity_change.hpp"

#include <algorithm>
#include <cmath>

#include "validation/gate/baseline.hpp"
#include "validation/number_words.hpp"

namespace palpate::gate {

namespace {

std::string bounds_text(const Quantity& q) {
  if (!q.judged()) { return "none"; }
  return plain_number(q.lower, 17) + " to " + plain_number(q.upper, 17);
}

/// A bound that comes from a reference moves with it; one that is widened by hand moves by more.
bool same_bound(double before, double now) {
  return now == before || std::abs(now - before) <= allowed_share * std::abs(before);
}

/// What makes two numbers impossible to hold against each other; empty: nothing.
std::string obstacle(const Quantity& before, const Quantity& now) {
  if (now.unit != before.unit) { return "unit " + now.unit + ", was " + before.unit; }
  if (!same_bound(before.lower, now.lower) || !same_bound(before.upper, now.upper) ||
      now.judged() != before.judged()) {
    return "judged by bounds " + bounds_text(now) + ", was " + bounds_text(before);
  }
  if (!std::isfinite(now.value) && now.value != before.value) { return "is " + plain_number(now.value); }
  if (!std::isfinite(before.value) && now.value != before.value) { return "was " + plain_number(before.value); }
  if (now.judged() && !now.holds() && before.holds()) { return "out of its bounds " + bounds_text(now); }
  return {};
}

/// How far a number is from what its bound wants, to be compared by ratio; NaN where no bound tells.
double distance_from_good(const Quantity& q) {
  const bool above = q.lower > -unbounded;
  const bool below = q.upper < unbounded;
  if (above && below && q.upper > q.lower) {
    const double half = 0.5 * (q.upper - q.lower);
    return std::max(std::abs(q.value - (q.lower + half)) / half, least_offset);
  }
  if (above && below) { return std::abs(q.value - q.upper); }
  if (below) { return std::abs(q.value); }
  if (above && q.value > 0.0) { return 1.0 / q.value; }
  return std::nan("");
}

Change judged(Change change, double worse_by, double allowed, const std::string& unit) {
  const bool grew = !(worse_by <= allowed);
  change.judgement = grew ? Judgement::worse : worse_by < -allowed ? Judgement::better : Judgement::within;
  change.moved = plain_number(std::abs(worse_by), 2) + unit + (worse_by > 0.0 ? " worse" : " better");
  change.allowed = plain_number(allowed, 2) + unit;
  return change;
}

/// Without a good side: any way is out.
Change unguided(Change change) {
  const double scale = std::abs(change.before);
  const double share = std::abs(change.now - change.before) / scale;
  change.judgement = !(share <= allowed_share) ? Judgement::moved : Judgement::within;
  change.moved = plain_number(100.0 * (change.now - change.before) / scale, 2) + " %";
  change.allowed = plain_number(100.0 * allowed_share, 2) + " % either way";
  return change;
}

}  // namespace

std::string_view name_of(Judgement judgement) {
  switch (judgement) {
    case Judgement::same: return "same";
    case Judgement::rounding: return "rounding";
    case Judgement::within: return "within";
    case Judgement::better: return "better";
    case Judgement::worse: return "worse";
    case Judgement::moved: return "moved";
    case Judgement::broken: break;
  }
  return "broken";
}

Change judge_quantity(const Quantity& before, const Quantity& now, double spread) {
  Change change{.item = before.name, .before = before.value, .now = now.value, .unit = before.unit};
  if (std::string problem = obstacle(before, now); !problem.empty()) {
    change.judgement = Judgement::broken;
    change.moved = std::move(problem);
    return change;
  }
  if (now.value == before.value) { return change; }
  if (std::abs(now.value - before.value) <= spread_margin * spread) {
    change.judgement = Judgement::rounding;
    change.moved = plain_number(std::abs(now.value - before.value), 2) + " " + before.unit;
    change.allowed = plain_number(spread_margin * spread, 2) + " " + before.unit;
    return change;
  }
  if (before.unit == "digits") { return judged(change, before.value - now.value, allowed_digits, " digits"); }
  if (is_counted(before.unit)) {
    return judged(change, 100.0 * (now.value / before.value - 1.0), 100.0 * allowed_share, " %");
  }
  const double was = distance_from_good(before);
  const double is = distance_from_good(now);
  if (std::isnan(was) || std::isnan(is)) { return unguided(change); }
  return judged(change, was == is ? 0.0 : std::log10(is / was), allowed_digits, " digits");
}

}  // namespace palpate::gate

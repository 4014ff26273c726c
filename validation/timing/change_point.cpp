// SPDX-License-Identifier: MIT
#include "validation/timing/change_point.hpp"

#include <algorithm>
#include <cmath>

#include "validation/timing/paired_times.hpp"

namespace palpate::timing {

namespace {

double median_of(std::span<const double> values) {
  return median_limits({values.begin(), values.end()}, paired_confidence).median;
}

int sign(double x) { return (x > 0.0 ? 1 : 0) - (x < 0.0 ? 1 : 0); }

bool is_worse(const Trend& trend) {
  const ChangePoint& change = *trend.change;
  if (trend.unit == "digits") { return change.before - change.after > least_loss_of_digits; }
  return change.after > least_growth * change.before;
}

}  // namespace

std::optional<ChangePoint> find_change(std::span<const double> values) {
  const std::size_t n = values.size();
  if (n < 2) { return std::nullopt; }
  long sum = 0;
  long largest = -1;
  ChangePoint change;
  for (std::size_t t = 0; t + 1 < n; ++t) {
    // Value t goes over to the side of the old level.
    for (std::size_t j = 0; j < n; ++j) { sum += sign(values[j] - values[t]); }
    if (std::abs(sum) > largest) {
      largest = std::abs(sum);
      change.at = t + 1;
    }
  }
  const auto count = static_cast<double>(n);
  const auto k = static_cast<double>(largest);
  change.chance = std::min(1.0, 2.0 * std::exp(-6.0 * k * k / (count * count * (count + 1.0))));
  change.before = median_of(values.first(change.at));
  change.after = median_of(values.subspan(change.at));
  return change;
}

void find_creep(std::vector<Trend>& trends) {
  std::vector<Trend*> by_chance;
  for (Trend& trend : trends) {
    trend.change = find_change(trend.values);
    trend.crept = false;
    if (trend.change) { by_chance.push_back(&trend); }
  }
  std::ranges::sort(by_chance, {}, [](const Trend* trend) { return trend->change->chance; });
  for (std::size_t n = 0; n < by_chance.size(); ++n) {
    const auto still_open = static_cast<double>(by_chance.size() - n);
    if (!(by_chance[n]->change->chance <= false_alarm_rate / still_open)) { break; }
    by_chance[n]->crept = is_worse(*by_chance[n]);
  }
}

}  // namespace palpate::timing

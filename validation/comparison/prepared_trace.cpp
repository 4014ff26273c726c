// SPDX-License-Identifier: MIT
#include "validation/comparison/prepared_trace.hpp"

#include <algorithm>
#include <cmath>

#include "validation/comparison/zero_phase.hpp"

namespace palpate::comparison {

std::string refusal_of(const RawTrace& trace) {
  if (trace.value.empty() || trace.time.empty()) { return "is empty"; }
  if (trace.value.size() != trace.time.size()) { return "has more times than values, or fewer"; }
  if (trace.value.size() == 1) { return "has one sample"; }
  for (std::size_t n = 0; n < trace.time.size(); ++n) {
    if (!std::isfinite(trace.time[n]) || (n > 0 && !(trace.time[n] > trace.time[n - 1]))) {
      return "has times that do not increase";
    }
  }
  if (trace.time.back() - trace.time.front() > 1e7 * usual_interval(trace.time)) {
    return "spans more than ten million of its usual intervals";
  }
  const std::vector<double> finite = finite_only(trace.value);
  if (finite.empty()) { return "holds no number"; }
  if (finite.size() < 10) { return "holds fewer than 10 numbers"; }
  const auto [smallest, largest] = std::ranges::minmax(finite);
  if (std::max(largest, -smallest) > largest_value) { return "holds a value beyond 1e100"; }
  if (largest - smallest <= 1e-12 * std::max(std::abs(largest), std::abs(smallest))) { return "is constant"; }
  return {};
}

PreparedTrace prepare(const RawTrace& trace, double cutoff, const FeatureRule& rule) {
  PreparedTrace prepared{.refusal = refusal_of(trace)};
  if (!prepared.refusal.empty()) { return prepared; }
  prepared.input.raw = regular(trace.time, trace.value);
  prepared.input.filtered = zero_phase(prepared.input.raw, cutoff);
  prepared.input.cutoff = cutoff;
  if (trace.depth.size() == trace.time.size() && !finite_only(trace.depth).empty()) {
    prepared.input.depth = regular(trace.time, trace.depth);
  }
  if (longest_stretch(prepared.input.raw.value).size() < 3) {
    prepared.refusal = "has no three samples without a gap";
    return prepared;
  }
  prepared.features = find_features(prepared.input, rule);
  return prepared;
}

}  // namespace palpate::comparison

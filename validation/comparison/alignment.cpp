// SPDX-License-Identifier: MIT
#include "validation/comparison/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace palpate::comparison {

namespace {

/// When a depth is first reached [s]; absent where that is hidden by a gap, or came before the first sample.
std::optional<double> time_at_depth(const Samples& depth, double wanted) {
  for (std::size_t n = 0; n < depth.size(); ++n) {
    if (!(depth.value[n] >= wanted)) { continue; }
    if (depth.value[n] == wanted) { return depth.time(n); }
    if (n == 0 || !std::isfinite(depth.value[n - 1])) { return std::nullopt; }
    const double share = (wanted - depth.value[n - 1]) / (depth.value[n] - depth.value[n - 1]);
    return depth.time(n - 1) + share * depth.step;
  }
  return std::nullopt;
}

std::optional<double> depth_of_event(const Features& features) {
  const Measured& loss = features[Feature::depth_of_loss];
  return loss.value ? loss.value : features[Feature::depth_of_peak].value;
}

Alignment by_depth(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  Alignment alignment{.used = AlignmentRule::depth};
  const std::vector<double> r = finite_only(recorded.input.depth.value);
  const std::vector<double> s = finite_only(simulated.input.depth.value);
  if (r.empty() || s.empty()) {
    alignment.refusal = r.empty() ? "the recording has no depth" : "the simulated trace has no depth";
    return alignment;
  }
  const double low = std::max(std::ranges::min(r), std::ranges::min(s));
  const double high = std::min(std::ranges::max(r), std::ranges::max(s));
  if (!(high > low)) {
    alignment.refusal = "recorded and simulated depths do not meet";
    return alignment;
  }
  double depth = depth_of_event(recorded.features).value_or(high + 1.0);
  const bool reached = depth <= high && depth >= low;
  if (!reached) { depth = 0.5 * (low + high); }
  const auto at_r = time_at_depth(recorded.input.depth, depth);
  const auto at_s = time_at_depth(simulated.input.depth, depth);
  char text[64];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * depth);
  if (!at_r || !at_s) {
    alignment.refusal = std::string("a gap hides when the ") + (at_r ? "simulated" : "recorded") +
                        " tip reached " + text;
    return alignment;
  }
  alignment.how = std::string("by the depth of ") + text +
                  (reached ? ", that of the recorded event" : ", the middle of what both passed");
  alignment.lag = *at_r - *at_s;
  alignment.uncertainty = std::hypot(recorded.input.depth.step, simulated.input.depth.step) / std::sqrt(12.0);
  return alignment;
}

Alignment by_event(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  Alignment alignment{.used = AlignmentRule::event, .how = "by the loss of resistance"};
  const Measured* r = &recorded.features[Feature::time_of_loss];
  const Measured* s = &simulated.features[Feature::time_of_loss];
  if (!r->value || !s->value) {
    alignment.how = "by the peak, as not both show a loss of resistance";
    r = &recorded.features[Feature::time_of_peak];
    s = &simulated.features[Feature::time_of_peak];
  }
  if (!r->value || !s->value) {
    alignment.refusal = "neither event nor peak is in both";
    return alignment;
  }
  alignment.lag = *r->value - *s->value;
  alignment.uncertainty = std::hypot(r->uncertainty, s->uncertainty);
  return alignment;
}

Alignment by_start(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  return {.used = AlignmentRule::start, .how = "by the first samples",
          .lag = recorded.input.raw.start - simulated.input.raw.start};
}

}  // namespace

std::string_view name_of(AlignmentRule rule) {
  switch (rule) {
    case AlignmentRule::depth: return "depth";
    case AlignmentRule::event: return "event";
    case AlignmentRule::start: return "start";
    case AlignmentRule::automatic: break;
  }
  return "automatic";
}

Alignment align(const PreparedTrace& recorded, const PreparedTrace& simulated, AlignmentRule rule) {
  if (rule == AlignmentRule::start) { return by_start(recorded, simulated); }
  if (rule == AlignmentRule::event) { return by_event(recorded, simulated); }
  const Alignment deep = by_depth(recorded, simulated);
  if (rule == AlignmentRule::depth || deep.refusal.empty()) { return deep; }
  const Alignment event = by_event(recorded, simulated);
  Alignment other = event.refusal.empty() ? event : by_start(recorded, simulated);
  const bool both_have_depth = !recorded.input.depth.value.empty() && !simulated.input.depth.value.empty();
  if (both_have_depth) {
    other.not_by_depth = deep.refusal;
    other.how += ", not by depth: " + deep.refusal;
  }
  return other;
}

}  // namespace palpate::comparison

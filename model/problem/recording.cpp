// SPDX-License-Identifier: MIT

#include "model/problem/recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr double near_median = 0.25;   // fraction of the median: steps that define the nominal rate
constexpr double most_missing = 1e12;  // upper limit for one gap, which any integer type can store
constexpr double longest_span = 1e9;   // thirty years [s]
constexpr double uneven_by = 0.2;      // fraction of the median: above rounding to milliseconds

std::vector<double> steps_of(std::span<const double> time) {
  std::vector<double> steps;
  for (std::size_t n = 1; n < time.size(); ++n) { steps.push_back(time[n] - time[n - 1]); }
  return steps;
}

void keep_rows(std::vector<double>& values, const std::vector<char>& kept) {
  if (values.empty()) { return; }
  std::size_t end = 0;
  for (std::size_t n = 0; n < kept.size(); ++n) {
    if (kept[n] != 0) { values[end++] = values[n]; }
  }
  values.resize(end);
}

std::size_t clear_what_is_not_finite(std::vector<double>& values) {
  std::size_t count = 0;
  for (double& value : values) {
    if (std::isfinite(value)) { continue; }
    value = std::numeric_limits<double>::quiet_NaN();
    ++count;
  }
  return count;
}

/// Counts the samples in runs of at least `least_run` values equal to `extreme`.
std::size_t flat_samples(std::span<const double> values, double extreme, std::size_t least_run) {
  std::size_t total = 0;
  std::size_t run = 0;
  for (const double value : values) {
    run = value == extreme ? run + 1 : 0;
    if (run == least_run) { total += run; }
    if (run > least_run) { ++total; }
  }
  return total;
}

void count_gaps(Recording& recording) {
  const double period = sampling_of(recording.time).period;
  recording.defects.gaps = 0;
  recording.defects.missing = 0;
  for (std::size_t n = 1; n < recording.time.size(); ++n) {
    const double periods = (recording.time[n] - recording.time[n - 1]) / period;
    if (periods <= DefectRules::gap_periods) { continue; }
    ++recording.defects.gaps;
    recording.defects.missing +=
        static_cast<std::size_t>(std::round(std::fmin(periods, most_missing))) - 1;
  }
}

}  // namespace

Sampling sampling_of(std::span<const double> time) {
  std::vector<double> steps = steps_of(time);
  if (steps.empty()) { return {}; }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  Sampling sampling{.period = *middle};
  double sum = 0.0;
  double near = 0.0, uneven = 0.0, gaps = 0.0;
  for (const double step : steps) {
    const double off = std::abs(step - sampling.period);
    const bool gap = step > DefectRules::gap_periods * sampling.period;
    gaps += gap ? 1.0 : 0.0;
    uneven += !gap && off > uneven_by * sampling.period ? 1.0 : 0.0;
    if (off > near_median * sampling.period) { continue; }
    sum += step;
    near += 1.0;
  }
  sampling.rate = std::isfinite(near / sum) ? near / sum : 0.0;
  sampling.uneven = uneven / std::max(1.0, static_cast<double>(steps.size()) - gaps);
  sampling.shortest = *std::ranges::min_element(steps);
  sampling.longest = *std::ranges::max_element(steps);
  return sampling;
}

void leave_out_rows_out_of_order(Recording& recording) {
  std::vector<char> kept(recording.time.size(), 0);
  double last = -std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < kept.size(); ++n) {
    if (!std::isfinite(recording.time[n]) || recording.time[n] <= last) { continue; }
    kept[n] = 1;
    last = recording.time[n];
  }
  const auto left_out = static_cast<std::size_t>(std::ranges::count(kept, 0));
  recording.defects.not_increasing += left_out;
  if (left_out == 0) { return; }
  for (auto* values : {&recording.time, &recording.pressure, &recording.depth, &recording.force}) {
    keep_rows(*values, kept);
  }
}

void count_defects(Recording& recording, std::span<const char> reported_out_of_range) {
  RecordingDefects& defects = recording.defects;
  const std::size_t in_pressure = clear_what_is_not_finite(recording.pressure);
  const std::size_t in_force = clear_what_is_not_finite(recording.force);
  defects.not_finite = recording.pressure.empty() ? in_force : in_pressure;
  clear_what_is_not_finite(recording.depth);
  count_gaps(recording);
  defects.out_of_range = 0;
  for (std::size_t n = 0; n < recording.pressure.size(); ++n) {
    const double pressure = recording.pressure[n];
    const bool reported = n < reported_out_of_range.size() && reported_out_of_range[n] != 0;
    const bool out =
        pressure < DefectRules::least_pressure || pressure > DefectRules::largest_pressure;
    defects.out_of_range += reported || out ? 1 : 0;
  }
  const std::vector<double>& signal = recording.signal();
  const Extremes extremes = extremes_of(signal);
  defects.clipped = 0;
  if (!(extremes.least < extremes.largest)) { return; }  // a constant signal is not clipped
  for (const double extreme : {extremes.least, extremes.largest}) {
    defects.clipped += flat_samples(signal, extreme, DefectRules::flat_run);
  }
}

std::optional<std::size_t> find_contact(std::span<const double> force,
                                        std::span<const double> depth, double threshold,
                                        double distance) {
  const std::size_t count = std::min(force.size(), depth.size());
  std::optional<std::size_t> first;  // sample from which the force has been above the threshold
  for (std::size_t n = 0; n < count; ++n) {
    if (std::isnan(force[n]) || std::isnan(depth[n])) { continue; }
    if (!(force[n] > threshold)) {
      first.reset();
    } else if (!first) {
      first = n;
    } else if (depth[n] - depth[*first] >= distance) {
      return first;
    }
  }
  return std::nullopt;
}

Extremes extremes_of(std::span<const double> values) {
  Extremes extremes;
  for (const double value : values) {
    if (!std::isfinite(value)) { continue; }
    extremes.least = std::fmin(extremes.least, value);
    extremes.largest = std::fmax(extremes.largest, value);
  }
  return extremes;
}

std::string why_unusable(const Recording& recording) {
  const std::size_t samples = recording.time.size();
  if (samples == 0) { return "has no samples; at least two are needed"; }
  if (samples == 1) {
    return recording.defects.not_increasing > 0
               ? "has one sample whose time increases; at least two are needed"
               : "has one sample; at least two are needed";
  }
  for (const auto& [name, values] :
       {std::pair{"pressure", &recording.pressure}, std::pair{"depth", &recording.depth},
        std::pair{"force", &recording.force}}) {
    if (values->empty() || values->size() == samples) { continue; }
    return std::string(name) + " has " + std::to_string(values->size()) + " values and time " +
           std::to_string(samples) + "; they must have as many";
  }
  if (recording.signal().empty()) {
    return "has neither pressure nor force; one of them is needed";
  }
  const Extremes span = extremes_of(recording.time);
  if (span.largest - span.least >= longest_span) {
    return "lasts more than 1e9 s; time must be in the unit that its name says";
  }
  if (std::isnan(extremes_of(recording.signal()).largest)) {
    return std::string(recording.pressure.empty() ? "force" : "pressure") +
           " has no number at all; at least one sample must be finite";
  }
  return {};
}

}  // namespace palpate

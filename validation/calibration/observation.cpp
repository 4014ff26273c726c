// SPDX-License-Identifier: MIT
#include "validation/calibration/observation.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "validation/comparison/prepared_trace.hpp"
#include "validation/comparison/zero_phase.hpp"

namespace palpate::calibration {
namespace {

using namespace comparison;

/// Of the way of a bin, so much must have been seen.
constexpr double least_seen = 0.8;
/// The thumb takes its time to press fully: until the tip has gone so far, a force on the plunger is none of
/// the needle's [m].
constexpr double first_advance = 0.25e-3;

struct Inputs {
  std::span<const double> time{};
  std::span<const double> pressure{};
  std::span<const double> depth{};
  std::span<const double> force{};  ///< empty: none
};

/// Force over the way on which it was met.
struct Way {
  double work = 0.0;    ///< integral of the force over the depth [J]
  double length = 0.0;  ///< [m]
};

/// Trapezia over the advance; samples that do not advance weigh nothing, so that the hand's speed does not
/// count.
Way way_through(const Samples& force, const Samples& depth, double begin, double end, std::size_t last) {
  Way way;
  for (std::size_t n = 1; n <= last && n < force.size(); ++n) {
    const double from = depth.value[n - 1];
    const double to = depth.value[n];
    const double middle = 0.5 * (from + to);
    if (!(to > from) || middle < begin || middle >= end) { continue; }
    const double mean = 0.5 * (force.value[n - 1] + force.value[n]);
    if (!std::isfinite(mean)) { continue; }
    way.work += mean * (to - from);
    way.length += to - from;
  }
  return way;
}

double first_number(const std::vector<double>& values) {
  const auto found = std::ranges::find_if(values, [](double v) { return std::isfinite(v); });
  return found == values.end() ? not_measured : *found;
}

void add_bins(const Samples& force, const Samples& depth, double depth_of_loss, std::size_t last,
              Observation& value) {
  const double pressed_from = first_number(depth.value) + first_advance;
  Eigen::Index index = index_of(Observable::force);
  for (const ForceBin& bin : force_bins) {
    const double begin = depth_of_loss + bin.begin;
    const double end = depth_of_loss + bin.end;
    const Way way = way_through(force, depth, std::fmax(begin, pressed_from), end, last);
    if (way.length >= least_seen * (end - begin)) { value[index] = way.work / way.length; }
    ++index;
  }
}

void add_force(const Inputs& inputs, const PreparedTrace& prepared, double cutoff, Observation& value) {
  const Features& found = prepared.features;
  const auto& time_of_loss = found[Feature::time_of_loss].value;
  if (inputs.force.empty() || !time_of_loss) { return; }
  const Samples force = zero_phase(regular(inputs.time, inputs.force), cutoff);
  const std::size_t last = force.index_at(*time_of_loss);
  double peak = -1e300;
  for (std::size_t n = 0; n <= last; ++n) { peak = std::fmax(peak, force.value[n]); }
  value[index_of(Observable::force_peak)] = peak;
  const auto& depth_of_loss = found[Feature::depth_of_loss].value;
  if (depth_of_loss && prepared.input.depth.size() == force.size()) {
    add_bins(force, prepared.input.depth, *depth_of_loss, last, value);
  }
}

/// The loss where the force falls is that of the pressure: both fall when the tip enters the epidural space.
ObservedInsertion observe_inputs(const Inputs& inputs, double cutoff) {
  ObservedInsertion seen{.value = Observation::Constant(observable_count, not_measured)};
  const double rate = 1.0 / usual_interval(inputs.time);
  const double used = std::fmin(cutoff, 0.25 * rate);
  const PreparedTrace prepared =
      prepare({.time = inputs.time, .value = inputs.pressure, .depth = inputs.depth}, used, {});
  if (!prepared.refusal.empty()) {
    seen.refusal = prepared.refusal;
    return seen;
  }
  if (!prepared.features.loss.fell()) {
    seen.refusal = "shows no loss of resistance: " + prepared.features.loss.reason;
    return seen;
  }
  for (const auto& [observable, feature] : {std::pair{Observable::pressure_peak, Feature::peak},
                                            {Observable::plateau, Feature::plateau},
                                            {Observable::drop_time, Feature::drop_time},
                                            {Observable::depth_of_loss, Feature::depth_of_loss}}) {
    seen.value[index_of(observable)] = prepared.features[feature].value.value_or(not_measured);
  }
  add_force(inputs, prepared, used, seen.value);
  return seen;
}

std::vector<double> plunger_force(const Recording& recording) {
  std::vector<double> force = recording.pressure;
  for (double& f : force) { f *= recording.plunger_area; }
  return force;
}

}  // namespace

std::string name_of(Eigen::Index observable) {
  if (observable > index_of(Observable::force_peak)) {
    constexpr std::array bins{"force.-10_to_-8_mm", "force.-8_to_-6_mm", "force.-6_to_-4_mm",
                              "force.-4_to_-2_mm", "force.-2_to_-0.5_mm"};
    static_assert(bins.size() == force_bins.size());
    return bins[static_cast<std::size_t>(observable - index_of(Observable::force))];
  }
  constexpr std::array names{"pressure.peak", "pressure.plateau", "pressure.drop_time", "depth_of_loss",
                             "force.peak"};
  return names[static_cast<std::size_t>(observable)];
}

bool is_pressure(Eigen::Index observable) { return observable <= index_of(Observable::plateau); }
bool is_force(Eigen::Index observable) { return observable >= index_of(Observable::force_peak); }

std::string_view unit_of(Eigen::Index observable) {
  if (is_pressure(observable)) { return "Pa"; }
  if (is_force(observable)) { return "N"; }
  return observable == index_of(Observable::drop_time) ? "s" : "m";
}

std::string_view name_of(ForceSource source) {
  switch (source) {
    case ForceSource::none:
      return "none";
    case ForceSource::recorded:
      return "recorded";
    case ForceSource::plunger:
      return "plunger";
  }
  return {};
}

ForceSource force_source(const Recording& recording) {
  if (recording.force.size() == recording.time.size() && !recording.force.empty()) {
    return ForceSource::recorded;
  }
  const bool driven = recording.technique == "continuous" && recording.regime == Recording::Regime::thumb;
  return driven ? ForceSource::plunger : ForceSource::none;
}

ObservedInsertion observe(const Recording& recording, double cutoff) {
  const ForceSource source = force_source(recording);
  std::vector<double> force;
  if (source == ForceSource::recorded) { force = recording.force; }
  if (source == ForceSource::plunger) { force = plunger_force(recording); }
  ObservedInsertion seen = observe_inputs(
      {.time = recording.time, .pressure = recording.pressure, .depth = recording.depth, .force = force},
      cutoff);
  seen.force = source;
  return seen;
}

ObservedInsertion observe(const Trace& trace, double cutoff) {
  const Column* pressure = trace.find("syringe.pressure_pa");
  const Column* depth = trace.find("tool.depth_m");
  const Column* force = trace.find("tool.force_n");
  if (pressure == nullptr || depth == nullptr || force == nullptr) {
    return {.value = Observation::Constant(observable_count, not_measured),
            .refusal = "has no syringe or no tool"};
  }
  ObservedInsertion seen = observe_inputs(
      {.time = trace.time, .pressure = pressure->values, .depth = depth->values, .force = force->values},
      cutoff);
  seen.force = ForceSource::recorded;
  return seen;
}

}  // namespace palpate::calibration

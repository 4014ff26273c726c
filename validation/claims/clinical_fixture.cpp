// SPDX-License-Identifier: MIT

#include "validation/claims/clinical_fixture.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::clinical {

double PressureLaw::at(double time) const {
  const double t = time - delay;
  if (t < rise) { return level; }
  if (t < loss) { return level + (peak - level) * (t - rise) / (loss - rise); }
  return plateau + (peak - plateau) * std::exp(-(t - loss) / fall_constant);
}

std::vector<double> instants(double duration, double rate) {
  std::vector<double> time(static_cast<std::size_t>(std::lround(duration * rate)) + 1);
  for (std::size_t n = 0; n < time.size(); ++n) { time[n] = static_cast<double>(n) / rate; }
  return time;
}

std::vector<double> pressures(const PressureLaw& law, const std::vector<double>& time) {
  std::vector<double> values;
  for (const double t : time) { values.push_back(law.at(t)); }
  return values;
}

void add_noise(std::vector<double>& values, double deviation, device::Seeded& seeded) {
  for (double& v : values) { v += deviation * seeded.normal(); }
}

void damage(const CaseContext& context, std::vector<double>& pressure) {
  if (context.mutation == nullptr || !context.mutation->trace) { return; }
  Trace trace;
  trace.columns = {{"syringe.pressure_pa", "Pa", std::move(pressure)}};
  context.mutation->trace(trace);
  pressure = std::move(trace.columns.front().values);
}

double largest_difference(std::span<const double> a, std::span<const double> b) {
  Largest largest(a.empty() ? comparison::not_measured : 0.0);
  for (std::size_t n = 0; n < a.size(); ++n) { largest.add(std::abs(a[n] - b[n])); }
  return largest.value();
}

Recording recording_of(const std::vector<double>& time, std::vector<double> pressure) {
  Recording recording{.name = "made-up", .kind = Recording::Kind::reconstructed, .source = "a law"};
  recording.sample_rate = 1.0 / (time[1] - time[0]);
  recording.time = time;
  recording.pressure = std::move(pressure);
  return recording;
}

Trace trace_of(const std::vector<double>& time, std::vector<double> pressure) {
  Trace trace;
  trace.time = time;
  trace.columns.push_back(
      {.name = "syringe.pressure_pa", .unit = "Pa", .values = std::move(pressure)});
  return trace;
}

namespace {

constexpr double length = 30.0;  // [s]

/// Event of one insertion.
struct Event {
  double time = 0.0;            // [s]
  double drop = 0.0;            // relative to the peak [1]
  double fall_constant = 0.05;  // [s]
  double back = 0.0;            // [s] after it; 0: never
};

/// Returns the pressure after the event as a share of the peak.
double left_by(const Event& event, double t) {
  if (t < event.time) { return 1.0; }
  const double fallen =
      1.0 - event.drop * (1.0 - std::exp(-(t - event.time) / event.fall_constant));
  if (event.back <= 0.0 || t < event.time + event.back) { return fallen; }
  return std::min(1.0, fallen + 2.0 * (t - event.time - event.back));  // back within half a second
}

/// Pushes of a thumb between 0 and 1: rise in a fifth of a period, constant, release.
double push(double t, double period, double relax) {
  const double phase = std::fmod(t, period);
  if (phase < 0.2 * period) { return phase / (0.2 * period); }
  if (phase < 0.5 * period) { return 1.0; }
  return 0.15 + 0.85 * std::exp(-(phase - 0.5 * period) / relax);
}

}  // namespace

comparison::Samples seeded_insertion(const Insertions& kind, std::uint64_t seed) {
  device::Seeded seeded(seed);
  const double peak = seeded.uniform(1.0, 2.0) * smallest_peak;
  const double period = seeded.uniform(1.5, 4.0);
  const double relax = seeded.uniform(0.1, 0.4);
  Event event{.time = seeded.uniform(8.0, 18.0), .fall_constant = seeded.uniform(0.02, 0.09)};
  event.drop = kind.drops
                   ? std::clamp(kind.mean_drop + kind.deviation_drop * seeded.normal(), 0.02, 0.98)
                   : 0.0;
  event.back = kind.held ? 0.0 : seeded.uniform(0.3, 4.0);
  if (kind.technique == Technique::intermittent) {  // the needle enters while it is pushed
    event.time = period * (std::floor(event.time / period) + 0.45);
  }
  comparison::Samples samples{.step = 1.0 / sample_rate};
  for (const double t : instants(length, sample_rate)) {
    const double rise = 0.3 + 0.7 * std::min(1.0, t / event.time);
    const bool pushed =
        kind.technique == Technique::intermittent && (t < event.time || !kind.held || !kind.drops);
    samples.value.push_back(peak * rise * left_by(event, t) *
                            (pushed ? push(t, period, relax) : 1.0));
  }
  add_noise(samples.value, noise_deviation, seeded);
  return samples;
}

}  // namespace palpate::clinical

// SPDX-License-Identifier: MIT
#pragma once
/// Synthetic pressures of insertions that follow a law with known features.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "device/seeded.hpp"
#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"
#include "validation/case.hpp"
#include "validation/comparison/comparison.hpp"

namespace palpate::clinical {

/// Pressure law: constant level, linear rise to the peak, then exponential fall to the plateau.
struct PressureLaw {
  double level = 20.0 * pascals_per_mmhg;   ///< [Pa]
  double peak = 60.0 * pascals_per_mmhg;    ///< [Pa]
  double plateau = 8.0 * pascals_per_mmhg;  ///< [Pa]; equal to the peak: no loss of resistance
  double rise = 1.0;                        ///< [s] start of the rise
  double loss = 6.0;                        ///< [s]
  double fall_constant = 0.15;              ///< [s] time constant of the fall
  double delay = 0.0;                       ///< [s] delay of the whole law

  [[nodiscard]] double at(double time) const {
    const double t = time - delay;
    if (t < rise) { return level; }
    if (t < loss) { return level + (peak - level) * (t - rise) / (loss - rise); }
    return plateau + (peak - plateau) * std::exp(-(t - loss) / fall_constant);
  }
};

/// Returns instants from 0 to `duration` inclusive [s] at `rate` [Hz].
inline std::vector<double> instants(double duration, double rate) {
  std::vector<double> time(static_cast<std::size_t>(std::lround(duration * rate)) + 1);
  for (std::size_t n = 0; n < time.size(); ++n) { time[n] = static_cast<double>(n) / rate; }
  return time;
}

inline std::vector<double> pressures(const PressureLaw& law, const std::vector<double>& time) {
  std::vector<double> values;
  for (const double t : time) { values.push_back(law.at(t)); }
  return values;
}

inline void add_noise(std::vector<double>& values, double deviation, device::Seeded& seeded) {
  for (double& v : values) { v += deviation * seeded.normal(); }
}

/// Applies the planted fault of a case, if any, to a simulated pressure.
inline void damage(const CaseContext& context, std::vector<double>& pressure) {
  if (context.mutation == nullptr || !context.mutation->trace) { return; }
  Trace trace;
  trace.columns = {{"syringe.pressure_pa", "Pa", std::move(pressure)}};
  context.mutation->trace(trace);
  pressure = std::move(trace.columns.front().values);
}

/// Inputs of compare(): the recording of a thumb, a simulated trace.
inline Recording recording_of(const std::vector<double>& time, std::vector<double> pressure) {
  Recording recording{.name = "made-up", .kind = Recording::Kind::reconstructed, .source = "a law"};
  recording.sample_rate = 1.0 / (time[1] - time[0]);
  recording.time = time;
  recording.pressure = std::move(pressure);
  return recording;
}

inline Trace trace_of(const std::vector<double>& time, std::vector<double> pressure) {
  Trace trace;
  trace.time = time;
  trace.columns.push_back(
      {.name = "syringe.pressure_pa", .unit = "Pa", .values = std::move(pressure)});
  return trace;
}

/// Returns the largest |a - b| of sequences of the same length; NaN if a value is NaN or none
/// exists.
inline double largest_difference(std::span<const double> a, std::span<const double> b) {
  Largest largest(a.empty() ? comparison::not_measured : 0.0);
  for (std::size_t n = 0; n < a.size(); ++n) { largest.add(std::abs(a[n] - b[n])); }
  return largest.value();
}

}  // namespace palpate::clinical

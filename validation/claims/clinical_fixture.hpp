// SPDX-License-Identifier: MIT
#pragma once
/// Synthetic pressures of insertions that follow a law with known features.

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

  [[nodiscard]] double at(double time) const;  ///< [Pa]
};

/// Returns instants from 0 to `duration` inclusive [s] at `rate` [Hz].
std::vector<double> instants(double duration, double rate);
std::vector<double> pressures(const PressureLaw& law, const std::vector<double>& time);

void add_noise(std::vector<double>& values, double deviation, device::Seeded& seeded);

/// Applies the planted fault of a case, if any, to a simulated pressure.
void damage(const CaseContext& context, std::vector<double>& pressure);

/// Inputs of compare(): the recording of a thumb, a simulated trace.
Recording recording_of(const std::vector<double>& time, std::vector<double> pressure);
Trace trace_of(const std::vector<double>& time, std::vector<double> pressure);

/// Returns the largest |a - b| of sequences of the same length; NaN if a value is NaN or none
/// exists.
double largest_difference(std::span<const double> a, std::span<const double> b);

/// Insertion techniques with and without a loss of resistance, to test its detection.
enum class Technique { continuous, intermittent };
struct Insertions {
  Technique technique = Technique::continuous;
  double mean_drop = 0.73;       ///< relative to the peak [1]
  double deviation_drop = 0.18;  ///< standard deviation, normal, clamped to 0.02 and 0.98
  bool held = true;              ///< false: the pressure recovers within 4 s
  bool drops = true;             ///< false: no drops other than those between pushes
};
inline constexpr double sample_rate = 120.0;  ///< [Hz] of the raw pressure link
inline constexpr double noise_deviation = 5.0 * pascals_per_mmhg;  ///< [Pa] (assumed)
inline constexpr double smallest_peak =
    300.0 * pascals_per_mmhg;  ///< [Pa]; the largest is twice that
/// Returns a synthetic insertion of 30 s.
comparison::Samples seeded_insertion(const Insertions& kind, std::uint64_t seed);

}  // namespace palpate::clinical

// SPDX-License-Identifier: MIT
#pragma once
/// Pressures of insertions made up from a law, whose features are known before anything measures
/// them.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "device/seeded.hpp"
#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"
#include "validation/case.hpp"
#include "validation/comparison/comparison.hpp"

namespace palpate::clinical {

/// Level, a straight rise to the peak, then an exponential fall to the plateau.
struct PressureLaw {
  double level = 20.0 * pascals_per_mmhg;   ///< [Pa]
  double peak = 60.0 * pascals_per_mmhg;    ///< [Pa]
  double plateau = 8.0 * pascals_per_mmhg;  ///< [Pa]; equal to the peak: no loss of resistance
  double rise = 1.0;                        ///< [s] when it begins
  double loss = 6.0;                        ///< [s]
  double fall_constant = 0.15;              ///< [s] of the exponential
  double delay = 0.0;                       ///< [s] of everything

  [[nodiscard]] double at(double time) const;  ///< [Pa]
};

/// One per step from 0 to `duration` inclusive [s].
std::vector<double> instants(double duration, double rate);
std::vector<double> pressures(const PressureLaw& law, const std::vector<double>& time);

void add_noise(std::vector<double>& values, double deviation, device::Seeded& seeded);

/// The planted fault of a case, if there is one, on a simulated pressure.
void damage(const CaseContext& context, std::vector<double>& pressure);

/// As compare() takes them: a thumb's recording, a simulated trace.
Recording recording_of(const std::vector<double>& time, std::vector<double> pressure);
Trace trace_of(const std::vector<double>& time, std::vector<double> pressure);

/// Largest |a - b| of two of the same length; NaN where any of them is NaN, or there is none.
double largest_difference(std::span<const double> a, std::span<const double> b);

/// The hands' techniques with and without a loss of resistance, for the rule that finds it.
enum class Technique { continuous, intermittent };
struct Insertions {
  Technique technique = Technique::continuous;
  double mean_drop = 0.73;       ///< of the peak
  double deviation_drop = 0.18;  ///< normal, kept within 0.02 and 0.98
  bool held = true;              ///< false: the pressure comes back within 4 s
  bool drops = true;             ///< false: no fall but those between pushes
};
inline constexpr double sample_rate = 120.0;  ///< [Hz] of the raw pressure link
inline constexpr double noise_deviation = 5.0 * pascals_per_mmhg;  ///< [Pa] (assumed)
inline constexpr double smallest_peak =
    300.0 * pascals_per_mmhg;  ///< [Pa]; the largest is twice that
/// One made-up insertion of 30 s.
comparison::Samples seeded_insertion(const Insertions& kind, std::uint64_t seed);

// What the group "clinical" is made of. The candidate of these cases is a simulated pressure (or,
// for the rule that finds the event, a made-up insertion): planted faults damage that.

std::vector<Case>
measure_cases();  ///< distances, ratings and filter against closed forms and a second opinion
std::vector<Case> feature_cases();  ///< features of traces whose law is known
std::vector<Case> verdict_cases();  ///< what each measure is blind to, and the verdict that is not
std::vector<Case>
detection_cases();  ///< how often the event is found, and is found where there is none
std::vector<Case> subject_cases();      ///< corridor and bootstrap over subjects
std::vector<Case> round_trip_cases();   ///< simulated, recorded through the link, compared
std::vector<Case> calibration_cases();  ///< parameters from recordings

}  // namespace palpate::clinical

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// One millimetre of mercury, as the conventional unit is defined [Pa] (NIST SP 811, appendix B.8).
inline constexpr double pascals_per_mmhg = 133.322387415;

// What a pressure transducer left behind: a measured insertion, or one rebuilt from published
// values.

/// What was found wrong with the samples when they were read; nothing of it is mended.
struct RecordingDefects {
  std::size_t missing = 0;     ///< samples that never arrived; time goes on, no row stands for them
  std::size_t gaps = 0;        ///< places where they are missing
  std::size_t bad_frames = 0;  ///< of the raw link, that failed their check or were cut short
  std::size_t not_finite = 0;  ///< samples without a number; they stay in as NaN
  std::size_t out_of_range = 0;    ///< told so by the transducer, or beyond what one can measure
  std::size_t clipped = 0;         ///< samples of a flat top at the largest or smallest value
  std::size_t not_increasing = 0;  ///< rows whose time does not come after the row before; left out
  std::size_t battery_low = 0;     ///< samples whose transducer said that its battery is low
  bool operator==(const RecordingDefects&) const = default;
};

struct Recording {
  enum class Kind { measured, reconstructed };
  /// Never compared with each other: the pressure of a thumb on the plunger, of a pump that
  /// injects.
  enum class Regime { thumb, pump };

  std::string name{};  ///< for people, as "bmi-18-continuous-03"
  Kind kind = Kind::measured;
  Regime regime = Regime::thumb;
  std::string source{};  ///< publication, hospital, device
  std::string
      note{};  ///< what else a reader must know; of a reconstructed one, from what it was rebuilt
  std::string group{};  ///< of subjects that belong together, as "BMI 18-24.9"
  /// Who was recorded, as a code that names nobody, so that several recordings of one count once;
  /// empty: somebody of whom there is no other recording.
  std::string subject{};
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::string technique{};                  ///< "continuous", "intermittent" or empty
  double plunger_area = 1.767e-4;           ///< [m^2]
  double sample_rate = 0.0;                 ///< nominal [Hz]

  std::vector<double> time{};      ///< [s], strictly increasing
  std::vector<double> pressure{};  ///< gauge [Pa], one per time; NaN where none was measured
  std::vector<double> depth{};     ///< of the tip below the skin [m]; empty: not recorded
  std::vector<double> force{};     ///< along the needle [N]; empty: not recorded
  RecordingDefects defects{};
};

// What is wrong with the samples of a recording, counted in one place for every format. Samples
// are left as they are: nothing is interpolated, and only rows out of order are left out.

struct DefectRules {
  /// Gauge [Pa]: no vacuum is deeper than the atmosphere (ISO 2533, sea level).
  double least_pressure = -101325.0;
  /// Gauge [Pa]: half a step beyond the largest that the raw link can carry (docs/formats.md).
  double largest_pressure = 3276.75 * pascals_per_mmhg;
  /// Equal samples in a row at the largest or smallest pressure that count as clipped. A choice: a
  /// tenth of a second of the raw link, in which a pressure seldom stays within one step.
  std::size_t flat_run = 12;
  /// Steps longer than this many nominal periods are gaps. A choice: halfway to the step that one
  /// missing sample makes.
  double gap_periods = 1.5;
};

/// How time goes on. All zero with fewer than two samples.
struct Sampling {
  double period = 0.0;  ///< median step [s]
  double rate = 0.0;    ///< over the mean of the steps within a quarter of the median [Hz]
  double uneven = 0.0;  ///< share of the steps, without gaps, that differ from the median by > 20 %
  double shortest = 0.0;  ///< [s]
  double longest = 0.0;   ///< [s]
};
Sampling sampling_of(std::span<const double> time, const DefectRules& rules = {});

/// Leaves out and counts rows whose time does not come after that of the row before, or is NaN.
void leave_out_rows_out_of_order(Recording& recording);

/// Counts gaps, missing, not finite, out of range and clipped samples of a recording in order, and
/// does so anew at each call. `told_out_of_range`: per sample, other than 0 where the transducer
/// said that it was over its range; empty: it cannot say so. Infinite values become NaN.
void count_defects(Recording& recording, const DefectRules& rules = {},
                   std::span<const char> told_out_of_range = {});

/// Why a recording cannot be used, as "found; allowed"; empty when it can. A constant pressure can.
std::string why_unusable(const Recording& recording);

/// Smallest and largest finite value; both NaN when there is none.
struct Extremes {
  double least = std::numeric_limits<double>::quiet_NaN();
  double largest = std::numeric_limits<double>::quiet_NaN();
};
Extremes extremes_of(std::span<const double> values);

}  // namespace palpate

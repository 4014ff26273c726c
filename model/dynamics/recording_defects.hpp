// SPDX-License-Identifier: MIT
#pragma once
/// What is wrong with the samples of a recording, counted in one place for every format. Samples
/// are left as they are: nothing is interpolated, and only rows out of order are left out.

#include <limits>
#include <span>
#include <string>

#include "model/dynamics/pressure_units.hpp"
#include "model/dynamics/recording.hpp"

namespace palpate {

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
/// does so anew at each call. `told_out_of_range`: per sample, other than 0 where the transducer said
/// that it was over its range; empty: it cannot say so. Infinite values become NaN.
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

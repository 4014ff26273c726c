// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// One millimetre of mercury, conventional unit [Pa] (NIST SP 811, appendix B.8).
inline constexpr double pascals_per_mmhg = 133.322387415;

/// Defects of the samples that were found during reading. Every defect is counted. Rows out of
/// order are removed and non-finite values become NaN; all other samples stay as they are.
struct RecordingDefects {
  std::size_t missing = 0;         ///< samples that were not received; they have no row
  std::size_t gaps = 0;            ///< gaps in time
  std::size_t bad_frames = 0;      ///< frames of the raw link, truncated or with a wrong checksum
  std::size_t not_finite = 0;      ///< samples without a number; stored as NaN
  std::size_t out_of_range = 0;    ///< reported by the transducer, or outside its possible range
  std::size_t clipped = 0;         ///< samples of a constant run at the largest or smallest value
  std::size_t not_increasing = 0;  ///< rows whose time is not after that of the row before; removed
  std::size_t battery_low = 0;     ///< samples for which the transducer reported a low battery
  bool operator==(const RecordingDefects&) const = default;
};

/// Recording of an insertion, with the pressure of a transducer, the force along the needle, or
/// both: measured in a patient or specimen, measured in a phantom, or reconstructed from published
/// values.
struct Recording {
  enum class Kind { measured, reconstructed, measured_phantom };
  /// Method of injection; pressures of the two are not comparable.
  enum class Regime { thumb, pump };

  std::string name{};  ///< identifier for people, e.g. "bmi-18-continuous-03"
  Kind kind = Kind::measured;
  Regime regime = Regime::thumb;
  std::string source{};  ///< publication, hospital, device
  std::string note{};    ///< remarks; for a reconstructed recording, its source data
  std::string group{};   ///< group of subjects, e.g. "BMI 18-24.9"
  /// Anonymous code of the subject, unique within its group: recordings with the same group and
  /// code count as one subject. Empty if there is no other recording of the subject. Of a phantom:
  /// the needle; each of its insertions counts, because each enters a new position.
  std::string subject{};
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::string technique{};                  ///< "continuous", "intermittent" or empty
  double plunger_area = 1.767e-4;           ///< [m^2]
  double sample_rate = 0.0;                 ///< nominal [Hz]

  std::vector<double> time{};      ///< [s], strictly increasing
  std::vector<double> pressure{};  ///< gauge [Pa]; NaN where none was measured; empty if never
  std::vector<double> depth{};     ///< of the tip below the skin [m]; empty if not recorded
  std::vector<double> force{};     ///< along the needle [N]; empty if not recorded
  RecordingDefects defects{};

  /// Pressure, or the force of a recording without pressure. Its samples are checked for defects.
  [[nodiscard]] const std::vector<double>& signal() const {
    return pressure.empty() ? force : pressure;
  }
};

struct DefectRules {
  /// Lower limit of the gauge pressure [Pa]: vacuum at sea level (ISO 2533).
  static constexpr double least_pressure = -101325.0;
  /// Upper limit of the gauge pressure [Pa]: half a count above the largest value of the raw link.
  static constexpr double largest_pressure = 3276.75 * pascals_per_mmhg;
  /// Least number of equal consecutive samples at an extreme that is clipped: 0.1 s of the raw
  /// link.
  static constexpr std::size_t flat_run = 12;
  /// Steps longer than this many periods are gaps: halfway to a step with one missing sample.
  static constexpr double gap_periods = 1.5;
};

/// Statistics of the sample times. All values are zero if there are fewer than two samples.
struct Sampling {
  double period = 0.0;    ///< median step [s]
  double rate = 0.0;      ///< 1 / mean of the steps within 25 % of the median [Hz]
  double uneven = 0.0;    ///< share of steps, without gaps, more than 20 % off the median
  double shortest = 0.0;  ///< [s]
  double longest = 0.0;   ///< [s]
};
Sampling sampling_of(std::span<const double> time);

/// Removes and counts rows whose time is NaN or not after that of the row before.
void leave_out_rows_out_of_order(Recording& recording);

/// Counts the gaps and the missing, non-finite, out-of-range and clipped samples of a recording in
/// order of time; replaces these five counts. `reported_out_of_range` has one entry per sample,
/// non-zero if the transducer reported an overrange; empty if it has no such flag. Infinite
/// values become NaN; only those of the signal are counted.
void count_defects(Recording& recording, std::span<const char> reported_out_of_range = {});

/// Returns why a recording cannot be used, e.g. "has no samples; at least two are needed"; empty if
/// it can. A constant signal is usable.
std::string why_unusable(const Recording& recording);

/// Rule that finds where a needle touches the tissue: the first sample from which the force stays
/// above a threshold while the needle advances by `distance`.
struct ContactRule {
  /// Least threshold [N]. It reproduces the dents and exponents of phantom measurements that were
  /// evaluated independently (docs/notebook/measured-insertions.md).
  double force = 0.1;
  double deviations = 5.0;  ///< threshold over the standard deviation of the force at rest
  double distance = 1e-3;   ///< [m]
  /// Returns the threshold [N] for a standard deviation of the samples [N].
  [[nodiscard]] double threshold(double deviation) const {
    return deviation * deviations > force ? deviation * deviations : force;
  }
};

/// Returns the index of the first sample of contact; absent without contact. `force` [N] and
/// `depth` [m] have the same length; NaN is skipped.
std::optional<std::size_t> find_contact(std::span<const double> force,
                                        std::span<const double> depth, double threshold,
                                        double distance);

/// Smallest and largest finite value; both are NaN if there is none.
struct Extremes {
  double least = std::numeric_limits<double>::quiet_NaN();
  double largest = std::numeric_limits<double>::quiet_NaN();
};
Extremes extremes_of(std::span<const double> values);

}  // namespace palpate

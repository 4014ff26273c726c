// SPDX-License-Identifier: MIT
#pragma once
/// Features of an insertion. Loss of resistance in a pressure, by the published rule: a drop that
/// lasts more than 5 s with a stable low plateau (Vaira et al. 2019; J Clin Monit Comput
/// 2022;36:283). First puncture, relaxation and withdrawal in the force of an insertion with depth.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "model/problem/recording.hpp"
#include "validation/signal.hpp"

namespace palpate::comparison {

/// Parameters of the rule. Drops are relative to the gauge pressure at the preceding peak.
struct LossRule {
  /// Smallest relative drop. Published means are 0.73 for true and 0.33 for false losses, the rule
  /// of thumb is 0.5, and 6 of 60 true losses were below it; 0.4 is above the false mean and
  /// accepts a true loss of 0.45.
  double least_drop = 0.40;
  double hold = 5.0;          ///< time below the level (1 - least_drop) peak, published [s]
  double settle = 1.0;        ///< delay from the fall to the measurement of the plateau [s]
  double longest_fall = 2.0;  ///< from the peak to that level; a leak is slower (assumed) [s]
  double unsteady = 0.20;     ///< largest 5-95 % range of the plateau over the peak (assumed) [1]
  double least_peak = 0.50;   ///< peak over the largest pressure; flushing is less (assumed) [1]
};

struct LossOfResistance {
  /// Result of the detection. Undecided: the trace ends before `hold`, or a gap hides the fall or
  /// its speed.
  enum class Decision { found, not_found, undecided };
  Decision status = Decision::not_found;
  std::string reason{};          ///< why it was not found
  bool weak = false;             ///< found, but the relative drop is below 0.5
  std::size_t peak_index = 0;    ///< of the largest pressure within `longest_fall` before the fall
  std::size_t fallen_index = 0;  ///< of the first sample below (1 - least_drop) peak
  double peak = not_measured;
  double plateau = not_measured;  ///< median from `settle` to `hold` after the fall, or to the end
  std::size_t plateau_samples = 0;      ///< number of samples in the plateau
  double relative_drop = not_measured;  ///< 1 - plateau / peak

  [[nodiscard]] bool found() const { return status == Decision::found; }
  /// Returns true if the fall can be measured: found, or undecided with samples on the plateau.
  [[nodiscard]] bool fell() const { return status != Decision::not_found && plateau_samples > 0; }
};
std::string_view name_of(LossOfResistance::Decision status);

/// Detects the loss in a filtered trace. The first fall that lasts decides.
LossOfResistance find_loss(const Samples& pressure, const LossRule& rule = {});

// Features of a trace: the event and quantities around it, each with its uncertainty or the reason
// why it is absent. docs/comparison.md defines them.

enum class Feature {
  loss_of_resistance,  ///< [1] 1 found, 0 not found
  peak,           ///< [Pa or N] largest value within 2 s before the fall; without one, of the trace
  drop_height,    ///< [Pa or N] peak - plateau
  relative_drop,  ///< [1] drop_height / peak
  drop_time,      ///< [s] from the last fall through 90 % of the drop to the first through 10 %
  plateau,        ///< [Pa or N] median from 1 s to 5 s after the fall
  slope_before,   ///< [Pa/s or N/s] of a straight line through 2 s that end 0.1 s before the peak
  time_of_peak,   ///< [s] last sample with the peak value
  time_of_loss,   ///< [s] last fall through the middle of the drop
  depth_of_peak,  ///< [m]
  depth_of_loss,  ///< [m]

  // Features of the force of an insertion whose depth is known; InsertionRule has their
  // definitions.
  puncture,          ///< [1] 1 found, 0 not found
  puncture_force,    ///< [N] at the first puncture
  puncture_depth,    ///< [m] of the first puncture below the contact: the dent
  denting_exponent,  ///< [1] p of F ~ d^p before the first puncture, d from the contact
  force_left,        ///< [N] least force within 1 mm after the first puncture
  largest_force,     ///< [N] of the advance
  second_rise,       ///< [N] largest force of the advance after force_left, minus force_left
  relaxation,        ///< [1] drop of the force within 5 s of the hold over that at its begin
  relaxation_time,   ///< [s] until 63 % of that drop
  withdrawal_force,  ///< [N] least force of the withdrawal
  withdrawal_depth,  ///< [m] of the least force below the contact
};
inline constexpr std::size_t feature_count = 22;

/// Features that are measured on one trace.
enum class FeatureSet { loss_of_resistance, insertion };
std::span<const Feature> features_of(FeatureSet set);

std::string_view name_of(Feature feature);  ///< "drop_time"
/// Returns the unit of a feature; `quantity` is the unit of the trace, "Pa" or "N".
std::string unit_of(Feature feature, std::string_view quantity);
/// Returns true for events: 1 found, 0 not found.
bool is_event(Feature feature);
/// Returns true for instants. They are meaningless if the event itself determined the alignment.
bool is_time(Feature feature);

struct Measured {
  std::optional<double> value{};
  double uncertainty = 0.0;  ///< standard uncertainty from noise and sampling only
  std::string reason{};      ///< reason why it is absent
};

/// Parts of an insertion, found from force and depth.
struct InsertionPhases {
  std::optional<std::size_t> contact{};  ///< index of the first sample of contact
  Measured contact_time{};               ///< [s]
  Measured contact_depth{};              ///< [m]
  std::size_t advance_end = 0;           ///< index of the first sample at full depth
  std::size_t hold_end = 0;              ///< index of the last sample at full depth
  bool held = false;                     ///< the needle rests at full depth
  bool withdrawn = false;
  double speed = not_measured;  ///< mean of the advance from the contact [m/s]
};

struct Features {
  std::array<Measured, feature_count> all{};
  LossOfResistance loss{};
  InsertionPhases phases{};  ///< only of the set `insertion`
  double noise = 0.0;        ///< standard deviation of single samples [Pa or N], see noise_of()

  [[nodiscard]] const Measured& operator[](Feature f) const {
    return all[static_cast<std::size_t>(f)];
  }
  Measured& operator[](Feature f) { return all[static_cast<std::size_t>(f)]; }
};

/// Parameters of the features of an insertion that advances, rests and is withdrawn. The puncture
/// is the first local maximum of the advance that is followed by a drop of at least `least_drop`
/// within `drop_distance`. The share lies between the drops and the fluctuations of measured
/// insertions (docs/notebook/measured-insertions.md).
struct InsertionRule {
  ContactRule contact{};
  double least_drop = 0.15;     ///< smallest relative drop [1]
  double drop_distance = 1e-3;  ///< [m]
  double dent_from = 0.10;      ///< shallowest depth of the exponent, as a share of the dent [1]
  double rest = 1.0;            ///< shortest hold [s]
  double still = 1e-4;          ///< largest movement at rest [m]
  double relaxation = 5.0;      ///< time in the hold after which the drop is measured [s]
  double end_mean = 0.2;        ///< time before that over which the force is averaged [s]
};

struct FeatureRule {
  FeatureSet set = FeatureSet::loss_of_resistance;
  InsertionRule insertion{};
  LossRule loss{};
  double slope_window = 2.0;  ///< [s]
  double slope_end = 0.1;     ///< end of the window before the peak [s]
};

/// Trace as sampled and as filtered, with depths on the same grid (empty: not recorded).
struct FeatureInput {
  Samples raw{};
  Samples filtered{};
  Samples depth{};
  double cutoff = 0.0;  ///< cut-off of the filter [Hz]; 0: none
};
Features find_features(const FeatureInput& input, const FeatureRule& rule = {});

/// Returns the standard deviation of white noise on the samples, from the median size of the part
/// that the filter removed (Gaussian: median |r| = 0.6745 standard deviations); 0 without a filter.
double noise_of(const FeatureInput& input);

// Preparation of one trace for comparison: resampled to a uniform grid, filtered, with features.

struct RawTrace {
  std::span<const double> time{};   ///< [s]
  std::span<const double> value{};  ///< [Pa or N]
  std::span<const double> depth{};  ///< [m], or empty
};

struct PreparedTrace {
  FeatureInput input{};
  Features features{};
  std::string refusal{};  ///< why the trace cannot be compared; empty if it can
};

/// Returns the reason why a trace cannot be compared: empty, one sample, times that do not
/// increase, no finite value, a constant, or more than ten million usual intervals. Empty if it
/// can.
std::string refusal_of(const RawTrace& trace);

PreparedTrace prepare(const RawTrace& trace, double cutoff, const FeatureRule& rule);

}  // namespace palpate::comparison

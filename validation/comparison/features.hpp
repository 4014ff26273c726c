// SPDX-License-Identifier: MIT
#pragma once
/// Whether and where a pressure shows the loss of resistance, by the published rule: a drop that is
/// held for more than 5 s with a stable low plateau (Vaira et al. 2019; J Clin Monit Comput
/// 2022;36:283).

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "validation/signal.hpp"

namespace palpate::comparison {

/// Drops are relative to the pressure above zero gauge at the peak before them.
struct LossRule {
  /// Published means are 0.73 for true and 0.33 for false ones, the rule of thumb is 0.5, and 6 of
  /// 60 true ones stayed under it; 0.4 lies above the false mean and lets a true one of 0.45 pass.
  double least_drop = 0.40;
  double hold = 5.0;          ///< [s] under the level (1 - least_drop) peak, published
  double settle = 1.0;        ///< [s] after the fall until the plateau is measured
  double longest_fall = 2.0;  ///< [s] from the peak to that level; a leak is slower (assumed)
  double unsteady = 0.20;     ///< of the peak, largest 5-95 % range of the plateau (assumed)
  double least_peak =
      0.50;  ///< of the largest pressure: flushing a needle is no insertion (assumed)
};

struct LossOfResistance {
  /// Undecided: the trace ends before `hold`, or a gap hides whether, or how fast, the pressure
  /// fell.
  enum class Decision { found, not_found, undecided };
  Decision status = Decision::not_found;
  std::string reason{};          ///< why it was not found
  bool weak = false;             ///< found, but dropped by less than half
  std::size_t peak_index = 0;    ///< the largest pressure within `longest_fall` before the fall
  std::size_t fallen_index = 0;  ///< the first sample under (1 - least_drop) peak
  double peak = not_measured;
  double plateau = not_measured;  ///< median from `settle` to `hold` after the fall, or to the end
  std::size_t plateau_samples = 0;      ///< from which that is
  double relative_drop = not_measured;  ///< 1 - plateau / peak

  [[nodiscard]] bool found() const { return status == Decision::found; }
  /// A fall that can be measured: found, or held as far as the trace tells.
  [[nodiscard]] bool fell() const { return status != Decision::not_found && plateau_samples > 0; }
};
std::string_view name_of(LossOfResistance::Decision status);

/// In a filtered trace. The first fall that holds decides.
LossOfResistance find_loss(const Samples& pressure, const LossRule& rule = {});

// What is judged of a trace: the event and the numbers around it, each with its uncertainty or with
// the reason why it is not there. docs/comparison.md has the definitions for people.

enum class Feature {
  loss_of_resistance,  ///< [1] 1 found, 0 not found
  peak,           ///< [Pa or N] largest value within 2 s before the fall; without one, of the trace
  drop_height,    ///< [Pa or N] peak - plateau
  relative_drop,  ///< [1] drop_height / peak
  drop_time,      ///< [s] last fall through 90 % of the drop to the first through 10 %
  plateau,        ///< [Pa or N] median from 1 s to 5 s after the fall
  slope_before,   ///< [Pa/s or N/s] of a straight line through 2 s that end 0.1 s before the peak
  time_of_peak,   ///< [s] the last sample of that value
  time_of_loss,   ///< [s] last fall through the middle of the drop
  depth_of_peak,  ///< [m]
  depth_of_loss,  ///< [m]
};
inline constexpr std::size_t feature_count = 11;

std::string_view name_of(Feature feature);  ///< "drop_time"
/// `quantity` is the unit of the trace itself, "Pa" or "N".
std::string unit_of(Feature feature, std::string_view quantity);
/// Lies on the time axis, so that it means nothing where this axis was laid by the event itself.
bool is_time(Feature feature);

struct Measured {
  std::optional<double> value{};
  double uncertainty = 0.0;  ///< standard, from noise and sampling alone
  std::string reason{};      ///< why it is absent
};

struct Features {
  std::array<Measured, feature_count> all{};
  LossOfResistance loss{};
  double noise =
      0.0;  ///< standard deviation of single samples [Pa or N], from what the filter took away

  [[nodiscard]] const Measured& operator[](Feature f) const {
    return all[static_cast<std::size_t>(f)];
  }
  Measured& operator[](Feature f) { return all[static_cast<std::size_t>(f)]; }
};

struct FeatureRule {
  LossRule loss{};
  double slope_window = 2.0;  ///< [s]
  double slope_end = 0.1;     ///< [s] before the peak
};

/// A trace as it was sampled and as it is judged, with depths on the same grid (empty: not
/// recorded).
struct FeatureInput {
  Samples raw{};
  Samples filtered{};
  Samples depth{};
  double cutoff = 0.0;  ///< [Hz] of the filter; 0: none
};
Features find_features(const FeatureInput& input, const FeatureRule& rule = {});

/// Standard deviation of white noise on the samples, from the median size of what the filter took
/// away (Gaussian: median |r| = 0.6745 standard deviations); 0 without a filter.
double noise_of(const FeatureInput& input);

// One trace made ready to be compared: on a uniform grid, filtered, its features found, or refused.

struct RawTrace {
  std::span<const double> time{};   ///< [s]
  std::span<const double> value{};  ///< [Pa or N]
  std::span<const double> depth{};  ///< [m], or empty
};

struct PreparedTrace {
  FeatureInput input{};
  Features features{};
  std::string refusal{};  ///< why there is nothing to compare; empty: there is
};

/// Why a trace cannot be compared: empty, one sample, times that do not increase, no number, a
/// constant, or more than ten million of its usual intervals. Empty when it can.
std::string refusal_of(const RawTrace& trace);

PreparedTrace prepare(const RawTrace& trace, double cutoff, const FeatureRule& rule);

}  // namespace palpate::comparison

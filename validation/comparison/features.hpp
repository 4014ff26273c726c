// SPDX-License-Identifier: MIT
#pragma once
/// What is judged of a trace: the event and the numbers around it, each with its uncertainty or with the
/// reason why it is not there. docs/comparison.md has the definitions for people.

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "validation/comparison/loss_of_resistance.hpp"

namespace palpate::comparison {

enum class Feature {
  loss_of_resistance,  ///< [1] 1 found, 0 not found
  peak,                ///< [Pa or N] largest value within 2 s before the fall; without one, of the trace
  drop_height,         ///< [Pa or N] peak - plateau
  relative_drop,       ///< [1] drop_height / peak
  drop_time,           ///< [s] last fall through 90 % of the drop to the first through 10 %
  plateau,             ///< [Pa or N] median from 1 s to 5 s after the fall
  slope_before,        ///< [Pa/s or N/s] of a straight line through 2 s that end 0.1 s before the peak
  time_of_peak,        ///< [s] the last sample of that value
  time_of_loss,        ///< [s] last fall through the middle of the drop
  depth_of_peak,       ///< [m]
  depth_of_loss,       ///< [m]
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
  double noise = 0.0;  ///< standard deviation of single samples [Pa or N], from what the filter took away

  [[nodiscard]] const Measured& operator[](Feature f) const { return all[static_cast<std::size_t>(f)]; }
  Measured& operator[](Feature f) { return all[static_cast<std::size_t>(f)]; }
};

struct FeatureRule {
  LossRule loss{};
  double slope_window = 2.0;  ///< [s]
  double slope_end = 0.1;     ///< [s] before the peak
};

/// A trace as it was sampled and as it is judged, with depths on the same grid (empty: not recorded).
struct FeatureInput {
  Samples raw{};
  Samples filtered{};
  Samples depth{};
  double cutoff = 0.0;  ///< [Hz] of the filter; 0: none
};
Features find_features(const FeatureInput& input, const FeatureRule& rule = {});

/// Standard deviation of white noise on the samples, from the median size of what the filter took away
/// (Gaussian: median |r| = 0.6745 standard deviations); 0 without a filter.
double noise_of(const FeatureInput& input);

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// Parameters of a scene that can be fitted to recordings: layers down to the epidural space and
/// the syringe. Each prior is log-normal about the value of the scene; user settings override the
/// defaults.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::calibration {

/// Half width in standard deviations of the interval that contains 0.95 of a normal distribution.
inline constexpr double normal_factor = 1.959964;

struct Parameter {
  std::string key{};  ///< as in --set: "material.fat.friction", "layer.1.thickness"
  std::string unit{};
  double prior = 0.0;   ///< value of the scene, > 0
  double spread = 0.5;  ///< standard deviation of its logarithm [1]
  double lower = 0.0;   ///< > 0; by default four spreads below the prior
  double upper = 0.0;
  std::string origin{};  ///< source of the spread

  /// Returns the standardised value: 0 is the prior, 1 is one spread above it.
  [[nodiscard]] double standardised(double value) const;
  [[nodiscard]] double value(double standardised) const;
};

/// Sets the bounds from prior and spread.
void set_default_bounds(Parameter& parameter);

/// Returns all parameters of a scene with a value above zero: layers in order, then the syringe.
std::vector<Parameter> parameters_of(const Scene& scene);

/// Returns the reason why a scene cannot be calibrated. It needs a needle on a prescribed path
/// through layers, with a syringe, beyond the epidural space. Empty if it can.
std::string why_not_calibrated(const Scene& scene);

/// Returns the scene with other values. If the thickness of a layer changes, the end depth of the
/// needle and the duration of the scene change accordingly.
Scene with_values(Scene scene, const std::vector<Parameter>& parameters,
                  const std::vector<double>& values);

/// Returns the keys and values in which `changed` differs from `scene`, of those that with_values()
/// may change.
std::vector<std::pair<std::string, double>> changes(const Scene& scene, const Scene& changed);

}  // namespace palpate::calibration

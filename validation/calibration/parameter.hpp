// SPDX-License-Identifier: MIT
#pragma once
/// What of a scene may be fitted to recordings: layers down to the epidural space and the syringe.
/// The prior of each is log-normal about the scene's own value, and what a person says goes before
/// the default.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::calibration {

inline constexpr double normal_factor =
    1.959964;  ///< standard deviations that hold 0.95 of a normal distribution

struct Parameter {
  std::string
      key{};  ///< of the scene, as --set takes it: "material.fat.friction", "layer.1.thickness"
  std::string unit{};
  double prior = 0.0;   ///< the scene's value, > 0
  double spread = 0.5;  ///< standard deviation of its logarithm [1]
  double lower = 0.0;   ///< > 0; by default four spreads below the prior
  double upper = 0.0;
  std::string origin{};  ///< where the spread comes from

  /// Standardised: 0 is the prior, 1 one spread above.
  [[nodiscard]] double standardised(double value) const;
  [[nodiscard]] double value(double standardised) const;
};

/// Bounds that follow from prior and spread.
void set_default_bounds(Parameter& parameter);

/// Every parameter of a scene with a value above zero, in the order of layers, then the syringe.
std::vector<Parameter> parameters_of(const Scene& scene);

/// Needle on a prescribed way, in layers, with a syringe, past the epidural space; else why not.
std::string why_not_calibrated(const Scene& scene);

/// The scene with other values. Where a layer's thickness changes, the way of the needle ends as
/// much deeper and the scene lasts as much longer as that takes.
Scene with_values(Scene scene, const std::vector<Parameter>& parameters,
                  const std::vector<double>& values);

/// Keys and values in which `changed` differs from `scene`, of those that with_values() may change.
std::vector<std::pair<std::string, double>> changes(const Scene& scene, const Scene& changed);

}  // namespace palpate::calibration

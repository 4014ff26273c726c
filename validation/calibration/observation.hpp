// SPDX-License-Identifier: MIT
#pragma once
/// What a calibration looks at: a few numbers of one insertion, found in a recording and in a simulated trace
/// by the same code. docs/calibration.md has the definitions for people.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "model/dynamics/recording.hpp"
#include "model/dynamics/trace.hpp"

namespace palpate::calibration {

/// Of the force, means over the way from `begin` to `end` behind the depth of the loss of resistance.
struct ForceBin {
  double begin = 0.0;  ///< [m]
  double end = 0.0;    ///< [m]
};
/// The last one ends before the filter rounds the fall.
inline constexpr std::array force_bins{ForceBin{-10e-3, -8e-3}, ForceBin{-8e-3, -6e-3},
                                       ForceBin{-6e-3, -4e-3}, ForceBin{-4e-3, -2e-3},
                                       ForceBin{-2e-3, -0.5e-3}};

enum class Observable {
  pressure_peak,  ///< [Pa]
  plateau,        ///< [Pa] after the loss of resistance
  drop_time,      ///< [s]
  depth_of_loss,  ///< [m]
  force_peak,     ///< [N] largest before the loss
  force,          ///< [N] the first of the bins; the others follow
};
inline constexpr Eigen::Index observable_count = 5 + static_cast<Eigen::Index>(force_bins.size());

std::string name_of(Eigen::Index observable);       ///< "force.-10_to_-8_mm"
std::string_view unit_of(Eigen::Index observable);  ///< "Pa", "s", "m", "N"
bool is_pressure(Eigen::Index observable);
bool is_force(Eigen::Index observable);
inline Eigen::Index index_of(Observable observable) { return static_cast<Eigen::Index>(observable); }

/// One number per observable; NaN where it is not there.
using Observation = Eigen::VectorXd;

/// Where the force along the needle comes from.
enum class ForceSource {
  none,      ///< single pushes under a thumb that does not drive the needle
  recorded,  ///< a force was recorded
  plunger,   ///< Eq. 1, F = P A: in the continuous technique the needle is driven through the plunger
};
std::string_view name_of(ForceSource source);
ForceSource force_source(const Recording& recording);

struct ObservedInsertion {
  Observation value{};
  ForceSource force = ForceSource::none;
  std::string refusal{};  ///< why there is nothing to look at
};
ObservedInsertion observe(const Recording& recording, double cutoff = 20.0);

/// Of a simulated insertion with the columns syringe.pressure_pa, tool.force_n and tool.depth_m.
ObservedInsertion observe(const Trace& trace, double cutoff = 20.0);

}  // namespace palpate::calibration

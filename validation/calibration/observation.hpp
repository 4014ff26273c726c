// SPDX-License-Identifier: MIT
#pragma once
/// What a calibration looks at: a few numbers of one insertion, found in a recording and in a
/// simulated trace by the same code. docs/calibration.md has the definitions for people.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"

namespace palpate::calibration {

/// Of the force, means over the way from `begin` to `end` behind the depth of the loss of
/// resistance.
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
inline Eigen::Index index_of(Observable observable) {
  return static_cast<Eigen::Index>(observable);
}

/// One number per observable; NaN where it is not there.
using Observation = Eigen::VectorXd;

/// Where the force along the needle comes from.
enum class ForceSource {
  none,      ///< single pushes under a thumb that does not drive the needle
  recorded,  ///< a force was recorded
  plunger,   ///< Eq. 1, F = P A: in the continuous technique the needle is driven through the
             ///< plunger
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

// Insertions of several subjects as one: means with the covariance of these means.

/// A recording as a calibration sees it, or the mean of several of one person.
struct Subject {
  std::string name{};
  std::string person{};  ///< recordings with the same one, within a group, are of one person;
                         ///< empty: of nobody else
  std::string group{};
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  ObservedInsertion seen{};
  double plunger_area = 1.767e-4;  ///< [m^2]
};

/// Standard uncertainties that all recordings share, so that more of them do not help.
struct SharedUncertainty {
  double zero = 57.0;               ///< [Pa] transducer within 1 cm of the needle's height, uniform
  double gain = 0.01;               ///< [1] of the transducer, assumed
  double plunger_friction = 0.052;  ///< [N] polished dry glass, 5.27 gf (Leiman et al. 1988)
  double force_gain = 0.01;         ///< [1] of a recorded force, assumed
  double depth = 0.5e-3;            ///< [m] half a millimetre of reading, assumed
  double drop_time = 5e-3;          ///< [s] sampling at some 120 Hz
  double model = 0.005;             ///< [1] of forces: the coarser block, docs/calibration.md
};

struct Pooled {
  Eigen::VectorXd mean{};        ///< one per observable; NaN where too few subjects have it
  Eigen::MatrixXd covariance{};  ///< of `mean`; zero rows where that is NaN
  Eigen::MatrixXd
      sampled{};  ///< the part of it that was estimated from these subjects; empty: none
  std::vector<std::size_t> count{};
  std::size_t subjects = 0;
  std::optional<double> body_mass_index{};  ///< mean, where all have one

  [[nodiscard]] std::vector<Eigen::Index> present() const;  ///< what has a mean, in order
  /// Degrees of freedom of the spread between subjects; 0: none was estimated.
  [[nodiscard]] std::size_t degrees_of_freedom() const;
};

/// One for each person: observables are means over the recordings that have them, so that nobody
/// counts twice (Altman & Bland 1997).
std::vector<Subject> by_person(std::span<const Subject> recordings);

/// Fewer subjects than this say nothing about others: uncertainties are then those of measuring
/// alone.
inline constexpr std::size_t least_subjects = 3;

/// [m m^2/kg] Skin to epidural space per unit of BMI (Ravi et al. 2011), all of it in the fat (Bahk
/// et al. 1998).
inline constexpr double depth_per_body_mass_index = 0.9777e-3;

/// Depths are moved to the mean BMI first, where all have one.
Pooled pool(std::span<const Subject> subjects, const SharedUncertainty& shared = {});

}  // namespace palpate::calibration

// SPDX-License-Identifier: MIT
#pragma once
/// Observables of a calibration: a few numbers of one insertion, computed from a recording and from
/// a simulated trace by the same code (docs/calibration.md).

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"
#include "validation/statistics.hpp"

namespace palpate::calibration {

/// Depth interval over which the force is averaged, relative to the depth of the loss of
/// resistance.
struct ForceBin {
  double begin = 0.0;  ///< [m]
  double end = 0.0;    ///< [m]
};
/// Intervals of the force. The last one ends before the filter rounds the drop.
inline constexpr std::array force_bins{ForceBin{-10e-3, -8e-3}, ForceBin{-8e-3, -6e-3},
                                       ForceBin{-6e-3, -4e-3}, ForceBin{-4e-3, -2e-3},
                                       ForceBin{-2e-3, -0.5e-3}};

enum class Observable {
  pressure_peak,  ///< [Pa]
  plateau,        ///< [Pa] after the loss of resistance
  drop_time,      ///< [s]
  depth_of_loss,  ///< [m]
  force_peak,     ///< [N] largest before the loss
  force,          ///< [N] first of the bins; the others follow
};
inline constexpr Eigen::Index observable_count = 5 + static_cast<Eigen::Index>(force_bins.size());

std::string_view name_of(Eigen::Index observable);  ///< "force.-10_to_-8_mm"
std::string_view unit_of(Eigen::Index observable);  ///< "Pa", "s", "m", "N"
inline Eigen::Index index_of(Observable observable) {
  return static_cast<Eigen::Index>(observable);
}

/// Vector with one number per observable; NaN if it is absent.
using Observation = Eigen::VectorXd;

/// Source of the force along the needle.
enum class ForceSource {
  none,      ///< intermittent pushes of a thumb that does not drive the needle
  recorded,  ///< the recorded force
  plunger,   ///< Eq. 1, F = P A: the continuous technique drives the needle through the plunger
};
std::string_view name_of(ForceSource source);
ForceSource force_source(const Recording& recording);

struct ObservedInsertion {
  Observation value{};
  ForceSource force = ForceSource::none;
  std::string refusal{};  ///< why there are no observables
};
ObservedInsertion observe(const Recording& recording, double cutoff = 20.0);

/// Computes the observables of a simulated insertion with the columns syringe.pressure_pa,
/// tool.force_n and tool.depth_m.
ObservedInsertion observe(const Trace& trace, double cutoff = 20.0);

// Pooled observables of several subjects: means and the covariance of these means.

/// A recording with its observables, or a subject with the means over its recordings.
struct ObservedRecording {
  Recording recording{};
  ObservedInsertion seen{};
};

/// Standard uncertainties common to all recordings; more recordings do not reduce them.
struct SharedUncertainty {
  comparison::TransducerUncertainty transducer{};
  double plunger_friction = 0.052;  ///< [N] polished dry glass, 5.27 gf (Leiman et al. 1988)
  double force_gain = 0.01;         ///< [1] of a recorded force, assumed
  double depth = 0.5e-3;            ///< [m] half a millimetre of reading, assumed
  double drop_time = 5e-3;          ///< [s] sampling at some 120 Hz
  double model = 0.005;             ///< [1] of forces: the coarser block, docs/calibration.md
};

struct Pooled {
  Eigen::VectorXd mean{};        ///< one per observable; NaN if too few subjects have it
  Eigen::MatrixXd covariance{};  ///< covariance of `mean`; zero rows where `mean` is NaN
  Eigen::MatrixXd sampled{};     ///< part of it from the spread of these subjects; empty: none
  std::vector<std::size_t> count{};
  std::size_t subjects = 0;
  std::optional<double> body_mass_index{};  ///< mean, if all subjects have one

  [[nodiscard]] std::vector<Eigen::Index> present() const;  ///< observables with a mean, in order
  /// Returns the degrees of freedom of the spread between subjects; 0 if it was not estimated.
  [[nodiscard]] std::size_t degrees_of_freedom() const;
};

/// Returns one element for each subject of a group: observables are means over the recordings that
/// have them, so that every subject has the same weight (Altman & Bland 1997).
std::vector<ObservedRecording> by_subject(std::span<const ObservedRecording> recordings);

/// Minimum number of subjects to estimate the spread; with fewer, only measurement uncertainty is
/// used.
inline constexpr std::size_t least_subjects = 3;

/// Increase of the depth from skin to epidural space per unit of BMI [m m^2/kg] (Ravi et al. 2011),
/// all of it in the fat (Bahk et al. 1998).
inline constexpr double depth_per_body_mass_index = 0.9777e-3;

/// Pools the subjects. Depths are first converted to the mean BMI if all subjects have one.
Pooled pool(std::span<const ObservedRecording> subjects, const SharedUncertainty& shared = {});

}  // namespace palpate::calibration

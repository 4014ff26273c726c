// SPDX-License-Identifier: MIT
#pragma once
/// Several recordings of one subject are not several subjects: the unit of analysis is the subject
/// (Altman and Bland, BMJ 1997;314:1874), of whom the mean of the recordings is the one value that
/// counts (Matthews et al., BMJ 1990;300:230). How much single recordings of one subject differ is
/// kept apart.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/signal.hpp"

namespace palpate::comparison {

/// To which subject each recording belongs, by codes: 0, 1, ... in the order of their first
/// recordings. An empty code is a subject of its own.
std::vector<std::size_t> subject_indices(std::span<const std::string> codes);
/// How many there are.
std::size_t subject_count(std::span<const std::size_t> subject);

/// Values of recordings over their subjects. With values x_ij = m + subject_i + recording_ij, of
/// variances B and W, means of n_i recordings scatter by B + W <1/n_i>, and a single recording of a
/// further subject by B + W.
struct OverSubjects {
  std::vector<double> means{};         ///< one per subject that has a value
  std::size_t recordings = 0;          ///< values
  double mean = not_measured;          ///< of the subjects' means
  double deviation = not_measured;     ///< of these means; NaN below two subjects
  double of_recording = not_measured;  ///< sqrt(B + W), from deviation^2 + W (1 - <1/n_i>)
};
/// Values that are not finite are left out. An empty `subject`: every value is of another one.
OverSubjects over_subjects(std::span<const double> value,
                           std::span<const std::size_t> subject = {});

// What several subjects leave open at each instant, and how much of a simulated trace lies in it.

struct CorridorRule {
  std::size_t least_subjects = 3;  ///< fewer have no standard deviation worth the name
  /// k of mean +- k SD. Absent: the one that a further subject's value lies in with a probability
  /// of 0.95 if subjects are normally distributed, t(0.975, N - 1) sqrt(1 + 1/N) (4.97 for 3
  /// subjects, 2.02 for 60), with the N that were measured at that instant.
  std::optional<double> half_width{};
  double least_inside = 0.90;  ///< of the samples; 0.95 is expected pointwise (assumed margin)
};

/// Mean +- half width on a grid; NaN where fewer than `least_subjects` were measured.
struct SubjectCorridor {
  Samples mean{};        ///< of the subjects' means
  Samples deviation{};   ///< of single recordings of different subjects (subjects.hpp)
  Samples half_width{};  ///< k of as many subjects as were measured there, times the deviation
  std::size_t subjects = 0;
  std::size_t recordings = 0;
  double factor = 0.0;  ///< k, where all subjects were measured
};

/// All on the grid of the first. `refusal` says why there is no corridor.
struct CorridorBuilt {
  std::optional<SubjectCorridor> corridor{};
  std::string refusal{};
};
/// `subject` says whose each is; empty: every one is of another subject.
CorridorBuilt build_corridor(std::span<const Samples> aligned, const CorridorRule& rule = {},
                             std::span<const std::size_t> subject = {});

struct CorridorCoverage {
  std::size_t samples = 0;         ///< judged: where trace and corridor both are
  double inside = 0.0;             ///< share of them within the corridor; NaN without any
  double largest_excursion = 0.0;  ///< beyond the edge, in the traces' unit; 0 when all are inside
  double excursion_time = not_measured;  ///< [s] of it
  bool holds = false;                    ///< inside >= least_inside
};
CorridorCoverage coverage(const SubjectCorridor& corridor, const Samples& simulated,
                          const CorridorRule& rule = {});

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// Several recordings of one subject are not several subjects: the unit of analysis is the subject (Altman
/// and Bland, BMJ 1997;314:1874), of whom the mean of the recordings is the one value that counts (Matthews
/// et al., BMJ 1990;300:230). How much single recordings of one subject differ is kept apart.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "validation/comparison/samples.hpp"

namespace palpate::comparison {

/// To which subject each recording belongs, by codes: 0, 1, ... in the order of their first recordings. An
/// empty code is a subject of its own.
std::vector<std::size_t> subject_indices(std::span<const std::string> codes);
/// How many there are.
std::size_t subject_count(std::span<const std::size_t> subject);

/// Values of recordings over their subjects. With values x_ij = m + subject_i + recording_ij, of variances B
/// and W, means of n_i recordings scatter by B + W <1/n_i>, and a single recording of a further subject by
/// B + W.
struct OverSubjects {
  std::vector<double> means{};        ///< one per subject that has a value
  std::size_t recordings = 0;         ///< values
  double mean = not_measured;         ///< of the subjects' means
  double deviation = not_measured;    ///< of these means; NaN below two subjects
  double of_recording = not_measured; ///< sqrt(B + W), from deviation^2 + W (1 - <1/n_i>)
};
/// Values that are not finite are left out. An empty `subject`: every value is of another one.
OverSubjects over_subjects(std::span<const double> value, std::span<const std::size_t> subject = {});

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// Confidence intervals of a counted share and of a mean over a few subjects.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/signal.hpp"

namespace palpate::comparison {

struct Interval {
  double lower = 0.0;
  double upper = 0.0;
  [[nodiscard]] bool holds(double value) const { return value >= lower && value <= upper; }
};

/// Returns the exact Clopper-Pearson interval for `hits` of `trials` (at least one).
Interval share_interval(std::size_t hits, std::size_t trials, double level = 0.95);

/// Returns the interval, as shares, that contains the measured share of `trials` with probability
/// `level` if the true share is `share` (binomial).
Interval expected_share(double share, std::size_t trials, double level = 0.999);

double mean_of(std::span<const double> value);
/// Returns the sample standard deviation (n - 1); NaN for fewer than two values.
double deviation_of(std::span<const double> value);

struct BootstrapOptions {
  std::size_t draws = 2000;
  double level = 0.95;
  std::uint64_t seed = 1;
};
/// Returns the seeded percentile bootstrap interval of the mean over subjects; absent for fewer
/// than three subjects. With few subjects these intervals are too narrow: for five normal values
/// the coverage is 0.846 instead of 0.95 (Student's t at 1.96 sqrt(4/5)).
std::optional<Interval> bootstrap_mean(std::span<const double> value,
                                       const BootstrapOptions& options = {});

/// Standard uncertainties of a pressure transducer that all its readings share.
struct TransducerUncertainty {
  double zero = 57.0;  ///< [Pa] within 1 cm of the needle's height, uniform
  double gain = 0.01;  ///< [1] assumed, no recording states it
};

/// Returns the t of Student's distribution for which a share of `level` lies between -t and t.
double student_factor(double level, std::size_t degrees_of_freedom);
/// Returns the share of Student's distribution between -factor and factor.
double student_share(double factor, std::size_t degrees_of_freedom);

/// Returns the share of a normal distribution that lies more than `deviations` standard deviations
/// above the mean.
double normal_above(double deviations);

// Statistics with the subject as the unit of analysis (Altman and Bland, BMJ 1997;314:1874): the
// mean of the recordings of a subject is its one value (Matthews et al., BMJ 1990;300:230). The
// variation between recordings of one subject is estimated separately.

/// Returns the subject index of each recording from the codes: 0, 1, ... in the order of the first
/// recordings. An empty code is a separate subject.
std::vector<std::size_t> subject_indices(std::span<const std::string> codes);
/// Returns the number of subjects.
std::size_t subject_count(std::span<const std::size_t> subject);

/// Statistics of values of recordings by subject. For values x_ij = m + subject_i + recording_ij
/// with variances B and W, means of n_i recordings have the variance B + W <1/n_i>, and a single
/// recording of a further subject B + W.
struct OverSubjects {
  std::vector<double> means{};      ///< mean of each subject with a value
  std::size_t recordings = 0;       ///< number of values
  double mean = not_measured;       ///< mean of the subjects' means
  double deviation = not_measured;  ///< standard deviation of these means; NaN for fewer than two
  double of_recording = not_measured;  ///< sqrt(B + W), from deviation^2 + W (1 - <1/n_i>)
};
/// Computes the statistics. Values that are not finite are ignored. If `subject` is empty, every
/// value belongs to a different subject.
OverSubjects over_subjects(std::span<const double> value,
                           std::span<const std::size_t> subject = {});

// Corridor of several subjects at each instant, and coverage of a simulated trace by it.

struct CorridorRule {
  std::size_t least_subjects = 3;  ///< minimum number for a standard deviation
  /// Factor k of mean +- k SD. If absent, k is chosen so that the value of a further subject is
  /// inside with probability 0.95 for normally distributed subjects: t(0.975, N - 1) sqrt(1 + 1/N)
  /// (4.97 for 3 subjects, 2.02 for 60), with the N subjects measured at that instant.
  std::optional<double> half_width{};
  double least_inside = 0.90;  ///< share of samples; 0.95 is expected pointwise (assumed margin)
};

/// Corridor mean +- half width on a grid; NaN if fewer than `least_subjects` were measured.
struct SubjectCorridor {
  Samples mean{};        ///< mean of the subjects' means
  Samples deviation{};   ///< standard deviation of single recordings of different subjects
  Samples half_width{};  ///< k for the number of subjects measured there, times the deviation
  std::size_t subjects = 0;
  std::size_t recordings = 0;
  double factor = 0.0;  ///< k if all subjects were measured
};

/// Corridor on the grid of the first trace, or the reason why there is none.
struct CorridorBuilt {
  std::optional<SubjectCorridor> corridor{};
  std::string refusal{};
};
/// Computes the corridor. `subject` assigns traces to subjects; empty: every trace is a different
/// subject.
CorridorBuilt build_corridor(std::span<const Samples> aligned, const CorridorRule& rule = {},
                             std::span<const std::size_t> subject = {});

struct CorridorCoverage {
  std::size_t samples = 0;         ///< number of samples where both trace and corridor exist
  double inside = 0.0;             ///< share of these samples inside the corridor; NaN without any
  double largest_excursion = 0.0;  ///< from the edge, in the unit of the traces; 0: all inside
  double excursion_time = not_measured;  ///< time of the largest excursion [s]
  bool holds = false;                    ///< inside >= least_inside
};
CorridorCoverage coverage(const SubjectCorridor& corridor, const Samples& simulated,
                          const CorridorRule& rule = {});

}  // namespace palpate::comparison

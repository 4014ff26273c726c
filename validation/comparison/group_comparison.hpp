// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of several recordings with one simulated insertion: each alone, and each group with
/// its corridor.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/comparison/comparison.hpp"
#include "validation/comparison/subject_corridor.hpp"
#include "validation/statistics.hpp"

namespace palpate::comparison {

/// One feature over the subjects of a group.
struct FeatureSummary {
  Feature feature{};
  std::string unit{};
  std::size_t count = 0;       ///< subjects who have it
  double mean = not_measured;  ///< over subjects, of whom several recordings are averaged first
  double deviation = not_measured;  ///< between subjects; NaN below two
  std::optional<Interval>
      interval{};  ///< 95 % bootstrap of the mean, percentile; absent below three
  std::optional<double> simulated{};  ///< mean over the comparisons, whose filters may differ
};

struct GroupSummary {
  std::string group{};
  std::size_t recordings = 0;
  std::size_t measured = 0;  ///< of them; the others were rebuilt from published values
  std::size_t subjects = 0;  ///< who could be compared
  std::size_t agree = 0, not_distinguishable = 0, differ = 0, not_comparable = 0;  ///< recordings
  std::size_t subjects_agree = 0;     ///< all of whose recordings that could be compared agree
  double agree_share = not_measured;  ///< of the subjects
  Interval agree_interval{};          ///< 95 % Clopper-Pearson
  std::vector<FeatureSummary> features{};
  std::vector<FeatureComparison>
      means{};  ///< against the mean over subjects; only where there is a corridor
  std::optional<SubjectCorridor> corridor{};  ///< on the simulation's clock
  Samples simulated{};          ///< on the corridor's grid, where any of them was compared with it
  CorridorCoverage coverage{};  ///< of that
  std::string corridor_refusal{};  ///< why there is none
  Outcome outcome{.suite = "comparison",
                  .claim = "The simulated insertion agrees with the subjects of the group.",
                  .status = Status::error};
};

struct GroupOptions {
  ComparisonOptions comparison{};
  CorridorRule corridor{};
  BootstrapOptions bootstrap{};
};

struct GroupComparison {
  std::vector<Comparison> recordings{};  ///< in the order given
  std::vector<GroupSummary> groups{};    ///< in the order of their first recordings
  /// Its status is the worst of the groups that could be compared.
  Outcome outcome{.name = "comparison",
                  .suite = "comparison",
                  .claim = "The simulated insertion agrees with the recordings.",
                  .status = Status::error};
};

/// The verdict of a group with a corridor: the mean error of every feature against its tolerance
/// with the spread of the mean over subjects as uncertainty, and whether the trace lies in the
/// corridor. Of one too small for a corridor: the worst of its recordings. Subjects differ from
/// each other, so a simulated insertion need not agree with each of them.
GroupComparison compare_all(std::span<const Recording> recordings, const Trace& simulated,
                            const GroupOptions& options = {});

}  // namespace palpate::comparison

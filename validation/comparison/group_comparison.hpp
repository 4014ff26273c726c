// SPDX-License-Identifier: MIT
#pragma once
/// Several recordings against one simulated insertion: each alone, each group, and all as a corridor.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/comparison/comparison.hpp"
#include "validation/comparison/statistics.hpp"
#include "validation/comparison/subject_corridor.hpp"

namespace palpate::comparison {

/// One feature over the subjects of a group.
struct FeatureSummary {
  Feature feature{};
  std::string unit{};
  std::size_t count = 0;                  ///< recordings that have it
  double mean = not_measured;
  double deviation = not_measured;        ///< NaN below two
  std::optional<Interval> interval{};     ///< 95 % bootstrap of the mean, percentile; absent below three
  std::optional<double> simulated{};      ///< of the first recording's comparison
};

struct GroupSummary {
  std::string group{};
  std::size_t recordings = 0;
  std::size_t measured = 0;               ///< of them; the others were rebuilt from published values
  std::size_t agree = 0, not_distinguishable = 0, differ = 0, not_comparable = 0;
  double agree_share = not_measured;      ///< agree over those that could be compared
  Interval agree_interval{};              ///< 95 % Clopper-Pearson
  std::vector<FeatureSummary> features{};
  std::vector<FeatureVerdict> means{};    ///< against the mean over subjects; only where there is a corridor
  std::optional<SubjectCorridor> corridor{};  ///< on the simulation's clock
  Samples simulated{};                    ///< on the corridor's grid, where any of them was compared with it
  CorridorCoverage coverage{};            ///< of that
  std::string corridor_refusal{};         ///< why there is none
  Verdict verdict = Verdict::not_comparable;
  std::vector<std::string> reasons{};
};

struct GroupOptions {
  ComparisonOptions comparison{};
  CorridorRule corridor{};
  BootstrapOptions bootstrap{};
};

struct GroupComparison {
  std::vector<Comparison> recordings{};   ///< in the order given
  std::vector<GroupSummary> groups{};     ///< in the order of their first recordings
  Verdict verdict = Verdict::not_comparable;  ///< the worst of the groups that could be compared
  std::vector<std::string> reasons{};
};

/// The verdict of a group with a corridor: the mean error of every feature against its tolerance with the
/// spread of the mean over subjects as uncertainty, and whether the trace lies in the corridor. Of one too
/// small for a corridor: the worst of its recordings. Subjects differ from each other, so a simulated
/// insertion need not agree with each of them.
GroupComparison compare_all(std::span<const Recording> recordings, const Trace& simulated,
                            const GroupOptions& options = {});

}  // namespace palpate::comparison

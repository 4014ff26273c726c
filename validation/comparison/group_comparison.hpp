// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of several recordings with one simulated insertion: each recording separately, and
/// each group with its corridor.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "validation/comparison/comparison.hpp"
#include "validation/outcome.hpp"
#include "validation/statistics.hpp"

namespace palpate::comparison {

/// Statistics of one feature over the subjects of a group.
struct FeatureSummary {
  Feature feature{};
  std::string unit{};
  std::size_t count = 0;            ///< number of subjects with the feature
  double mean = not_measured;       ///< over the means of the recordings of each subject
  double deviation = not_measured;  ///< standard deviation between subjects; NaN for fewer than two
  /// 95 % percentile bootstrap interval of the mean; absent for fewer than three subjects.
  std::optional<Interval> interval{};
  std::optional<double> simulated{};  ///< mean over the comparisons, whose filters may differ
};

struct GroupSummary {
  std::string group{};
  std::size_t recordings = 0;
  std::size_t measured = 0;  ///< recordings that were measured, but not in a phantom
  std::size_t phantoms = 0;  ///< recordings that were measured in a phantom
  /// Number of subjects that could be compared. Each recording of a phantom
  /// counts as a subject: it enters a new position, and too few needles are used to tell their
  /// spread from that of the positions.
  std::size_t subjects = 0;
  [[nodiscard]] bool of_phantom() const { return phantoms == recordings && recordings > 0; }
  Tally tally{};                      ///< verdicts on the recordings
  std::size_t subjects_agree = 0;     ///< number of subjects whose comparable recordings all agree
  double agree_share = not_measured;  ///< share of the subjects that agree
  Interval agree_interval{};          ///< 95 % Clopper-Pearson
  std::vector<FeatureSummary> features{};
  std::vector<FeatureComparison> means{};  ///< with the mean over subjects; only with a corridor
  bool only_curve_differs = false;         ///< the features agree; the corridor or a curve does not
  std::optional<SubjectCorridor> corridor{};  ///< on the clock of the simulation
  /// Corridor of the advance of insertions over the depth below the contact; it is not judged.
  std::optional<SubjectCorridor> advance_corridor{};
  Samples simulated{};          ///< on the grid of the corridor, where any recording was compared
  CorridorCoverage coverage{};  ///< coverage of the simulated trace
  std::string corridor_refusal{};  ///< why there is no corridor
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
  /// Verdict; its status is the worst of the groups that could be compared.
  Outcome outcome{.name = "comparison",
                  .suite = "comparison",
                  .claim = "The simulated insertion agrees with the recordings.",
                  .status = Status::error};
};

/// Compares recordings with a simulated insertion, by group. In a group with a corridor, the mean
/// error of every feature is compared with its tolerance, with the spread of the mean over subjects
/// as uncertainty, and the trace must lie in the corridor. In a smaller group, the worst recording
/// decides. Subjects differ from each other, so a simulated insertion need not agree with each of
/// them. The tolerances of an insertion in a group of at least three recordings are two standard
/// deviations over these recordings, unless tolerances are given.
GroupComparison compare_all(std::span<const Recording> recordings, const Trace& simulated,
                            const GroupOptions& options = {});

// Credibility factors of ASME V&V 40-2018 and the available evidence.

struct CredibilityFactor {
  enum class Shown { not_shown, in_part, shown };
  std::string activity{};  ///< verification, validation or applicability
  std::string factor{};
  std::string goal{};  ///< sufficient evidence for a training simulator
  Shown shown = Shown::not_shown;
  std::string evidence{};  ///< available evidence with counts; "not shown" and why otherwise
  std::vector<std::string> links{};  ///< names of cases or recordings
};
std::string_view name_of(CredibilityFactor::Shown shown);  ///< "not shown", "in part", "shown"

/// Returns the factors from the outcomes of a validation (empty: not run) and an optional
/// comparison. A factor that depends on cases is shown if all of them pass, in part if some do.
/// Recordings of phantoms and those that were reconstructed from published values are no clinical
/// evidence and leave the factors of validation "not shown".
std::vector<CredibilityFactor> credibility(std::span<const Outcome> outcomes,
                                           const GroupComparison* comparison);

}  // namespace palpate::comparison

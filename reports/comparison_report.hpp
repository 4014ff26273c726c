// SPDX-License-Identifier: MIT
#pragma once
/// comparison.json and report.html of `palpate compare`.

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "reports/recording_input.hpp"
#include "validation/comparison/comparison.hpp"
#include "validation/comparison/credibility.hpp"
#include "validation/comparison/group_comparison.hpp"

namespace palpate {

struct ComparedRecording {
  std::filesystem::path file{};
  std::string hash{};  ///< of the file (content_hash.hpp)
  InputRecording input{};
};

struct ComparedSimulation {
  enum class Origin { scene, trace };
  Origin origin = Origin::trace;
  std::filesystem::path file{};
  std::string hash{};   ///< of the file
  std::string title{};  ///< of the scene
  double run_longer =
      0.0;  ///< [s] after the scene's duration, for the rule that finds the loss of resistance
  std::string failure{};  ///< "diverged at t = 0.1 s"; nothing can be compared then
  Trace trace{};
};

struct ComparisonReport {
  comparison::GroupOptions options{};
  std::vector<ComparedRecording> recordings{};
  ComparedSimulation simulation{};
  comparison::GroupComparison found{};  ///< its recordings in the order of those above
  std::vector<comparison::CredibilityFactor> credibility{};
  std::map<std::string, std::string> provenance{};
  std::string command{};  ///< that gives the same again
};

/// True if everything agrees and every recording could be compared; exit code 0.
bool holds(const ComparisonReport& report);

std::string to_html(const ComparisonReport& report);

// Texts about a whole comparison.

/// "3 measured recordings", "5 recordings reconstructed from published summary values", or both.
std::string kinds_of(const ComparisonReport& report);

/// "1 differs", "4 agree, 1 cannot be compared": counts of recordings.
std::string tally_of(const ComparisonReport& report);

/// "5 subjects", "5 subjects (10 recordings)".
std::string subjects_of(const comparison::SubjectCorridor& corridor);

/// Over all groups.
std::size_t subjects_compared(const ComparisonReport& report);

/// "without a group" of an empty one.
std::string name_of_group(const std::string& group);

/// The verdict with a capital letter, and one sentence with its basis.
std::string verdict_text(const ComparisonReport& report);
std::string verdict_sentence(const ComparisonReport& report);

/// "12 missing in 3 gaps, 2 bad frames"; "nothing" where nothing was found.
std::string shown(const RecordingDefects& defects);

// Figures of recorded and simulated traces over time and depth, and of their difference.

/// Figures of one recording that could be compared: pressure and force over time and over depth, if
/// recorded or simulated, and the residual. Time is that of the simulation.
std::vector<Figure> recording_figures(const ComparisonReport& report, std::size_t recording);

/// The compared quantity over time.
Figure overlay_figure(const ComparisonReport& report, std::size_t recording);

/// Figures of a group: the corridor with the simulated trace, and its difference from the mean.
/// Empty without a corridor.
std::vector<Figure> group_figures(const ComparisonReport& report, std::size_t group);

// comparison.json (docs/formats.md).

std::string to_json(const ComparisonReport& report);

}  // namespace palpate

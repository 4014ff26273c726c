// SPDX-License-Identifier: MIT
#pragma once
/// Contents of comparison.json and report.html of `palpate compare`.

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "reports/html/html_page.hpp"
#include "reports/recording_input.hpp"
#include "validation/comparison/comparison.hpp"
#include "validation/comparison/group_comparison.hpp"

namespace palpate {

struct ComparedSimulation {
  enum class Origin { scene, trace };
  Origin origin = Origin::trace;
  std::filesystem::path file{};
  std::string hash{};       ///< hash of the file contents
  std::string title{};      ///< title of the scene
  double run_longer = 0.0;  ///< time simulated after the scene's duration [s]
  std::string failure{};    ///< "diverged at t = 0.1 s"; if not empty, nothing is compared
  Trace trace{};
};

struct ComparisonReport {
  comparison::GroupOptions options{};
  std::vector<RecordingFile> recordings{};
  ComparedSimulation simulation{};
  comparison::GroupComparison found{};  ///< results, with recordings in the order of `recordings`
  std::vector<comparison::CredibilityFactor> credibility{};
  std::map<std::string, std::string> provenance{};
  std::string command{};  ///< command line that reproduces the report
};

/// Returns true if every recording is comparable and agrees with the simulation (exit code 0).
bool holds(const ComparisonReport& report);

std::string to_html(const ComparisonReport& report);

/// Counts of recordings by verdict: "1 differs", "4 agree, 1 cannot be compared".
std::string tally_of(const ComparisonReport& report);

/// Verdict as a title with a capital letter, and as one sentence with its basis.
std::string verdict_text(const ComparisonReport& report);
std::string verdict_sentence(const ComparisonReport& report);

/// Defects of a recording as text: "12 missing in 3 gaps, 2 bad frames"; "nothing" if there are
/// none.
std::string shown(const RecordingDefects& defects);

/// Figures of one comparable recording: pressure and force, if recorded or simulated, over time and
/// over depth, and the residual. The time axis is the simulation time.
std::vector<Figure> recording_figures(const ComparisonReport& report, std::size_t recording);

/// Figures of a group: the corridor with the simulated trace, and the difference of the trace from
/// the mean. Empty if the group has no corridor.
std::vector<Figure> group_figures(const ComparisonReport& report, std::size_t group);

/// Section of a page for one group: its figures and a table of its features.
Section group_section(const ComparisonReport& report, std::size_t group);

// comparison.json (docs/formats.md).

std::string to_json(const ComparisonReport& report);

/// Parses a tolerance: "peak=15%", "plateau=7mmHg", "slope_before=30%+5mmHg/s", "drop_time=x2",
/// "relative_drop=0.2". The value is a fraction of the recorded value, a width with unit (SI if
/// none), their sum, or a factor. Throws InputError.
comparison::Tolerance tolerance_from(const std::string& text, comparison::QuantityKind quantity);

/// Default tolerances of all features, one per line in the same syntax: "peak=10.2%".
std::string tolerance_help(comparison::QuantityKind quantity);

}  // namespace palpate

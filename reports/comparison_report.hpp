// SPDX-License-Identifier: MIT
#pragma once
/// report.html of `palpate compare`: what was compared with what, how it came out, and why.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "reports/recording_input.hpp"
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
      0.0;                ///< [s] after the scene's duration, for the rule that finds the loss of resistance
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

/// Everything agrees and every recording could be compared: exit code 0.
bool holds(const ComparisonReport& report);

/// Throws DrawingError.
std::string to_html(const ComparisonReport& report);

}  // namespace palpate

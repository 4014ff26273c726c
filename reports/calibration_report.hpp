// SPDX-License-Identifier: MIT
#pragma once
/// Contents of calibration.json and report.html: fitted parameters with intervals, parameters that
/// the recordings do not constrain, and checks of the fit.

#include <map>
#include <string>
#include <vector>

#include "reports/comparison_report.hpp"
#include "validation/calibration/calibration.hpp"
#include "validation/calibration/insertion_fit.hpp"
#include "validation/outcome.hpp"

namespace palpate {

struct CalibratedRecording {
  std::string file{};  ///< file name without folder
  std::string hash{};  ///< hash of the file contents
  calibration::ObservedRecording observed{};
};

struct CalibrationReport {
  std::string scene{};  ///< file name
  std::string scene_hash{};
  calibration::Calibration result{};
  std::vector<CalibratedRecording> recordings{};
  std::string command{};
  std::map<std::string, std::string> provenance{};  ///< only on the page; differs between runs

  [[nodiscard]] bool reconstructed() const;  ///< true if at least one recording is reconstructed
};

std::string calibration_verdict(const CalibrationReport& report);  ///< verdict in one line
std::string calibration_detail(
    const CalibrationReport& report);  ///< details in one or two sentences
/// Warnings about the limits of the result.
std::vector<std::string> calibration_warnings(const CalibrationReport& report);

/// Contents of calibration.json. Output is deterministic.
std::string to_json(const CalibrationReport& report);
std::string to_html(const CalibrationReport& report);

/// Calibration with insertions of several conditions.
struct InsertionFitReport {
  calibration::InsertionFit result{};
  std::vector<ComparisonReport> conditions{};  ///< of `result.conditions`, in their order
  std::string command{};
  std::map<std::string, std::string> provenance{};  ///< only on the page
};

std::string calibration_verdict(const InsertionFitReport& report);
std::vector<std::string> calibration_warnings(const InsertionFitReport& report);
std::string to_json(const InsertionFitReport& report);
std::string to_html(const InsertionFitReport& report);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// calibration.json and report.html of a calibration: fitted parameters with intervals, parameters
/// that the recordings do not constrain, and checks of the fit.

#include <map>
#include <string>
#include <vector>

#include "validation/calibration/calibration.hpp"
#include "validation/outcome.hpp"

namespace palpate {

struct CalibratedRecording {
  std::string file{};  ///< name alone
  std::string hash{};  ///< of its bytes
  std::string source{};
  std::string technique{};
  Recording::Kind kind = Recording::Kind::measured;
  calibration::Subject subject{};
};

struct CalibrationReport {
  std::string scene{};  ///< file name
  std::string scene_hash{};
  calibration::Calibration result{};
  std::vector<CalibratedRecording> recordings{};
  std::string command{};
  std::map<std::string, std::string>
      provenance{};  ///< may differ from run to run; in the page alone

  [[nodiscard]] bool reconstructed() const;  ///< at least one recording is no measurement
};

std::string calibration_verdict(const CalibrationReport& report);  ///< one line
std::string calibration_detail(const CalibrationReport& report);   ///< one or two sentences
/// Limits of the result that a reader must know.
std::vector<std::string> calibration_warnings(const CalibrationReport& report);

/// Same input, same bytes.
std::string to_json(const CalibrationReport& report);
std::string to_html(const CalibrationReport& report);

std::vector<Table> calibration_tables(const CalibrationReport& report);
std::vector<Figure> calibration_figures(const CalibrationReport& report);

}  // namespace palpate

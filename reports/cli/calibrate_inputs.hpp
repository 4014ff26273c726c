// SPDX-License-Identifier: MIT
#pragma once
/// What `palpate calibrate` is given, read and checked.

#include "reports/calibration_report.hpp"
#include "reports/cli/commands.hpp"

namespace palpate::cli {

/// Every recording observed. Throws InputError, one line per problem, for one that cannot be read, was
/// pumped, shows no loss of resistance, or stands there twice.
std::vector<CalibratedRecording> read_calibrated(const std::vector<std::filesystem::path>& paths);

/// Parameters of the scene, as options change them: --parameter, --prior KEY=VALUE:SPREAD, --bounds
/// KEY=LOWER:UPPER. Throws InputError.
std::vector<calibration::Parameter> chosen_parameters(const CalibrateOptions& options, const Scene& scene);

}  // namespace palpate::cli

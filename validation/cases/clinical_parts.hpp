// SPDX-License-Identifier: MIT
#pragma once
/// What the group "clinical" is made of. The candidate of these cases is a simulated pressure (or, for the
/// rule that finds the event, a made-up insertion): planted faults damage that.

#include <vector>

#include "validation/case.hpp"

namespace palpate::clinical {

std::vector<Case>
measure_cases();  ///< distances, ratings and filter against closed forms and a second opinion
std::vector<Case> feature_cases();    ///< features of traces whose law is known
std::vector<Case> verdict_cases();    ///< what each measure is blind to, and the verdict that is not
std::vector<Case> detection_cases();  ///< how often the event is found, and is found where there is none
std::vector<Case> subject_cases();    ///< corridor and bootstrap over subjects
std::vector<Case> round_trip_cases(); ///< simulated, recorded through the link, compared
std::vector<Case> calibration_cases();  ///< parameters from recordings

}  // namespace palpate::clinical

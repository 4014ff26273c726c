// SPDX-License-Identifier: MIT
#pragma once
/// Recorded and simulated traces laid over each other, over time and depth, and what is left between them.

#include <cstddef>
#include <vector>

#include "reports/comparison_report.hpp"

namespace palpate {

/// Of one recording that could be compared: pressure and force over time and over depth, as far as each was
/// recorded or simulated, and the residual. Time is the simulation's.
std::vector<Figure> recording_figures(const ComparisonReport& report, std::size_t recording);

/// The quantity that was compared, over time alone.
Figure overlay_figure(const ComparisonReport& report, std::size_t recording);

/// Of a group: its corridor with the simulated trace in it, and what that lacks to the mean. Empty without a
/// corridor.
std::vector<Figure> group_figures(const ComparisonReport& report, std::size_t group);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Plots of long traces to zoom into, drawn by dygraphs, which is inlined.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// A folded section with a place for each figure; all series of a figure share their x.
std::string html_zoom_section(const std::vector<Figure>& figures);

/// The script that fills the section when it is unfolded. Series keep the extremes of each of 2000
/// columns.
std::string zoom_script(const std::vector<Figure>& figures);

}  // namespace palpate

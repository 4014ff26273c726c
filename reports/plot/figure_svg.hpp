// SPDX-License-Identifier: MIT
#pragma once
/// Figures as SVG elements for a page. Colours are classes of report.css, so that figures follow
/// the light or dark theme. Output is deterministic.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Returns one <svg> element per figure, in order, without title and legend. Long series are
/// thinned to the resolution of the picture.
std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures);

/// Returns the legend of a figure as an HTML list; empty if there are neither series labels nor
/// marks.
std::string html_legend(const Figure& figure);

}  // namespace palpate

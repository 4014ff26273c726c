// SPDX-License-Identifier: MIT
#pragma once
/// Figures as SVG elements for a page. Colours are classes of report.css, so that a figure follows
/// the light or dark theme of the page. The same figure gives the same bytes.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Returns one <svg> element per figure, in order, without title and legend. Long series are
/// thinned to what the picture can show.
std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures);

/// The legend of a figure as an HTML list; empty if no series has a label and there are no marks.
std::string html_legend(const Figure& figure);

}  // namespace palpate

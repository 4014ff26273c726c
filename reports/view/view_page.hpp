// SPDX-License-Identifier: MIT
#pragma once
/// Page section with the 3-D view of a run, and its pictures for print and for browsers without
/// WebGL.

#include <string>
#include <vector>

#include "reports/html/html_page.hpp"
#include "reports/view/view.hpp"

namespace palpate {

/// Section of the tissue at the plane of the cut: undeformed by tissue, and at the largest reaction
/// by displacement.
std::vector<Figure> still_figures(const View& view);

/// Section without the start script: markup, style, pictures, numbers and three.js, all inline.
Section view_section(const View& view);

/// Script that starts the view; it must be the last script of the page.
std::string view_script();

}  // namespace palpate

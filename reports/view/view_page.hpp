// SPDX-License-Identifier: MIT
#pragma once
/// Still pictures of a view as SVG, painted from back to front without a GPU, for print and for
/// browsers without WebGL.

#include <string>

#include "reports/view/view.hpp"

namespace palpate {

/// SVG of the undeformed tissue in the colours of its labels.
std::string still_at_rest(const View& view);

/// SVG of one frame, coloured by displacement. Displacements are scaled by `enlarged`.
std::string still_at(const View& view, std::size_t frame, double enlarged);

// Page section with the 3-D view of a run and its still pictures.

/// HTML of the section without the start script: markup, style, numbers and three.js, all inline.
std::string html_view(const View& view);

/// Script that starts the view; it must be the last script of the page.
std::string view_script();

}  // namespace palpate

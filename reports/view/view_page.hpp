// SPDX-License-Identifier: MIT
#pragma once
/// Still pictures of a view, painted from far to near without a GPU: for paper, and for browsers
/// that cannot show the view itself.

#include <string>

#include "reports/view/view.hpp"

namespace palpate {

/// <svg> of the undeformed tissue in the colours of what it is made of.
std::string still_at_rest(const View& view);

/// <svg> at a frame, coloured by displacement, whose movement is `enlarged` so many times.
std::string still_at(const View& view, std::size_t frame, double enlarged);

// The section of a page that shows a run in three dimensions, and its still pictures.

/// Everything but the script: markup, style, numbers and three.js, all inline.
std::string html_view(const View& view);

/// The script that starts it; the last of a page.
std::string view_script();

}  // namespace palpate

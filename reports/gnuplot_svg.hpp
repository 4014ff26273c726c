// SPDX-License-Identifier: MIT
#pragma once
/// gnuplot's SVG written again for a page: a tenth of the bytes, no ids, and classes of report.css
/// instead of colours, so that a picture follows the page's theme.

#include <string>

namespace palpate {

/// `label` is what a screen reader says instead of the picture.
std::string svg_for_page(const std::string& gnuplot, const std::string& label);

}  // namespace palpate

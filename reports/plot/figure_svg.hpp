// SPDX-License-Identifier: MIT
#pragma once
/// gnuplot's SVG written again for a page: a tenth of the bytes, no ids, and classes of report.css
/// instead of colours, so that a picture follows the page's theme.

#include <stdexcept>
#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// `label` is what a screen reader says instead of the picture.
std::string svg_for_page(const std::string& gnuplot, const std::string& label);

// Figures as SVG for a page, drawn by gnuplot: same data, same bytes. Colours and lines are
// classes of report.css, so that a figure follows the page's light or dark theme.

/// gnuplot is not installed, or failed.
class DrawingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One <svg> element per figure, in order, without title and legend. All are drawn by one gnuplot
/// process. Throws DrawingError.
std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures);

/// The legend of a figure as an HTML list; empty when its series have no labels.
std::string html_legend(const Figure& figure);

}  // namespace palpate

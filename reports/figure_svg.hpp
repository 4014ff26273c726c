// SPDX-License-Identifier: MIT
#pragma once
/// Figures as SVG for a page, drawn by gnuplot: same data, same bytes. Colours are CSS variables of
/// the page (html_style.css), so that a figure follows its light or dark theme.

#include <stdexcept>
#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// gnuplot is not installed, or failed.
class DrawingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One <svg> element per figure, in order. All are drawn by one gnuplot process. Throws
/// DrawingError.
std::vector<std::string> draw_figures(const std::vector<const Figure*>& figures);

}  // namespace palpate

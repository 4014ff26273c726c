// SPDX-License-Identifier: MIT
#pragma once
/// A Figure in gnuplot's language.

#include <string>

#include "validation/outcome.hpp"

namespace palpate {

/// Draws the figure into the file `output`, without title and legend, which are text of the page.
/// Long series are thinned to what the picture can show (thinning.hpp).
std::string gnuplot_script(const Figure& in_si, const std::string& output);

}  // namespace palpate

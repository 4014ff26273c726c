// SPDX-License-Identifier: MIT
#pragma once
/// The section of a page that shows a run in three dimensions, and its still pictures.

#include <string>

#include "reports/view.hpp"

namespace palpate {

/// Everything but the script: markup, style, numbers and three.js, all inline.
std::string html_view(const View& view);

/// The script that starts it; the last of a page.
std::string view_script();

}  // namespace palpate

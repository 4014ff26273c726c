// SPDX-License-Identifier: MIT
#pragma once
/// Text inside HTML, SVG and XML, and numbers as people read them.

#include <string>
#include <string_view>

namespace palpate {

/// & < > " ' escaped; control characters that XML forbids become a question mark.
std::string escape_markup(std::string_view text);

/// Shortest text that reads back as the same double; "nan", "inf", "-inf".
std::string exact_number(double value);

/// Four significant digits: "0.001234", "1.235e-07", "12350".
std::string short_number(double value);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Text inside HTML, SVG and XML; numbers are told in the words of number_words.hpp.

#include <string>
#include <string_view>

#include "validation/number_words.hpp"

namespace palpate {

/// & < > " ' escaped; control characters, which XML forbids, become a question mark, and
/// broken UTF-8 the sign that Unicode has for it.
std::string escape_markup(std::string_view text);

}  // namespace palpate

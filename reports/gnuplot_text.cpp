// SPDX-License-Identifier: MIT
#include "reports/gnuplot_text.hpp"

#include <array>
#include <cstdio>
#include <string_view>

namespace palpate {

std::string colour(int stand_in, const char* what) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), " %s rgb \"#%02x%02x%02x\"", what, StandIn::red,
                StandIn::green, stand_in);
  return buffer.data();
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (std::string_view("\"'\\`@").find(c) == std::string_view::npos) {
      out += c == '\n' ? ' ' : c;
      continue;
    }
    std::array<char, 8> code{};
    std::snprintf(code.data(), code.size(), "\\%03o", static_cast<unsigned>(c));
    out += code.data();
  }
  return out + "\"";
}

int point_type(Shape shape) {
  constexpr std::array<int, shape_count> types{7, 5, 9, 13, 6, 4};
  return types.at(static_cast<std::size_t>(shape));
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/gnuplot_text.hpp"

#include <array>
#include <cstdio>

namespace palpate {

std::string colour(int stand_in, const char* what) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), " %s rgb \"#%02x%02x%02x\"", what, StandIn::red,
                StandIn::green, stand_in);
  return buffer.data();
}

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) { out += c == '\'' ? "''" : std::string(1, c == '\n' ? ' ' : c); }
  return out + "'";
}

int point_type(Shape shape) {
  constexpr std::array<int, shape_count> types{7, 5, 9, 13, 6, 4};
  return types.at(static_cast<std::size_t>(shape));
}

}  // namespace palpate

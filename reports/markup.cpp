// SPDX-License-Identifier: MIT
#include "reports/markup.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace palpate {

std::string escape_markup(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += static_cast<unsigned char>(c) < 32 && c != '\n' && c != '\t' ? '?' : c;
    }
  }
  return out;
}

std::string exact_number(double value) {
  if (std::isnan(value)) { return "nan"; }
  if (std::isinf(value)) { return value > 0.0 ? "inf" : "-inf"; }
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string short_number(double value) {
  if (!std::isfinite(value)) { return exact_number(value); }
  if (value == std::round(value) && std::abs(value) < 1e6) {
    return std::to_string(static_cast<long>(value));
  }
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.4g", value);
  return buffer.data();
}

}  // namespace palpate

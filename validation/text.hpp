// SPDX-License-Identifier: MIT
#pragma once
/// Composition of text.

#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Returns numbers in a printf format; at most 199 bytes.
template <class... Numbers> std::string formatted(const char* format, Numbers... numbers) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, numbers...);
  return text.data();
}

/// Returns the parts with a separator between them.
inline std::string join(const std::vector<std::string>& parts, std::string_view separator = ", ") {
  std::string text;
  for (const std::string& part : parts) {
    text.append(&part == parts.data() ? "" : separator).append(part);
  }
  return text;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of numbers to text for programs and for readers.

#include <array>
#include <cstdio>
#include <ctime>
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

/// Returns the shortest text that parses to the same double; "nan", "inf", "-inf".
std::string exact_number(double value);

/// Returns a number for programs with at most `digits` significant digits: "0.001234", "1.235e-07",
/// "12350".
std::string plain_number(double value, int digits = 4);

/// Returns a number for readers: "0.001234", "1.235 × 10⁻⁷", "12 350", "−3". The text has no line
/// break opportunity.
std::string short_number(double value, int digits = 4);

/// Returns a number with its unit for readers, without a line break opportunity.
std::string quantity(double value, std::string_view unit);

/// Time in UTC as in ISO 8601: "2026-11-25T17:57:05Z".
std::string utc_text(std::time_t time);

/// Returns the number of digits (at least 4) at which the texts of two numbers differ.
int digits_apart(double a, double b);

}  // namespace palpate

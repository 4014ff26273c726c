// SPDX-License-Identifier: MIT

#include "validation/number_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace palpate {

namespace {

std::string superscript(int exponent) {
  constexpr std::array digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) {
    text += digits.at(static_cast<std::size_t>(c - '0'));
  }
  return text;
}

/// Groups digits with narrow spaces from five digits on: "12350" to "12 350".
std::string grouped(const std::string& digits) {
  const std::size_t point = std::min(digits.find('.'), digits.size());
  std::string text;
  for (std::size_t n = 0; n < digits.size(); ++n) {
    const bool group = point > 4 && n > 0 && n < point && (point - n) % 3 == 0;
    text += (group ? "\u202f" : "") + std::string(1, digits[n]);
  }
  return text;
}

/// Rounds a number to `digits` significant digits if the result is a whole number below a million,
/// which is then written without a power of ten.
double rounded(double size, int digits) {
  if (!(size < 1e6) || size < 1.0) { return size; }
  const double unit = std::pow(10.0, std::floor(std::log10(size)) + 1.0 - digits);
  return unit < 1.0 ? size : unit * std::round(size / unit);
}

}  // namespace

std::string exact_number(double value) {
  if (std::isnan(value)) { return "nan"; }  // to_chars() writes the sign of NaN
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string plain_number(double value, int digits) {
  if (!std::isfinite(value)) { return exact_number(value); }
  if (value == std::round(value) && std::abs(value) < 1e6) {
    return std::to_string(static_cast<long>(value));
  }
  return formatted("%.*g", digits, value);
}

std::string short_number(double value, int digits) {
  if (std::isnan(value)) { return "not a number"; }
  if (std::isinf(value)) { return value > 0.0 ? "∞" : "−∞"; }
  const std::string plain = plain_number(rounded(std::abs(value), digits), digits);
  const std::string sign = value < 0.0 ? "−" : "";
  const std::size_t e = plain.find('e');
  if (e == std::string::npos) { return sign + grouped(plain); }
  const std::string mantissa = plain.substr(0, e);
  const std::string power = "10" + superscript(std::stoi(plain.substr(e + 1)));
  return sign + (mantissa == "1" ? power : mantissa + "\u202f×\u202f" + power);
}

std::string utc_text(std::time_t time) {
  std::tm parts{};
  gmtime_r(&time, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

std::string quantity(double value, std::string_view unit) {
  return short_number(value) + "\u00a0" + std::string(unit);
}

int digits_apart(double a, double b) {
  int digits = 4;
  while (digits < 17 && a != b && plain_number(a, digits) == plain_number(b, digits)) { ++digits; }
  return digits;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Numbers as programs and as people read them.

#include <string>
#include <string_view>

namespace palpate {

/// Shortest text that reads back as the same double; "nan", "inf", "-inf".
std::string exact_number(double value);

/// For programs, at most that many significant digits: "0.001234", "1.235e-07", "12350".
std::string plain_number(double value, int digits = 4);

/// For people: "0.001234", "1.235 × 10⁻⁷", "12 350", "−3"; no break inside.
std::string short_number(double value, int digits = 4);

/// A number with its unit, for people; no break inside.
std::string quantity(double value, std::string_view unit);

/// How many digits, four or more, two numbers need that they do not read the same.
int digits_apart(double a, double b);

}  // namespace palpate

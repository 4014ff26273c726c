// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace palpate::cli {

/// A number from `least` to `most`, and nothing else: CLI::Range lets NaN pass, as no comparison with it
/// holds.
inline CLI::Validator number_range(double least, double most) {
  const auto check = [least, most](std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) { return {}; }
    return "Value " + text + " not in range " + CLI::detail::to_string(least) + " to " +
           CLI::detail::to_string(most);
  };
  return CLI::Validator(check, "FLOAT in [" + CLI::detail::to_string(least) + " - " +
                                   CLI::detail::to_string(most) + "]");
}

}  // namespace palpate::cli

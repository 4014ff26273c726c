// SPDX-License-Identifier: MIT
#include "reports/json_trouble.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace palpate {

InputError json_trouble(const std::string& file, const std::string& text, const std::exception& problem,
                        const std::string& allowed) {
  if (const auto* broken = dynamic_cast<const nlohmann::json::parse_error*>(&problem)) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(broken->byte, text.size()));
    const auto line = 1 + std::count(text.begin(), end, '\n');
    const char* found = broken->byte > text.size() ? ": ends in the middle of its JSON; " : ": not JSON from here on; ";
    return InputError(file + ":" + std::to_string(line) + found + allowed);
  }
  std::string what = problem.what();
  // The library's messages begin with its own name and number of the error.
  if (dynamic_cast<const nlohmann::json::exception*>(&problem) != nullptr) { what.erase(0, what.find("] ") + 2); }
  return InputError(file + ": " + what + "; " + allowed);
}

}  // namespace palpate

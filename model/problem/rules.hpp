// SPDX-License-Identifier: MIT
#pragma once
/// Collection of the rules that a scene breaks (scene_check.hpp).

#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Formats a number with at most `digits` digits for messages.
inline std::string number_in_words(double value, int digits = 6) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.*g", digits, value);
  return buffer.data();
}

/// Returns the dotted key of a list member, e.g. "layer[2].thickness".
inline std::string at(std::string_view table, std::size_t index, std::string_view key) {
  return std::string(table) + "[" + std::to_string(index) + "]." + std::string(key);
}

/// Violation of a rule: the dotted key ("tissue.lattice.spacing", "layer[2].thickness") and a
/// message with the value found and the allowed values.
struct Violation {
  std::string key{};
  std::string message{};
};

/// Collects violations.
class Rules {
 public:
  /// Adds a violation if `holds` is false.
  void must(bool holds, std::string key, std::string message) {
    if (!holds) { broken_.push_back({std::move(key), std::move(message)}); }
  }
  [[nodiscard]] bool none_broken() const { return broken_.empty(); }
  [[nodiscard]] std::vector<Violation> take() { return std::move(broken_); }

 private:
  std::vector<Violation> broken_{};
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// How the rules of a scene are written down: "this must hold, else say so" (scene_check.hpp).

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

inline std::string number_in_words(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%g", value);
  return buffer.data();
}

/// Key of a member of a list: "layer[2].thickness".
inline std::string at(std::string_view table, std::size_t index, std::string_view key) {
  return std::string(table) + "[" + std::to_string(index) + "]." + std::string(key);
}

/// One broken rule: the dotted key it is about ("tissue.lattice.spacing", "layer[2].thickness")
/// and what was found and what is allowed.
struct Violation {
  std::string key{};
  std::string message{};
};

/// Collects violations.
class Rules {
 public:
  void must(bool holds, std::string key, std::string message) {
    if (!holds) { broken_.push_back({std::move(key), std::move(message)}); }
  }
  void positive(double value, std::string key, std::string_view unit) {
    must(std::isfinite(value) && value > 0.0, std::move(key),
         number_in_words(value) + " " + std::string(unit) + "; must be > 0");
  }
  void non_negative(double value, std::string key, std::string_view unit) {
    must(std::isfinite(value) && value >= 0.0, std::move(key),
         number_in_words(value) + " " + std::string(unit) + "; must be >= 0");
  }
  [[nodiscard]] bool none_broken() const { return broken_.empty(); }
  [[nodiscard]] std::vector<Violation> take() { return std::move(broken_); }

 private:
  std::vector<Violation> broken_{};
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Whole numbers in few bytes for a script to read (assets/view_bytes.js): differences to what came
/// before, their bytes in planes, deflated, as base64.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

class PackedBytes {
 public:
  void add_bytes(std::span<const std::uint8_t> values);
  /// Of `bits` 16 or 32: differences of neighbours, then all their lowest bytes, all the next, ...
  void add_differences(std::span<const std::int64_t> values, int bits);
  /// The same of the differences to other values in the same places.
  void add_changes(std::span<const std::int16_t> values, std::span<const std::int16_t> before);
  /// Everything so far, deflated (RFC 1950).
  [[nodiscard]] std::string deflated() const;

 private:
  std::vector<std::uint8_t> bytes_;
};

/// RFC 1950. Throws std::runtime_error when zlib fails.
std::string deflate(std::string_view bytes);

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace palpate

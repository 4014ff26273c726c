// SPDX-License-Identifier: MIT
#pragma once
/// Whole numbers in few bytes for a script to read (assets/view_bytes.js): differences to what came
/// before, their bytes in planes, deflated, as base64.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reports/view/view.hpp"

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

// Colours of tissue, in the view and in its still pictures alike.

using Rgb = std::array<double, 3>;  ///< 0 to 1, sRGB

/// From pale at `share` 0 to dark at 1.
Rgb scale_colour(double share);

/// One for each label, by what it says: skin, fat, ligament, bone ...; others come from a list.
std::vector<Rgb> tissue_colours(const std::vector<std::string>& labels);

/// "#1f968b".
std::string hex_colour(const Rgb& colour);

// A view as the text that assets/view_tissue.js reads: a header in JSON, and numbers quantised and
// packed.

/// Most bytes that the numbers of a view may take in a page.
inline constexpr std::size_t most_view_bytes = 4'000'000;

struct EncodedView {
  std::string header{};              ///< JSON; holds no '<'
  std::string numbers{};             ///< base64 of deflated bytes
  std::vector<std::string> notes{};  ///< what was given up for size
};

/// Displacements to 1/32767 of the largest coordinate; where that takes more than `most` bytes
/// coarser ones, then every second frame until it fits.
EncodedView encode(View view, std::size_t most = most_view_bytes);

}  // namespace palpate

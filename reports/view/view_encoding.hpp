// SPDX-License-Identifier: MIT
#pragma once
/// Compact encoding of integers for a script (assets/view_bytes.js): differences of neighbouring
/// values, split into byte planes, deflated, base64.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "reports/html/html_page.hpp"
#include "reports/view/view.hpp"

namespace palpate {

class PackedBytes {
 public:
  void add_bytes(std::span<const std::uint8_t> values);
  /// Appends differences of neighbouring values, with `bits` 16 or 32: first all lowest bytes, then
  /// all second bytes, and so on.
  void add_differences(std::span<const std::int64_t> values, int bits);
  /// Appends differences between two arrays in the same encoding.
  void add_changes(std::span<const std::int16_t> values, std::span<const std::int16_t> before);
  /// Returns all appended bytes, deflated (RFC 1950).
  [[nodiscard]] std::string deflated() const;

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Compresses bytes (RFC 1950). Throws std::runtime_error if zlib fails.
std::string deflate(std::string_view bytes);

/// Encodes bytes as base64 (RFC 4648), with padding.
std::string base64(std::string_view bytes);

using Rgb = std::array<double, 3>;  ///< red, green, blue in 0 to 1, sRGB

/// Colour between neighbouring codes 0xrrggbb, from the first at `share` 0 to the last at 1.
Rgb interpolated_colour(std::span<const unsigned> codes, double share);

// View as text for assets/view_tissue.js: a JSON header and packed quantised numbers.

/// Maximum size of the encoded numbers of a view in a page [bytes].
inline constexpr std::size_t most_view_bytes = 4'000'000;

struct EncodedView {
  std::string header{};              ///< JSON without the character '<'
  std::string numbers{};             ///< deflated bytes in base64
  std::vector<std::string> notes{};  ///< reductions made to limit the size
};

/// Encodes a view. Displacements are quantised to 1/32767 of the largest coordinate. If the result
/// exceeds `most` bytes, every second frame is removed until it fits.
EncodedView encode(View view, std::size_t most = most_view_bytes);

// Page section with the 3-D view of a run, and its pictures for print and for browsers without
// WebGL.

/// Section of the tissue at the plane of the cut: undeformed by tissue, and at the largest reaction
/// by displacement.
std::vector<Figure> still_figures(const View& view);

/// Section without the start script: markup, style, pictures, numbers and three.js, all inline.
Section view_section(const View& view);

/// Script that starts the view; it must be the last script of the page.
std::string view_script();
/// Parts of that script up to the start, for a page that starts the view itself.
std::string view_parts();
/// Script that is not executed, as a container of a text of the page.
std::string inert_script(const std::string& id, const std::string& type, const std::string& text);

}  // namespace palpate

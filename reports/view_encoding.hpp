// SPDX-License-Identifier: MIT
#pragma once
/// A view as the text that assets/view_tissue.js reads: a header in JSON, and numbers quantised and packed.

#include <string>

#include "reports/view.hpp"

namespace palpate {

/// Most bytes that the numbers of a view may take in a page.
inline constexpr std::size_t most_view_bytes = 4'000'000;

struct EncodedView {
  std::string header{};              ///< JSON; holds no '<'
  std::string numbers{};             ///< base64 of deflated bytes
  std::vector<std::string> notes{};  ///< what was given up for size
};

/// Displacements to 1/32767 of the largest coordinate; where that takes more than `most` bytes coarser ones, then
/// every second frame until it fits.
EncodedView encode(View view, std::size_t most = most_view_bytes);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Colours of tissue, in the view and in its still pictures alike.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

using Rgb = std::array<double, 3>;  ///< 0 to 1, sRGB

/// From pale at `share` 0 to dark at 1.
Rgb scale_colour(double share);

/// One for each label, by what it says: skin, fat, ligament, bone ...; others come from a list.
std::vector<Rgb> tissue_colours(const std::vector<std::string>& labels);

/// "#1f968b".
std::string hex_colour(const Rgb& colour);

}  // namespace palpate

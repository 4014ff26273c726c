// SPDX-License-Identifier: MIT
#include "reports/view_palette.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

namespace palpate {

namespace {

constexpr Rgb rgb(unsigned code) {
  return {static_cast<double>(code >> 16U & 255U) / 255.0, static_cast<double>(code >> 8U & 255U) / 255.0,
          static_cast<double>(code & 255U) / 255.0};
}

/// magma of matplotlib from its light end on, without the darkest eighth and with a greyer beginning: what is zero
/// is pale and has no hue.
constexpr std::array<Rgb, 8> magma{rgb(0xf4ede4), rgb(0xfdc697), rgb(0xfb8861), rgb(0xe75263),
                                   rgb(0xb73779), rgb(0x822681), rgb(0x51127c), rgb(0x1d1147)};

/// The first word that a label holds decides.
constexpr std::array<std::pair<std::string_view, Rgb>, 12> by_word{{{"skin", rgb(0xe3b196)},
                                                                    {"fat", rgb(0xf1d58a)},
                                                                    {"epidural", rgb(0x9cc7dd)},
                                                                    {"dura", rgb(0x8793c0)},
                                                                    {"flavum", rgb(0xd9a441)},
                                                                    {"supraspinous", rgb(0xc9b8a8)},
                                                                    {"interspinous", rgb(0xb9938a)},
                                                                    {"ligament", rgb(0xc7ad94)},
                                                                    {"muscle", rgb(0xb5645a)},
                                                                    {"bone", rgb(0xeee7d3)},
                                                                    {"nodule", rgb(0x8e6bb0)},
                                                                    {"disc", rgb(0x86b39a)}}};
constexpr std::array<Rgb, 6> others{rgb(0xe0b79c), rgb(0x8fb8a8), rgb(0xb7a3cf),
                                    rgb(0xd69a7c), rgb(0x93b5d6), rgb(0xc3bf7d)};

}  // namespace

Rgb scale_colour(double share) {
  const double along = std::clamp(share, 0.0, 1.0) * static_cast<double>(magma.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(along), magma.size() - 2);
  const double rest = along - static_cast<double>(below);
  Rgb colour{};
  for (std::size_t n = 0; n < 3; ++n) { colour[n] = (1.0 - rest) * magma[below][n] + rest * magma[below + 1][n]; }
  return colour;
}

std::vector<Rgb> tissue_colours(const std::vector<std::string>& labels) {
  std::vector<Rgb> colours;
  std::size_t other = 0;
  for (const std::string& label : labels) {
    const auto found =
        std::ranges::find_if(by_word, [&](const auto& each) { return label.find(each.first) != std::string::npos; });
    colours.push_back(found != by_word.end() ? found->second : others[other++ % others.size()]);
  }
  return colours;
}

std::string hex_colour(const Rgb& colour) {
  std::string text = "#";
  for (const double part : colour) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x",
                  static_cast<unsigned>(std::lround(255.0 * std::clamp(part, 0.0, 1.0))) & 255U);
    text += digits.data();
  }
  return text;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "reports/plot/zone_labels.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

namespace palpate {

namespace {

constexpr double gap = 1.0;  // between a label and the border of its zone or another label

constexpr double overhang = 8.0;  // beyond the right edge, into the empty margin

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

/// Shortens a text to fit with "…"; empty if fewer than three letters fit.
std::string shortened(const std::string& text, double room) {
  if (text_width(text) <= room) { return text; }
  std::string cut = text;
  while (!cut.empty()) {
    while (cut.size() > 1 && continues_character(cut.back())) { cut.pop_back(); }
    cut.pop_back();
    while (!cut.empty() && cut.back() == ' ') { cut.pop_back(); }
    if (cut.size() < 3) { return {}; }
    if (text_width(cut + "…") <= room) { return cut + "…"; }
  }
  return cut;
}

/// Splits a text at the space that gives the shortest longer part; empty without a space.
std::vector<std::string> halves(const std::string& text) {
  std::vector<std::string> best;
  double least = 0.0;
  for (std::size_t at = text.find(' '); at != std::string::npos; at = text.find(' ', at + 1)) {
    const std::vector<std::string> lines{text.substr(0, at), text.substr(at + 1)};
    const double longer = std::max(text_width(lines[0]), text_width(lines[1]));
    if (best.empty() || longer < least) { best = lines, least = longer; }
  }
  return best;
}

ZoneLabel label_of(std::vector<std::string> lines, double middle, bool upright) {
  double length = 0.0;
  for (const std::string& line : lines) { length = std::max(length, text_width(line)); }
  const double stack = zone_line * static_cast<double>(lines.size());
  return {std::move(lines), middle, upright ? stack : length, upright ? length : stack, upright};
}

/// Layout with the smallest height that fits between the borders of the zone.
std::optional<ZoneLabel> within(const ZoneSpan& zone, double tallest) {
  const double room = zone.end - zone.begin - 2.0 * gap;
  const double middle = 0.5 * (zone.begin + zone.end);
  std::optional<ZoneLabel> best;
  const auto offer = [&](ZoneLabel label) {
    if (label.width > room || label.height > tallest) { return; }
    if (!best || label.height < best->height) { best = std::move(label); }
  };
  const std::vector<std::string> two = halves(zone.label);
  for (const bool upright : {false, true}) {
    offer(label_of({zone.label}, middle, upright));
    if (!two.empty()) { offer(label_of(two, middle, upright)); }
  }
  return best;
}

bool collides(const ZoneLabel& label, const std::vector<ZoneLabel>& others) {
  return std::ranges::any_of(others, [&](const ZoneLabel& other) {
    return std::abs(label.middle - other.middle) < 0.5 * (label.width + other.width) + gap;
  });
}

/// Vertical label at the centre of its zone, shifted slightly if necessary to avoid other labels.
std::optional<ZoneLabel> squeezed(const ZoneSpan& zone, double width, double tallest,
                                  const std::vector<ZoneLabel>& others) {
  const std::string text = shortened(zone.label, tallest);
  if (text.empty()) { return {}; }
  ZoneLabel label = label_of({text}, 0.5 * (zone.begin + zone.end), true);
  const double own = label.middle;
  for (const double aside : {0.0, 2.0, -2.0, 4.0, -4.0}) {
    label.middle = std::clamp(own + aside, 0.5 * label.width, width + overhang - 0.5 * label.width);
    if (!collides(label, others)) { return label; }
  }
  return {};
}

}  // namespace

double text_width(const std::string& text, double font) {
  double em = 0.0;
  for (const char c : text) {
    if (continues_character(c)) { continue; }
    const bool narrow = std::string_view("iljtfr.,:;'!|()[] ").find(c) != std::string_view::npos;
    const bool wide = std::string_view("mwMW").find(c) != std::string_view::npos;
    em += narrow ? 0.34 : wide ? 0.88 : c >= 'A' && c <= 'Z' ? 0.70 : 0.58;
  }
  return font * em;
}

std::vector<ZoneLabel> place_zone_labels(const std::vector<ZoneSpan>& zones, double width,
                                         double tallest) {
  std::vector<ZoneLabel> placed;
  std::vector<const ZoneSpan*> rest;
  for (const ZoneSpan& zone : zones) {
    if (zone.label.empty()) { continue; }
    if (auto label = within(zone, tallest)) {
      placed.push_back(std::move(*label));
    } else {
      rest.push_back(&zone);
    }
  }
  std::ranges::stable_sort(
      rest, [](const auto* a, const auto* b) { return a->end - a->begin > b->end - b->begin; });
  for (const ZoneSpan* zone : rest) {
    if (auto label = squeezed(*zone, width, tallest, placed)) {
      placed.push_back(std::move(*label));
    }
  }
  return placed;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/zone_labels.hpp"

#include <algorithm>
#include <cmath>

#include "tests/check.hpp"

using namespace palpate;

namespace {

const ZoneLabel* find(const std::vector<ZoneLabel>& labels, const std::string& first_line) {
  const auto found = std::ranges::find_if(
      labels, [&](const ZoneLabel& label) { return label.lines.front() == first_line; });
  return found == labels.end() ? nullptr : &*found;
}

bool overlap(const std::vector<ZoneLabel>& labels) {
  for (std::size_t a = 0; a < labels.size(); ++a) {
    for (std::size_t b = a + 1; b < labels.size(); ++b) {
      const double apart = std::abs(labels[a].middle - labels[b].middle);
      if (apart < 0.5 * (labels[a].width + labels[b].width)) { return true; }
    }
  }
  return false;
}

/// The seven layers in front of the spinal canal, 46 mm on 400 pixels.
std::vector<ZoneSpan> spine() {
  return {{"skin", 0.0, 17.0},
          {"subcutaneous fat", 17.0, 59.0},
          {"supraspinous ligament", 59.0, 85.0},
          {"interspinous ligament", 85.0, 312.0},
          {"ligamentum flavum", 312.0, 341.0},
          {"epidural space", 341.0, 394.0},
          {"dura", 394.0, 400.0}};
}

}  // namespace

TEST("wide zones are labelled along, narrow ones upright or in two lines, and none is lost") {
  const std::vector<ZoneLabel> labels = place_zone_labels(spine(), 400.0, 120.0);
  CHECK(labels.size() == 7);
  const ZoneLabel* wide = find(labels, "interspinous ligament");
  CHECK(wide != nullptr && !wide->upright);
  const ZoneLabel* narrow = find(labels, "supraspinous");
  CHECK(narrow != nullptr && narrow->upright && narrow->lines.size() == 2);
  const ZoneLabel* thinnest = find(labels, "dura");
  CHECK(thinnest != nullptr && thinnest->upright);
}

TEST("no two labels overlap and none leaves the plot") {
  std::vector<ZoneSpan> crowd;
  for (int n = 0; n < 120; ++n) {
    crowd.push_back({"layer with a long name", 3.4 * n, 3.4 * (n + 1)});
  }
  for (const std::vector<ZoneSpan>& zones : {spine(), crowd}) {
    const std::vector<ZoneLabel> labels = place_zone_labels(zones, 400.0, 120.0);
    CHECK(!labels.empty() && !overlap(labels));
    for (const ZoneLabel& label : labels) {
      CHECK(label.middle - 0.5 * label.width >= -1e-9 && label.height <= 120.0);
      CHECK(label.middle + 0.5 * label.width <= 400.0 + 8.0 + 1e-9);
    }
  }
}

TEST("a label too long for the plot is shortened between characters") {
  const std::vector<ZoneLabel> labels =
      place_zone_labels({{"äääääääääääääääääääää", 0.0, 20.0}}, 400.0, 50.0);
  CHECK(labels.size() == 1);
  const std::string& text = labels.front().lines.front();
  CHECK(text.ends_with("…") && text_width(text) <= 50.0);
  CHECK((text.size() - std::string("…").size()) % 2 == 0);  // ä has two bytes
}

TEST("a zone without a label or without width has none") {
  CHECK(place_zone_labels({{"", 0.0, 100.0}}, 400.0, 100.0).empty());
  CHECK(place_zone_labels({ZoneSpan{}}, 400.0, 100.0).empty());
}

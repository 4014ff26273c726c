// SPDX-License-Identifier: MIT
#include "reports/falcon_report.hpp"

#include <algorithm>
#include <cmath>

#include "tests/check.hpp"

using namespace palpate;

namespace {

/// A box of half sides 3, 4 and 10 N, its corners in no order that is round.
FalconFacts box() {
  FalconFacts facts;
  for (unsigned n = 0; n < 8; ++n) {
    const unsigned corner = (5 * n) % 8;
    facts.force_corners[n] = {(corner & 1U) != 0U ? 3.0 : -3.0, (corner & 2U) != 0U ? 4.0 : -4.0,
                              (corner & 4U) != 0U ? 10.0 : -10.0};
  }
  facts.weakest_force = 3.0;
  facts.axial_force = 10.0;
  return facts;
}

/// Shoelace formula.
double area_of(const Series& outline) {
  double twice = 0.0;
  for (std::size_t n = 1; n < outline.x.size(); ++n) {
    twice += outline.x[n - 1] * outline.y[n] - outline.x[n] * outline.y[n - 1];
  }
  return 0.5 * twice;
}

const Fact* fact(const std::vector<Fact>& facts, const std::string& label) {
  const auto found = std::ranges::find(facts, label, &Fact::label);
  return found == facts.end() ? nullptr : &*found;
}

}  // namespace

TEST("the reach of the motors is drawn as closed outlines of the box seen from two sides") {
  const Figure figure = force_reach_figure(box());
  CHECK(figure.square);
  CHECK(figure.series.size() == 4);
  const double areas[] = {4.0 * 3.0 * 10.0, 4.0 * 4.0 * 10.0};
  for (std::size_t side = 0; side < 2; ++side) {
    const Series& outline = figure.series[side];
    CHECK(outline.x.size() == 5);  // four corners, and the first again
    CHECK(outline.x.front() == outline.x.back() && outline.y.front() == outline.y.back());
    CHECK_NEAR(area_of(outline), areas[side], 1e-12);
  }
}

TEST("what every direction can have is a circle inside both outlines, and the axes hold all") {
  const Figure figure = force_reach_figure(box());
  const Series& circle = figure.series[2];
  for (std::size_t n = 0; n < circle.x.size(); ++n) {
    CHECK_NEAR(std::hypot(circle.x[n], circle.y[n]), 3.0, 1e-12);
  }
  for (const Series& series : figure.series) {
    for (std::size_t n = 0; n < series.x.size(); ++n) {
      CHECK(std::max(std::abs(series.x[n]), std::abs(series.y[n])) <= *figure.y.maximum);
    }
  }
}

TEST("a device that lost its place or its line is told, and a sound one is not") {
  FalconFacts facts = box();
  facts.ticks = 1000;
  facts.saturated = 25;
  CHECK(fact(falcon_fact_list(facts), "ticks without a place") == nullptr);
  CHECK(fact(falcon_fact_list(facts), "requests without reply") == nullptr);
  CHECK(fact(falcon_fact_list(facts), "motors at their limit")->value == "2.5\u00a0%");
  facts.unhomed = 7;
  facts.unanswered = 9;
  CHECK(fact(falcon_fact_list(facts), "ticks without a place")->value == "7");
  CHECK(fact(falcon_fact_list(facts), "requests without reply")->value == "9");
}

TEST("a trace without a device has no figures of one") {
  CHECK(falcon_figures(Trace{}).empty());
}

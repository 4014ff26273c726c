// SPDX-License-Identifier: MIT

#include "reports/plot/figure_layout.hpp"

#include "tests/check.hpp"
#include "tests/reports/sample_results.hpp"

namespace PALPATE_FILE {

using namespace palpate;

int labelled(const std::vector<Tick>& ticks) {
  return static_cast<int>(
      std::ranges::count_if(ticks, [](const Tick& t) { return !t.label.empty(); }));
}

TEST("a logarithmic axis has two to ten labels inside its range, whatever it spans") {
  for (const double low : {1e-300, 3e-17, 0.04, 0.97, 1.0, 7.0, 123.0}) {
    for (const double ratio : {1.02, 1.5, 3.0, 12.0, 90.0, 1e3, 1e7, 1e20, 1e290}) {
      const Range range{low, low * ratio, false};
      const std::vector<Tick> ticks = logarithmic_ticks(range);
      CHECK(labelled(ticks) >= 2);
      CHECK(labelled(ticks) <= 10);
      for (const Tick& tick : ticks) {
        CHECK(tick.value >= range.low);
        CHECK(tick.value <= range.high);
      }
    }
  }
}

TEST("a linear axis has three to eight ticks with distinct labels inside its range") {
  for (const double low : {-1e9, -3.0, -1e-9, 0.0, 0.123, 1000.0, 7e7}) {
    for (const double span : {1e-3, 0.7, 1.0, 19.0, 2e5}) {
      const std::vector<Tick> ticks = linear_ticks({low, low + span, false}, 8);
      CHECK(ticks.size() >= 3);
      CHECK(ticks.size() <= 9);
      std::vector<std::string> labels;
      for (const Tick& tick : ticks) {
        CHECK(tick.value >= low);
        CHECK(tick.value <= low + span);
        labels.push_back(tick.label + "^" + tick.exponent);
      }
      CHECK(std::ranges::adjacent_find(labels) == labels.end());
    }
  }
}

TEST("a small tick label is a power of ten") {
  const std::vector<Tick> ticks = linear_ticks({0.0, 1e-4, false}, 5);
  CHECK(ticks.at(1).label == "2·10");
  CHECK(ticks.at(1).exponent == "−5");
  CHECK(ticks.back().label == "10");
  CHECK(ticks.back().exponent == "−4");
  CHECK(linear_ticks({-0.5, 0.5, false}, 5).front().label == "−0.4");
}

TEST("an axis spans what can be drawn, the whole cells of a heat map, or nothing") {
  Figure figure = sample::curve();
  figure.series[0].y[0] = -5.0;
  figure.series[0].y[1] = unbounded;
  CHECK(y_range(figure).low > 0.0);
  CHECK(y_range(figure).high < 10.0);
  CHECK(x_range(Figure{}).empty);
  CHECK(y_range(Figure{.series = {{.x = {1.0}, .y = {std::nan("")}}}}).empty);
  const Figure map = sample::map();             // centres from 0 to 2.75 in steps of 0.25
  CHECK_NEAR(x_range(map).low, -0.125, 1e-12);  // rounding of a sum
  CHECK_NEAR(x_range(map).high, 2.875, 1e-12);
}

Figure with_y(const std::string& label, double largest) {
  return {.x = {.label = "time (s)"},
          .y = {.label = label},
          .series = {{.x = {0.0, 1.0}, .y = {0.0, largest}}}};
}

TEST("each size has its prefix, unknown and logarithmic axes have none, equal scales stay equal") {
  const Figure millimetres = in_field_units(with_y("displacement (m)", 9e-4));
  CHECK(millimetres.y.label == "displacement (mm)");
  CHECK_NEAR(millimetres.series[0].y[1], 0.9, 1e-15);  // one rounding
  CHECK(millimetres.x.label == "time (s)");
  CHECK(millimetres.series[0].x[1] == 1.0);
  for (const auto& [label, largest, shown] : {
           std::tuple{"p (Pa)", 2.5e4, "p (kPa)"},
           std::tuple{"p (Pa)", 2.5e3, "p (Pa)"},
           std::tuple{"f (N)", 3e-7, "f (µN)"},
           std::tuple{"t (s)", 1e5, "t (s)"},
           std::tuple{"n (1)", 1e-5, "n (1)"},
           std::tuple{"x", 1e-5, "x"},
       }) {
    CHECK(in_field_units(with_y(label, largest)).y.label == shown);
  }
  Figure logarithmic = with_y("e (m)", 1e-5);
  logarithmic.y.logarithmic = true;
  CHECK(in_field_units(logarithmic).y.label == "e (m)");
  const Figure square = in_field_units({.x = {.label = "x (m)"},
                                        .y = {.label = "z (m)"},
                                        .series = {{.x = {0.0, 0.005}, .y = {0.0, 5e-6}}},
                                        .square = true});
  CHECK(square.x.label == "x (mm)");
  CHECK(square.y.label == "z (mm)");
}

const Projection plain = [](double x, double y) { return Pixel{x, y}; };

bool has(const std::vector<std::size_t>& kept, std::size_t index) {
  return std::ranges::find(kept, index) != kept.end();
}

TEST("a rising curve keeps every extreme of its edges and at most four samples of a pixel column") {
  Series series, band{.style = Series::Style::band};
  for (int n = 0; n < 100000; ++n) {
    series.x.push_back(n / 1000.0);
    series.y.push_back(std::sin(0.37 * n) + (n == 77777 ? 50.0 : 0.0) - (n == 33333 ? 50.0 : 0.0));
  }
  for (int n = 0; n < 5000; ++n) {
    band.x.push_back(n / 1000.0);
    band.y.push_back(n == 1234 ? -9.0 : 0.0);
    band.y2.push_back(n == 4321 ? 9.0 : 1.0);
  }
  const std::vector<std::size_t> kept = thinned(series, plain);
  for (const std::size_t extreme : {77777U, 33333U, 0U, 99999U}) { CHECK(has(kept, extreme)); }
  CHECK(kept.size() <= 400);
  CHECK(kept.size() >= 300);
  CHECK(std::ranges::is_sorted(kept));
  const std::vector<std::size_t> of_band = thinned(band, plain);
  CHECK(has(of_band, 1234));
  CHECK(has(of_band, 4321));
  CHECK(of_band.size() < 30);
}

TEST("a loop is kept to half a pixel") {
  Series loop;
  for (int n = 0; n <= 100000; ++n) {
    loop.x.push_back(100.0 * std::cos(1e-3 * n));
    loop.y.push_back(100.0 * std::sin(1e-3 * n));
  }
  const std::vector<std::size_t> kept = thinned(loop, plain);
  REQUIRE(kept.size() > 1000);
  REQUIRE(kept.size() < 30000);
  CHECK(kept.back() == 100000);
  double widest = 0.0;
  for (std::size_t n = 1; n < kept.size(); ++n) {
    widest = std::max(widest, std::hypot(loop.x[kept[n]] - loop.x[kept[n - 1]],
                                         loop.y[kept[n]] - loop.y[kept[n - 1]]));
  }
  CHECK_NEAR(widest, 0.5, 0.2);  // half a pixel, and a sample is a tenth of one
}

TEST("a gap stays a gap, once, and points that cover each other are drawn once") {
  const double gap = std::nan("");
  const Series series{.x = {0.0, 1.0, 2.0, 3.0, 4.0}, .y = {0.0, gap, gap, 1.0, 2.0}};
  const std::vector<std::size_t> expected{0, 1, 3, 4};
  CHECK(thinned(series, plain) == expected);
  Series points{.style = Series::Style::points};
  for (int n = 0; n < 10000; ++n) {
    points.x.push_back(n % 7);
    points.y.push_back(1.0);
  }
  CHECK(thinned(points, plain).size() == 7);
}

const ZoneLabel& find(const std::vector<ZoneLabel>& labels, const std::string& text) {
  const auto found = std::ranges::find(labels, text, &ZoneLabel::text);
  REQUIRE(found != labels.end());
  return *found;
}

/// Seven layers in front of the spinal canal, 46 mm on 400 pixels.
std::vector<ZoneSpan> spine() {
  return {{"skin", 0.0, 17.0},
          {"subcutaneous fat", 17.0, 59.0},
          {"supraspinous ligament", 59.0, 85.0},
          {"interspinous ligament", 85.0, 312.0},
          {"ligamentum flavum", 312.0, 341.0},
          {"epidural space", 341.0, 394.0},
          {"dura", 394.0, 400.0}};
}

TEST("wide zones are labelled along, narrow ones upright; no two labels overlap") {
  const std::vector<ZoneLabel> of_spine = place_zone_labels(spine(), 400.0, 120.0);
  CHECK(of_spine.size() == 7);
  CHECK(!find(of_spine, "interspinous ligament").upright);
  CHECK(find(of_spine, "supraspinous ligament").upright);
  CHECK(find(of_spine, "dura").upright);
  std::vector<ZoneSpan> crowd;
  for (int n = 0; n < 120; ++n) {
    crowd.push_back({"layer with a long name", 3.4 * n, 3.4 * (n + 1)});
  }
  for (const std::vector<ZoneSpan>& zones : {spine(), crowd}) {
    const std::vector<ZoneLabel> labels = place_zone_labels(zones, 400.0, 120.0);
    REQUIRE(!labels.empty());
    for (auto a = labels.begin(); a != labels.end(); ++a) {
      CHECK(std::none_of(a + 1, labels.end(), [&](const ZoneLabel& b) {
        return std::abs(a->middle - b.middle) < 0.5 * (a->width + b.width);
      }));
    }
    for (const ZoneLabel& label : labels) {
      CHECK(label.middle - 0.5 * label.width >= -1e-9);
      CHECK(label.height <= 120.0);
      CHECK(label.middle + 0.5 * label.width <= 400.0 + 8.0 + 1e-9);
    }
  }
}

TEST("a label too long for the plot has a smaller font; one without width or space is left out") {
  const std::vector<ZoneLabel> labels =
      place_zone_labels({{"äääääääääääääääää", 0.0, 20.0}}, 400.0, 80.0);
  REQUIRE(labels.size() == 1);
  CHECK(text_width(labels.front().text, labels.front().font) <= 80.0 * (1.0 + 1e-12));
  CHECK(labels.front().font < zone_font);
  CHECK(place_zone_labels({{std::string(60, 'm'), 0.0, 20.0}}, 400.0, 50.0).empty());
  CHECK(place_zone_labels({{"", 0.0, 100.0}}, 400.0, 100.0).empty());
  CHECK(place_zone_labels({ZoneSpan{}}, 400.0, 100.0).empty());
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
#include "reports/thinning.hpp"

#include <algorithm>
#include <cmath>

#include "tests/check.hpp"

using namespace palpate;

namespace {

const Projection plain = [](double x, double y) { return Pixel{x, y}; };

bool has(const std::vector<std::size_t>& kept, std::size_t index) {
  return std::ranges::find(kept, index) != kept.end();
}

}  // namespace

TEST("a rising curve keeps every extreme and at most four samples of a pixel column") {
  Series series;
  for (int n = 0; n < 100000; ++n) {
    series.x.push_back(n / 1000.0);
    series.y.push_back(std::sin(0.37 * n) + (n == 77777 ? 50.0 : 0.0) - (n == 33333 ? 50.0 : 0.0));
  }
  const std::vector<std::size_t> kept = thinned(series, plain);
  CHECK(has(kept, 77777) && has(kept, 33333) && has(kept, 0) && has(kept, 99999));
  CHECK(kept.size() <= 400 && kept.size() >= 300);
  CHECK(std::ranges::is_sorted(kept));
}

TEST("a band keeps the extremes of both edges") {
  Series band{.style = Series::Style::band};
  for (int n = 0; n < 5000; ++n) {
    band.x.push_back(n / 1000.0);
    band.y.push_back(n == 1234 ? -9.0 : 0.0);
    band.y2.push_back(n == 4321 ? 9.0 : 1.0);
  }
  const std::vector<std::size_t> kept = thinned(band, plain);
  CHECK(has(kept, 1234) && has(kept, 4321) && kept.size() < 30);
}

TEST("a loop is kept to half a pixel") {
  Series loop;
  for (int n = 0; n <= 100000; ++n) {
    loop.x.push_back(100.0 * std::cos(1e-3 * n));
    loop.y.push_back(100.0 * std::sin(1e-3 * n));
  }
  const std::vector<std::size_t> kept = thinned(loop, plain);
  CHECK(kept.size() > 1000 && kept.size() < 30000 && kept.back() == 100000);
  double widest = 0.0;
  for (std::size_t n = 1; n < kept.size(); ++n) {
    widest = std::max(widest, std::hypot(loop.x[kept[n]] - loop.x[kept[n - 1]],
                                         loop.y[kept[n]] - loop.y[kept[n - 1]]));
  }
  CHECK_NEAR(widest, 0.5, 0.2);  // half a pixel, and a sample is a tenth of one
}

TEST("a gap stays a gap, once") {
  const double gap = std::nan("");
  const Series series{.x = {0.0, 1.0, 2.0, 3.0, 4.0}, .y = {0.0, gap, gap, 1.0, 2.0}};
  const std::vector<std::size_t> expected{0, 1, 3, 4};
  CHECK(thinned(series, plain) == expected);
}

TEST("points that cover each other are drawn once") {
  Series points{.style = Series::Style::points};
  for (int n = 0; n < 10000; ++n) {
    points.x.push_back(n % 7);
    points.y.push_back(1.0);
  }
  CHECK(thinned(points, plain).size() == 7);
}

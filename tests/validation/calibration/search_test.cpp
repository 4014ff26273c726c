// SPDX-License-Identifier: MIT
#include "validation/calibration/search.hpp"

#include <cmath>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

std::size_t index_of_key(const Forward& forward, std::string_view key) {
  std::size_t n = 0;
  while (forward.parameters()[n].key != key) { ++n; }
  return n;
}

TEST("prior and one datum meet where their weights say") {
  const Scene scene = three_layers();
  Scene truth = scene;
  truth.syringe->thumb_force = 22.0;
  Forward forward(scene, parameters_of(scene), 1, nullptr, lawful);
  const Pooled data = lawful_data(truth, 0.2);
  const std::size_t thumb = index_of_key(forward, "syringe.thumb_force");
  const auto found = Search(forward, data, {thumb}).from(forward.priors());
  // Where the derivative of ((v / 22 - 1) / 0.2)^2 + (log(v / 11) / spread)^2 vanishes, by bisection.
  const double spread = forward.parameters()[thumb].spread;
  double low = 11.0;
  double high = 22.0;
  for (int n = 0; n < 60; ++n) {
    const double v = 0.5 * (low + high);
    const double slope = (v / 22.0 - 1.0) / (0.04 * 22.0) + std::log(v / 11.0) / (spread * spread * v);
    (slope < 0.0 ? low : high) = v;
  }
  CHECK(found.converged);
  // Forward differences over a tenth of the spread make slopes 1.8 % high, and move the place by as much
  // of the way between datum and prior that is weighed: below 1 %.
  CHECK_NEAR(found.values[thumb] / low, 1.0, 0.01);
}

TEST("what is not free stays, and values stay within their bounds") {
  const Scene scene = three_layers();
  Scene truth = scene;
  truth.syringe->thumb_force = 1e4;
  Forward forward(scene, parameters_of(scene), 1, nullptr, lawful);
  const std::size_t thumb = index_of_key(forward, "syringe.thumb_force");
  Forward::Values start = forward.priors();
  start[0] *= 1.1;
  const auto found = Search(forward, lawful_data(truth, 0.01), {thumb}).from(start);
  CHECK(found.values[0] == start[0]);
  CHECK(found.values[thumb] <= forward.parameters()[thumb].upper);
}

TEST("slopes are those of the law, in spreads of the prior") {
  const Scene scene = three_layers();
  Forward forward(scene, parameters_of(scene), 1, nullptr, lawful);
  const std::size_t thumb = index_of_key(forward, "syringe.thumb_force");
  const Search search(forward, lawful_data(scene, 0.01), {});
  const Eigen::MatrixXd slopes = search.slopes(forward.priors(), {thumb});
  const double spread = forward.parameters()[thumb].spread;
  const double peak = 11.0 / scene.syringe->plunger_area;
  CHECK_NEAR(slopes(0, 0) / (peak * spread), std::expm1(0.1 * spread) / (0.1 * spread), 1e-12);  // rounding
  CHECK_NEAR(slopes.col(0).tail(slopes.rows() - 1).norm(), 0.0, 1e-15);
}

}  // namespace

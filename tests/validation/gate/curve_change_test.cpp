// SPDX-License-Identifier: MIT
#include "validation/gate/curve_change.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::gate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Figure drawn(const std::function<double(double)>& law, int samples = 1001) {
  Series series{.label = "curve"};
  for (int n = 0; n < samples; ++n) {
    series.x.push_back(static_cast<double>(n) / (samples - 1));
    series.y.push_back(law(series.x.back()));
  }
  return {.id = "f", .x = {.label = "time (s)"}, .y = {.label = "force (N)"}, .series = {series}};
}

/// At rest at either end.
double wave(double t) {
  const double angle = 2.0 * std::numbers::pi * t;
  return 1.0 - std::cos(angle) + 0.3 * (1.0 - std::cos(2.0 * angle));
}

/// A force that rises and is gone at the instant `at`.
double rupture(double t, double at) { return t < at ? 2.0 + t : 0.5 * t; }

Judgement judged(const Figure& before, const Figure& now, double spread = 0.0) {
  return judge_curve(before, now, 0, spread).judgement;
}

TEST("a curve within the tube holds, one beside it does not") {
  const double range = 2.1;  // of wave(), about
  const Figure before = drawn(wave);
  CHECK(judged(before, before) == Judgement::same);
  CHECK(judged(before, drawn([&](double t) { return wave(t) + 1e-3 * range; })) == Judgement::within);
  CHECK(judged(before, drawn([&](double t) { return wave(t) + 4e-3 * range; })) == Judgement::moved);
}

TEST("one sample in a thousand that is off is seen") {
  Figure now = drawn(wave);
  now.series[0].y[500] += 0.1;
  CHECK(judged(drawn(wave), now) == Judgement::moved);
}

TEST("a spike that is gone is seen as well as one that came") {
  Figure before = drawn(wave);
  before.series[0].y[500] += 0.1;
  CHECK(judged(before, drawn(wave)) == Judgement::moved);
}

TEST("an event may come a tick early, and no earlier") {
  const auto at = [](double instant) { return drawn([instant](double t) { return rupture(t, instant); }); };
  CHECK(judged(at(0.5), at(0.499)) == Judgement::within);
  CHECK(judged(at(0.5), at(0.495)) == Judgement::moved);
}

TEST("a whole curve that is one sample late is seen though every sample lies in the tube") {
  const auto late = [](double samples) {
    return drawn([samples](double t) { return wave(t - samples * 1e-3); });
  };
  const Change change = judge_curve(late(0.0), late(1.0), 0, 0.0);
  CHECK(change.judgement == Judgement::moved);
  CHECK(change.moved.find("samples late") != std::string::npos);
  CHECK(judged(late(0.0), late(0.2)) == Judgement::within);
  CHECK_NEAR(lag_in_samples(late(0.0).series[0].x, late(0.0).series[0].y, late(0.3).series[0].y), 0.3, 0.01);
}

TEST("a gain is no lag, and a ramp tells none") {
  const auto scaled = [](double gain) { return drawn([gain](double t) { return gain * wave(t); }); };
  CHECK(std::isnan(lag_in_samples(scaled(1.0).series[0].x, scaled(1.0).series[0].y, scaled(1.001).series[0].y)));
  const auto ramp = [](double offset) { return drawn([offset](double t) { return t + offset; }); };
  CHECK(std::isnan(lag_in_samples(ramp(0.0).series[0].x, ramp(0.0).series[0].y, ramp(1e-3).series[0].y)));
}

TEST("what is not finite passes only where it stood before") {
  Figure gap = drawn(wave);
  gap.series[0].y[10] = nan;
  CHECK(judged(gap, gap) == Judgement::same);
  CHECK(judged(drawn(wave), gap) == Judgement::broken);
  CHECK(judged(gap, drawn(wave)) == Judgement::broken);
}

TEST("a curve of other length or name is another curve") {
  CHECK(judged(drawn(wave), drawn(wave, 1000)) == Judgement::broken);
  Figure now = drawn(wave);
  now.series[0].label = "other";
  CHECK(judged(drawn(wave), now) == Judgement::broken);
}

TEST("on a logarithmic axis errors have a tenth of a digit") {
  const auto errors = [](double factor) {
    Figure figure = drawn([factor](double x) { return factor * std::pow(10.0, -6.0 * x); }, 11);
    figure.y.logarithmic = true;
    return figure;
  };
  CHECK(judged(errors(1.0), errors(1.2)) == Judgement::within);
  CHECK(judged(errors(1.0), errors(1.3)) == Judgement::moved);
}

TEST("a constant has its own height for a range, and one of nothing has none") {
  const auto level = [](double y) { return drawn([y](double) { return y; }); };
  CHECK(judged(level(5.0), level(5.009)) == Judgement::within);
  CHECK(judged(level(5.0), level(5.011)) == Judgement::moved);
  CHECK(judged(level(0.0), level(1e-12)) == Judgement::moved);
  CHECK(judged(level(0.0), level(1e-16), 1e-16) == Judgement::rounding);
}

TEST("a small curve beside a large one is measured by the large one") {
  Figure before = drawn([](double t) { return 1e-9 * t; });
  before.series.push_back(drawn(wave).series[0]);
  Figure now = before;
  for (double& y : now.series[0].y) { y *= 1.5; }
  CHECK(judged(before, now) == Judgement::within);
}

TEST("both edges of a band are judged") {
  Figure before = drawn(wave);
  before.series[0].style = Series::Style::band;
  for (const double y : before.series[0].y) { before.series[0].y2.push_back(y + 1.0); }
  Figure now = before;
  now.series[0].y2[300] += 0.1;
  CHECK(judged(before, before) == Judgement::same);
  CHECK(judged(before, now) == Judgement::moved);
}

TEST("points are compared one by one, and one of many is not lost") {
  Figure before = drawn(wave);
  before.series[0].style = Series::Style::points;
  Figure now = before;
  now.series[0].y[700] += 0.1;
  CHECK(judged(before, now) == Judgement::moved);
}

}  // namespace

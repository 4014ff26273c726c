// SPDX-License-Identifier: MIT

#include "validation/comparison/features.hpp"

#include <algorithm>
#include <functional>

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/signal.hpp"

namespace {

using namespace palpate::comparison;
using namespace palpate;
using Decision = LossOfResistance::Decision;
using clinical::PressureLaw;

TEST("a straight line is the same line on any grid") {
  std::vector<double> time;
  std::vector<double> value;
  for (int n = 0; n < 50; ++n) {
    time.push_back(0.1 * n + (n % 2 == 0 ? 0.0 : 0.01));  // not uniform, within what is bridged
    value.push_back(3.0 * time.back() - 1.0);
  }
  const Samples moved = resample(time, value, {.start = 0.0, .step = 0.033, .count = 140});
  for (std::size_t n = 0; n < moved.size(); ++n) {
    CHECK_NEAR(moved.value[n], 3.0 * moved.time(n) - 1.0, 1e-12);
  }
}

TEST("samples on their own grid are those samples") {
  const std::vector<double> time{1.0, 1.25, 1.5, 1.75};
  const std::vector<double> value{4.0, not_measured, -2.0, 8.0};
  const Samples same = regular(time, value);
  CHECK(same.size() == 4);
  CHECK(same.start == 1.0);
  CHECK(same.step == 0.25);
  CHECK(same.value[0] == 4.0);
  CHECK(std::isnan(same.value[1]));
  CHECK(same.value[2] == -2.0);
  CHECK(same.value[3] == 8.0);
}

TEST("nothing is interpolated across a missing sample or one that is no number") {
  const std::vector<double> missing_time{0.0, 1.0, 2.0, 4.0, 5.0, 6.0};
  const std::vector<double> values{0.0, 1.0, 2.0, 4.0, 5.0, 6.0};
  const Grid grid{.start = 0.0, .step = 0.5, .count = 13};
  const Samples missing = resample(missing_time, values, grid);
  const std::vector<double> times{0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  const std::vector<double> with_nan{0.0, 1.0, 2.0, not_measured, 4.0, 5.0, 6.0};
  const Samples nan = resample(times, with_nan, grid);
  for (const Samples& s : {missing, nan}) {
    CHECK(s.value[4] == 2.0);
    CHECK(s.value[8] == 4.0);
    for (const std::size_t n : {5UL, 6UL, 7UL}) { CHECK(std::isnan(s.value[n])); }
    CHECK(s.value[3] == 1.5);
    CHECK(s.value[9] == 4.5);
  }
}

TEST("an infinite sample is a gap") {
  const std::vector<double> time{0.0, 1.0, 2.0, 3.0};
  const std::vector<double> value{1.0, std::numeric_limits<double>::infinity(), 1.0, 1.0};
  const Samples s = regular(time, value);
  CHECK(s.value[0] == 1.0);
  CHECK(std::isnan(s.value[1]));
  CHECK(s.value[2] == 1.0);
}

TEST("nothing is made up before the first sample or after the last") {
  const std::vector<double> time{1.0, 2.0};
  const std::vector<double> value{5.0, 6.0};
  const Samples s = resample(time, value, {.start = 0.5, .step = 0.5, .count = 5});
  CHECK(std::isnan(s.value[0]));
  CHECK(s.value[1] == 5.0);
  CHECK(s.value[2] == 5.5);
  CHECK(s.value[3] == 6.0);
  CHECK(std::isnan(s.value[4]));
  CHECK(std::isnan(resample(std::vector<double>{}, std::vector<double>{}, {.count = 1}).value[0]));
}

TEST("a grid between two times lies on its anchor") {
  const Grid grid = grid_between(0.24, 1.01, 0.1, 0.25);
  CHECK_NEAR(grid.start, 0.35, 1e-12);
  CHECK(grid.count == 3);
  CHECK(grid_between(1.0, 0.0, 0.0, 0.1).count == 0);
}

TEST("stretches end at gaps and the longest is the longest") {
  const std::vector<double> value{1.0, not_measured, 1.0, 1.0, not_measured, 1.0};
  const std::vector<Stretch> stretches = finite_stretches(value);
  REQUIRE(stretches.size() == 3);
  CHECK(stretches[1].begin == 2);
  CHECK(stretches[1].end == 4);
  CHECK(longest_stretch(value).begin == 2);
  CHECK(longest_stretch(std::vector<double>{}).size() == 0);
}

TEST("quantiles are linear between order statistics and skip gaps") {
  const std::vector<double> value{4.0, not_measured, 1.0, 3.0, 2.0};
  CHECK_NEAR(quantile(value, 0.5), 2.5, 1e-15);
  CHECK_NEAR(quantile(value, 1.0), 4.0, 0.0);
  CHECK_NEAR(quantile(value, 0.1), 1.3, 1e-15);
  CHECK(std::isnan(quantile(std::vector<double>{not_measured}, 0.5)));
}

constexpr double step = 0.01;

Samples noise(std::size_t count) {
  palpate::device::Seeded seeded(5);
  Samples samples{.step = step};
  for (std::size_t n = 0; n < count; ++n) { samples.value.push_back(seeded.uniform(-1.0, 1.0)); }
  return samples;
}

TEST("a straight line passes unchanged to its ends") {
  Samples line{.step = step};
  for (int n = 0; n < 300; ++n) { line.value.push_back(2.0 - 0.7 * n); }
  const Samples filtered = zero_phase(line, 10.0);
  // After three periods of the cut-off, exp(-2 pi 3 / sqrt(2)) = 2e-6 of the initial value remains.
  for (std::size_t n = 0; n < 300; ++n) {
    CHECK_NEAR(filtered.value[n], line.value[n], 1e-5 * 0.7 * 30.0);
  }
}

TEST("forward or backward in time is the same") {
  Samples there = noise(400);
  Samples back = there;
  std::ranges::reverse(back.value);
  there = zero_phase(there, 8.0);
  back = zero_phase(back, 8.0);
  std::ranges::reverse(back.value);
  // Away from the ends, where each run starts in its own steady state.
  for (std::size_t n = 100; n < 300; ++n) { CHECK_NEAR(there.value[n], back.value[n], 1e-9); }
}

TEST("the energy of the impulse response is the share of noise that passes") {
  Samples impulse{.step = step, .value = std::vector<double>(2001, 0.0)};
  impulse.value[1000] = 1.0;
  const Samples response = zero_phase(impulse, 12.0);
  double passed = 0.0;
  double removed = 0.0;
  for (std::size_t n = 0; n < impulse.size(); ++n) {
    passed += response.value[n] * response.value[n];
    removed += (impulse.value[n] - response.value[n]) * (impulse.value[n] - response.value[n]);
  }
  const NoiseShares shares =
      noise_shares(12.0, 1.0 / step);  // Parseval; midpoint rule of 2000 points
  CHECK_NEAR(shares.passed, passed, 1e-6);
  CHECK_NEAR(shares.removed, removed, 1e-6);
}

TEST("what lies beyond a gap has no influence, and the gap stays") {
  Samples samples = noise(300);
  for (std::size_t n = 150; n < 155; ++n) { samples.value[n] = not_measured; }
  const Samples before = zero_phase(samples, 10.0);
  for (std::size_t n = 155; n < 300; ++n) { samples.value[n] += 1e6; }
  const Samples after = zero_phase(samples, 10.0);
  for (std::size_t n = 0; n < 150; ++n) { CHECK(before.value[n] == after.value[n]); }
  for (std::size_t n = 150; n < 155; ++n) { CHECK(std::isnan(after.value[n])); }
}

TEST("stretches too short to filter stay as they are") {
  const Samples samples{.step = step, .value = {1.0, -1.0, not_measured, 5.0, not_measured}};
  const Samples filtered = zero_phase(samples, 10.0);
  CHECK(filtered.value[0] == 1.0);
  CHECK(filtered.value[1] == -1.0);
  CHECK(filtered.value[3] == 5.0);
}

TEST("a cut-off that the rate cannot carry, or none, changes nothing") {
  const Samples samples = noise(50);
  CHECK(!can_filter(40.0, 100.0));
  CHECK(!can_filter(0.0, 100.0));
  CHECK(can_filter(39.0, 100.0));
  CHECK(zero_phase(samples, 40.0).value == samples.value);
  CHECK(zero_phase(samples, 0.0).value == samples.value);
}

std::string refusal(const std::vector<double>& time, const std::vector<double>& value) {
  return refusal_of({.time = time, .value = value});
}

TEST("what cannot be compared is refused with its reason") {
  CHECK(refusal({}, {}) == "is empty");
  CHECK(refusal({0.0}, {1.0}) == "has one sample");
  CHECK(refusal({0.0, 1.0}, {1.0}) == "has more times than values, or fewer");
  CHECK(refusal({0.0, 0.0}, {1.0, 2.0}) == "has times that do not increase");
  CHECK(refusal({0.0, 1.0}, {not_measured, not_measured}) == "holds no number");
  CHECK(refusal({0.0, 1.0, 2.0}, {1.0, 2.0, 3.0}) == "holds fewer than 10 numbers");
  const std::vector<double> time = clinical::instants(1.0, 100.0);
  CHECK(refusal(time, std::vector<double>(time.size(), 7.0)) == "is constant");
  CHECK(refusal(time, time).empty());
  std::vector<double> huge = time;
  huge[3] = -1e101;
  CHECK(refusal(time, huge) == "holds a value beyond 1e100");
  std::vector<double> far = time;
  far.back() = 1e9;  // a grid of its usual interval would have 1e11 instants
  CHECK(refusal(far, time) == "spans more than ten million of its usual intervals");
}

TEST("a trace of single samples between gaps is refused") {
  const std::vector<double> time = clinical::instants(1.0, 100.0);
  std::vector<double> value = time;
  for (std::size_t n = 0; n < value.size(); n += 2) { value[n] = not_measured; }
  CHECK(prepare({.time = time, .value = value}, 20.0, {}).refusal ==
        "has no three samples without a gap");
}

TEST("a good trace keeps its samples, its filtered ones and its depth on one grid") {
  const std::vector<double> time = clinical::instants(14.0, 100.0);
  const std::vector<double> value = clinical::pressures({}, time);
  const PreparedTrace prepared = prepare({.time = time, .value = value, .depth = time}, 20.0, {});
  CHECK(prepared.refusal.empty());
  CHECK(prepared.input.raw.size() == time.size());
  CHECK(prepared.input.filtered.size() == time.size());
  CHECK(prepared.input.depth.size() == time.size());
  CHECK_NEAR(1.0 / prepared.input.raw.step, 100.0, 1e-6);
  CHECK(prepared.features.loss.found());
}

/// Analytic signal at 100 Hz in units of the peak.
LossOfResistance found_in(double duration, const std::function<double(double)>& law) {
  Samples pressure{.step = 0.01};
  for (int n = 0; n <= static_cast<int>(duration * 100.0); ++n) {
    pressure.value.push_back(law(0.01 * n));
  }
  return find_loss(pressure);
}

double ramp(double t) { return 20.0 + 40.0 * t / 6.0; }
auto falls_to(double level) {
  return [level](double t) { return t < 6.0 ? ramp(t) : level; };
}

TEST("a fall that is held for more than 5 s is a loss of resistance") {
  const LossOfResistance loss = found_in(14.0, falls_to(8.0));
  CHECK(loss.found());
  CHECK(!loss.weak);
  CHECK(loss.fallen_index == 600);
  CHECK(loss.peak_index == 599);
  CHECK_NEAR(loss.plateau, 8.0, 0.0);
  CHECK_NEAR(loss.relative_drop, 1.0 - 8.0 / ramp(5.99), 1e-12);
}

TEST("a weak one of 45 % is found and said to be weak") {
  const LossOfResistance loss = found_in(14.0, falls_to(0.55 * 60.0));
  CHECK(loss.found());
  CHECK(loss.weak);
}

TEST("a fall of 33 % is none, and the reason has its size") {
  const LossOfResistance loss = found_in(14.0, falls_to(0.67 * 60.0));
  CHECK(loss.status == Decision::not_found);
  CHECK_CONTAINS(loss.reason, "fell by 33 %");
}

TEST("a fall that comes back is none, and the reason says when") {
  const LossOfResistance loss =
      found_in(20.0, [](double t) { return t > 6.0 && t < 9.0 ? 10.0 : 50.0; });
  CHECK(loss.status == Decision::not_found);
  CHECK((check::contains(loss.reason, "came back after 2.9") ||
         check::contains(loss.reason, "came back after 3.0")));
}

TEST("a trace that ends too early cannot be decided, and what fell can still be measured") {
  const LossOfResistance loss = found_in(9.0, falls_to(8.0));
  CHECK(loss.status == Decision::undecided);
  CHECK(loss.fell());
  CHECK_CONTAINS(loss.reason, "ends 3.0");
  CHECK_NEAR(loss.plateau, 8.0, 0.0);
  CHECK(!found_in(6.5, falls_to(8.0)).fell());  // nothing settled yet
}

TEST("pressure held against bone is none") {
  CHECK(found_in(20.0, [](double t) { return std::min(60.0, ramp(t)); }).status ==
        Decision::not_found);
}

TEST("a slow leak is none") {
  const LossOfResistance loss = found_in(
      40.0, [](double t) { return t < 6.0 ? ramp(t) : 60.0 * std::exp(-(t - 6.0) / 5.0); });
  CHECK(loss.status == Decision::not_found);  // falls by 33 % in any 2 s
  const LossOfResistance faster = found_in(
      40.0, [](double t) { return t < 6.0 ? ramp(t) : 60.0 * std::exp(-(t - 6.0) / 3.0); });
  CHECK(faster.status == Decision::not_found);  // by 49 %, but there is no plateau
}

TEST("pushes of a thumb with rests of less than 5 s are none") {
  const LossOfResistance loss =
      found_in(40.0, [](double t) { return std::fmod(t, 4.5) < 0.5 ? 60.0 : 2.0; });
  CHECK(loss.status != Decision::found);
}

TEST("flushing the needle long before is none, and hides nothing") {
  const LossOfResistance loss = found_in(30.0, [](double t) {
    if (t < 1.0) { return 20.0; }
    if (t < 10.0) { return 0.0; }
    return t < 18.0 ? 7.5 * (t - 10.0) : 8.0;
  });
  CHECK(loss.found());
  CHECK_NEAR(0.01 * static_cast<double>(loss.fallen_index), 18.0, 0.011);
}

TEST("a gap in the plateau of more than a tenth hides it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 1400; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  for (std::size_t n = 700; n < 740; ++n) { pressure.value[n] = not_measured; }
  CHECK(find_loss(pressure).found());
  for (std::size_t n = 700; n < 800; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Decision::undecided);
  CHECK(hidden.fell());
  CHECK(hidden.reason == "a gap hides whether a fall of 87 % was held for 5 s");  // 1 - 8 / 60
}

TEST("a gap that begins soon after the fall and never ends hides it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 700; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  pressure.value.resize(3000, not_measured);
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Decision::undecided);
  CHECK_CONTAINS(hidden.reason, "gap");
}

TEST("a fall within a gap longer than a fall may take is not told from a slow one") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 2000; ++n) { pressure.value.push_back(falls_to(8.0)(0.01 * n)); }
  for (std::size_t n = 550; n < 850; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance hidden = find_loss(pressure);
  CHECK(hidden.status == Decision::undecided);
  CHECK(!hidden.fell());
  CHECK(hidden.reason.starts_with("a gap of 3.01 s hides how the pressure fell by 8"));
  for (std::size_t n = 900; n < 2000; ++n) {
    pressure.value[n] = 50.0;
  }  // comes back at once: no event
  CHECK(find_loss(pressure).status == Decision::not_found);
}

TEST("a gap hides nothing of a fall that was seen to come back, nor a later one that was held") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 3000; ++n) {
    pressure.value.push_back(n < 600 || (n >= 1000 && n < 1600) ? 60.0 : 8.0);
  }
  for (std::size_t n = 700; n < 800; ++n) { pressure.value[n] = not_measured; }
  const LossOfResistance later = find_loss(pressure);
  CHECK(later.found());
  CHECK(later.fallen_index == 1600);
  for (std::size_t n = 1600; n < 3000; ++n) { pressure.value[n] = 60.0; }
  CHECK(find_loss(pressure).status == Decision::not_found);
}

TEST("a last fall that the trace cuts short is open whatever came before it") {
  Samples pressure{.step = 0.01};
  for (int n = 0; n < 2000; ++n) {
    pressure.value.push_back(n > 600 && n < 900 ? 2.0 : n < 1800 ? 60.0 : 8.0);
  }
  const LossOfResistance open = find_loss(pressure);
  CHECK(open.status == Decision::undecided);
  CHECK(open.reason == "the trace ends 2.00 s after a fall of 87 %; 5 s needed");
}

TEST("no pressure, no numbers and hardly any samples are none") {
  CHECK(found_in(20.0, [](double) { return -3.0; }).reason == "no pressure above zero");
  CHECK(found_in(20.0, [](double) { return not_measured; }).status == Decision::not_found);
  CHECK(find_loss({}).status == Decision::not_found);
}

TEST("suction in the epidural space is a drop of more than all") {
  const LossOfResistance loss = found_in(14.0, falls_to(-4.0));
  CHECK(loss.found());
  CHECK(loss.relative_drop > 1.0);
}

struct Given {
  std::vector<double> time = clinical::instants(14.0, 200.0);
  std::vector<double> value{};
  std::vector<double> depth{};
  [[nodiscard]] Features found() const { return prepare({time, value, depth}, 20.0, {}).features; }
};

Given of(const PressureLaw& law) {
  Given given;
  given.value = clinical::pressures(law, given.time);
  return given;
}

TEST("depth is read at the instants of the events") {
  Given given = of({});
  for (const double t : given.time) { given.depth.push_back(0.002 * t); }
  const Features found = given.found();
  CHECK_NEAR(*found[Feature::depth_of_loss].value, 0.002 * *found[Feature::time_of_loss].value,
             1e-12);
  CHECK_NEAR(*found[Feature::depth_of_peak].value, 0.002 * *found[Feature::time_of_peak].value,
             1e-12);
}

TEST("the duration of an exponential fall is its constant times ln 9") {
  const Features found = of({}).found();
  CHECK_NEAR(*found[Feature::drop_time].value, 0.15 * std::log(9.0),
             0.02 * 0.33);  // 2 % of the filter
}

TEST(
    "without a loss of resistance its features are absent for that reason, and the peak is the "
    "trace's") {
  const Features found = of({.plateau = PressureLaw{}.peak}).found();
  CHECK(*found[Feature::loss_of_resistance].value == 0.0);
  for (const Feature feature : {Feature::drop_height, Feature::relative_drop, Feature::drop_time,
                                Feature::plateau, Feature::time_of_loss, Feature::depth_of_loss}) {
    CHECK(!found[feature].value);
    CHECK(found[feature].reason.starts_with(
        feature == Feature::depth_of_loss ? "depth" : "no loss of resistance"));
  }
  const double peak = 60.0 * pascals_per_mmhg;
  CHECK_NEAR(*found[Feature::peak].value, peak, 0.01 * peak);  // overshoot of the filter
}

TEST("a trace that ends too early has a drop but no verdict on its event") {
  Given given = of({});
  const std::size_t kept = 200 * 9;
  given.time.resize(kept);
  given.value.resize(kept);
  const Features found = given.found();
  CHECK(!found[Feature::loss_of_resistance].value);
  CHECK_CONTAINS(found[Feature::loss_of_resistance].reason, "the trace ends");
  CHECK(found[Feature::drop_time].value);
  CHECK(found[Feature::plateau].value);
}

TEST("a gap over the fall hides its duration and nothing else") {
  Given given = of({});
  for (std::size_t n = 0; n < given.time.size(); ++n) {
    if (given.time[n] > 6.05 && given.time[n] < 6.25) { given.value[n] = not_measured; }
  }
  const Features found = given.found();
  CHECK(found.loss.found());
  CHECK(!found[Feature::drop_time].value);
  CHECK(found[Feature::drop_time].reason == "a gap hides the fall");
  CHECK(found[Feature::peak].value);
  CHECK(found[Feature::plateau].value);
}

TEST("without two seconds before the peak there is no slope") {
  const Features found = of({.rise = 0.5, .loss = 1.5}).found();
  CHECK(!found[Feature::slope_before].value);
  CHECK(found[Feature::slope_before].reason == "less than 2.1 s before the peak");
}

TEST("noise on samples is found to a tenth and makes every feature uncertain") {
  Given given = of({});
  const Features clean = given.found();
  device::Seeded seeded(9);
  clinical::add_noise(given.value, 100.0, seeded);
  const Features noisy = given.found();
  CHECK_NEAR(noisy.noise, 100.0, 10.0);  // a median of 2800 is known to 2 %
  for (const Feature feature :
       {Feature::peak, Feature::plateau, Feature::drop_time, Feature::slope_before}) {
    CHECK(noisy[feature].uncertainty > clean[feature].uncertainty);
  }
}

TEST("features have units of the trace, and every one a name of its own") {
  CHECK(unit_of(Feature::peak, "N") == "N");
  CHECK(unit_of(Feature::slope_before, "Pa") == "Pa/s");
  CHECK(unit_of(Feature::drop_time, "Pa") == "s");
  CHECK(unit_of(Feature::depth_of_loss, "Pa") == "m");
  for (std::size_t n = 1; n < feature_count; ++n) {
    CHECK(name_of(static_cast<Feature>(n)) != name_of(static_cast<Feature>(n - 1)));
  }
  CHECK(name_of(Feature::depth_of_loss) == "depth_of_loss");
  CHECK(name_of(Feature::drop_time) == "drop_time");
}

}  // namespace

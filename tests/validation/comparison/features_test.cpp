// SPDX-License-Identifier: MIT

#include "validation/comparison/features.hpp"

#include <functional>

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "tests/validation/comparison/insertion_law.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::comparison;
using Decision = LossOfResistance::Decision;
using clinical::PressureLaw;
using Values = std::vector<double>;

constexpr double step = 0.01;  // [s]

void check_values(const Samples& samples, const Values& expected) {
  REQUIRE(samples.size() == expected.size());
  for (std::size_t n = 0; n < expected.size(); ++n) {
    CHECK(std::isnan(samples.value[n]) == std::isnan(expected[n]));
    if (!std::isnan(expected[n])) { CHECK(samples.value[n] == expected[n]); }
  }
}

TEST("a line is the same on any grid, samples on their own grid too, and infinite ones are gaps") {
  Values time, value;
  for (int n = 0; n < 50; ++n) {
    time.push_back(0.1 * n + (n % 2 == 0 ? 0.0 : 0.01));  // not uniform, within what is bridged
    value.push_back(3.0 * time.back() - 1.0);
  }
  const Samples moved = resample(time, value, {.start = 0.0, .step = 0.033, .count = 140});
  for (std::size_t n = 0; n < moved.size(); ++n) {
    CHECK_NEAR(moved.value[n], 3.0 * moved.time(n) - 1.0, 1e-12);
  }
  const Samples same =
      regular(Values{1.0, 1.25, 1.5, 1.75, 2.0}, Values{4.0, not_measured, -2.0, INFINITY, 8.0});
  CHECK(same.start == 1.0);
  CHECK(same.step == 0.25);
  check_values(same, {4.0, not_measured, -2.0, not_measured, 8.0});
}

TEST("nothing is interpolated across a missing sample or NaN, nor before or after all samples") {
  const Grid grid{.start = 0.0, .step = 0.5, .count = 13};
  const Values expected{0.0,          0.5, 1.0, 1.5, 2.0, not_measured, not_measured,
                        not_measured, 4.0, 4.5, 5.0, 5.5, 6.0};
  const Values missing{0.0, 1.0, 2.0, 4.0, 5.0, 6.0};
  check_values(resample(missing, missing, grid), expected);
  const Values times{0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  check_values(resample(times, Values{0.0, 1.0, 2.0, not_measured, 4.0, 5.0, 6.0}, grid), expected);
  check_values(
      resample(Values{1.0, 2.0}, Values{5.0, 6.0}, {.start = 0.5, .step = 0.5, .count = 5}),
      {not_measured, 5.0, 5.5, 6.0, not_measured});
  check_values(resample(Values{}, Values{}, {.count = 1}), {not_measured});
}

TEST("a grid between two times lies on its anchor; stretches end at gaps; quantiles skip gaps") {
  const Grid grid = grid_between(0.24, 1.01, 0.1, 0.25);
  CHECK_NEAR(grid.start, 0.35, 1e-12);
  CHECK(grid.count == 3);
  CHECK(grid_between(1.0, 0.0, 0.0, 0.1).count == 0);
  const Values value{1.0, not_measured, 1.0, 1.0, not_measured, 1.0};
  const std::vector<Stretch> stretches = finite_stretches(value);
  REQUIRE(stretches.size() == 3);
  CHECK(stretches[1].begin == 2);
  CHECK(stretches[1].end == 4);
  CHECK(longest_stretch(value).begin == 2);
  CHECK(longest_stretch(Values{}).size() == 0);
  const Values ordered{4.0, not_measured, 1.0, 3.0, 2.0};
  CHECK_NEAR(quantile(ordered, 0.5), 2.5, 1e-15);
  CHECK_NEAR(quantile(ordered, 1.0), 4.0, 0.0);
  CHECK_NEAR(quantile(ordered, 0.1), 1.3, 1e-15);  // linear between order statistics
  CHECK(std::isnan(quantile(Values{not_measured}, 0.5)));
}

Samples noise(std::size_t count) {
  device::Seeded seeded(5);
  Samples samples{.step = step};
  for (std::size_t n = 0; n < count; ++n) { samples.value.push_back(seeded.uniform(-1.0, 1.0)); }
  return samples;
}

TEST("the filter keeps a straight line to its ends, and has no direction in time") {
  Samples line{.step = step};
  for (int n = 0; n < 300; ++n) { line.value.push_back(2.0 - 0.7 * n); }
  const Samples filtered = zero_phase(line, 10.0);
  // After three periods of the cut-off, exp(-2 pi 3 / sqrt(2)) = 2e-6 of the initial value remains.
  for (std::size_t n = 0; n < 300; ++n) {
    CHECK_NEAR(filtered.value[n], line.value[n], 1e-5 * 0.7 * 30.0);
  }
  Samples there = noise(400), back = there;
  std::ranges::reverse(back.value);
  there = zero_phase(there, 8.0);
  back = zero_phase(back, 8.0);
  std::ranges::reverse(back.value);
  // Away from the ends, where each run starts in its own steady state.
  for (std::size_t n = 100; n < 300; ++n) { CHECK_NEAR(there.value[n], back.value[n], 1e-9); }
}

TEST("the energy of the impulse response is the share of noise that passes") {
  Samples impulse{.step = step, .value = Values(2001, 0.0)};
  impulse.value[1000] = 1.0;
  const Samples response = zero_phase(impulse, 12.0);
  double passed = 0.0, removed = 0.0;
  for (std::size_t n = 0; n < impulse.size(); ++n) {
    passed += response.value[n] * response.value[n];
    removed += (impulse.value[n] - response.value[n]) * (impulse.value[n] - response.value[n]);
  }
  // Parseval; midpoint rule of 2000 points.
  const NoiseShares shares = noise_shares(12.0, 1.0 / step);
  CHECK_NEAR(shares.passed, passed, 1e-6);
  CHECK_NEAR(shares.removed, removed, 1e-6);
}

TEST("samples beyond a gap have no influence, and the gap stays") {
  Samples samples = noise(300);
  for (std::size_t n = 150; n < 155; ++n) { samples.value[n] = not_measured; }
  const Samples before = zero_phase(samples, 10.0);
  for (std::size_t n = 155; n < 300; ++n) { samples.value[n] += 1e6; }
  const Samples after = zero_phase(samples, 10.0);
  for (std::size_t n = 0; n < 150; ++n) { CHECK(before.value[n] == after.value[n]); }
  for (std::size_t n = 150; n < 155; ++n) { CHECK(std::isnan(after.value[n])); }
}

TEST("stretches too short to filter and cut-offs that the rate cannot carry change nothing") {
  const Samples samples{.step = step, .value = {1.0, -1.0, not_measured, 5.0, not_measured}};
  const Samples filtered = zero_phase(samples, 10.0);
  CHECK(filtered.value[0] == 1.0);
  CHECK(filtered.value[1] == -1.0);
  CHECK(filtered.value[3] == 5.0);
  const Samples fifty = noise(50);
  CHECK(!can_filter(40.0, 100.0));
  CHECK(!can_filter(0.0, 100.0));
  CHECK(can_filter(39.0, 100.0));
  CHECK(zero_phase(fifty, 40.0).value == fifty.value);
  CHECK(zero_phase(fifty, 0.0).value == fifty.value);
}

TEST("a trace that cannot be compared is refused with its reason") {
  const Values time = clinical::instants(1.0, 100.0);
  Values huge = time;
  huge[3] = -1e101;
  Values far = time;
  far.back() = 1e9;  // a grid of its usual interval would have 1e11 instants
  struct {
    Values time, value;
    const char* reason;
  } const inputs[] = {
      {{}, {}, "is empty"},
      {{0.0}, {1.0}, "has one sample"},
      {{0.0, 1.0}, {1.0}, "has more times than values, or fewer"},
      {{0.0, 0.0}, {1.0, 2.0}, "has times that do not increase"},
      {{0.0, 1.0}, {not_measured, not_measured}, "holds no number"},
      {{0.0, 1.0, 2.0}, {1.0, 2.0, 3.0}, "holds fewer than 10 numbers"},
      {time, Values(time.size(), 7.0), "is constant"},
      {time, time, ""},
      {time, huge, "holds a value beyond 1e100"},
      {far, time, "spans more than ten million of its usual intervals"},
  };
  for (const auto& input : inputs) {
    CHECK(refusal_of({.time = input.time, .value = input.value}) == input.reason);
  }
  Values single = time;
  for (std::size_t n = 0; n < single.size(); n += 2) { single[n] = not_measured; }
  CHECK(prepare({.time = time, .value = single}, 20.0, {}).refusal ==
        "has no three samples without a gap");
}

TEST("a valid trace has its samples, its filtered ones and its depth on one grid") {
  const Values time = clinical::instants(14.0, 100.0);
  const PreparedTrace prepared =
      prepare({.time = time, .value = clinical::pressures({}, time), .depth = time}, 20.0, {});
  CHECK(prepared.refusal.empty());
  for (const Samples* samples :
       {&prepared.input.raw, &prepared.input.filtered, &prepared.input.depth}) {
    CHECK(samples->size() == time.size());
  }
  CHECK_NEAR(1.0 / prepared.input.raw.step, 100.0, 1e-6);
  CHECK(prepared.features.loss.found());
}

/// Pressure at sample n, 100 samples a second, in units of 1/60 of the peak.
using Law = std::function<double(int)>;

LossOfResistance found_in(int samples, const Law& law) {
  Samples pressure{.step = step};
  for (int n = 0; n < samples; ++n) { pressure.value.push_back(law(n)); }
  return find_loss(pressure);
}

double ramp(int n) { return 20.0 + 40.0 * (step * n) / 6.0; }
Law falls_to(double level) {
  return [level](int n) { return n < 600 ? ramp(n) : level; };
}
Law leaks(double time_constant) {
  return
      [=](int n) { return n < 600 ? ramp(n) : 60.0 * std::exp(-(step * n - 6.0) / time_constant); };
}
/// Level of the first part that ends after the sample.
Law levels(const std::vector<std::pair<int, double>>& parts) {
  return [=](int n) {
    return std::ranges::find_if(parts, [n](const auto& part) { return n < part.first; })->second;
  };
}
Law with_gap(const Law& law, int begin, int end) {
  return [=](int n) { return n >= begin && n < end ? not_measured : law(n); };
}

TEST("a fall that lasts more than 5 s is a loss of resistance") {
  const LossOfResistance loss = found_in(1401, falls_to(8.0));
  CHECK(loss.found());
  CHECK(!loss.weak);
  CHECK(loss.fallen_index == 600);
  CHECK(loss.peak_index == 599);
  CHECK_NEAR(loss.plateau, 8.0, 0.0);
  CHECK_NEAR(loss.relative_drop, 1.0 - 8.0 / ramp(599), 1e-12);
}

TEST("only a large, quick and lasting fall is found; one hidden by a gap or the end is undecided") {
  const Law flushed = [](int n) {  // the needle, long before
    return n < 100 ? 20.0 : n < 1000 ? 0.0 : n < 1800 ? 7.5 * (step * n - 10.0) : 8.0;
  };
  const Law recovers_at_once =
      with_gap([](int n) { return n < 900 ? falls_to(8.0)(n) : 50.0; }, 550, 850);
  const auto two_falls = [](double second) {
    return with_gap(levels({{600, 60.0}, {1000, 8.0}, {1600, 60.0}, {3000, second}}), 700, 800);
  };
  const char* hidden = "a gap hides whether a fall of 87 % was held for 5 s";  // 1 - 8 / 60
  struct {
    const char* what;
    int samples;
    Law law;
    Decision decision;
    const char* reason = "";
  } const rows[] = {
      {"45 %", 1401, falls_to(0.55 * 60.0), Decision::found},
      {"33 %", 1401, falls_to(0.67 * 60.0), Decision::not_found,
       "fell by 33 % at most within 2 s; 40 % needed"},
      {"comes back", 2001, levels({{601, 50.0}, {900, 10.0}, {2001, 50.0}}), Decision::not_found,
       "a fall of 80 % came back after 2.99 s; 5 s needed"},
      {"ends early", 901, falls_to(8.0), Decision::undecided,
       "the trace ends 3.01 s after a fall of 87 %; 5 s needed"},
      {"pressed against bone", 2001, [](int n) { return std::min(60.0, ramp(n)); },
       Decision::not_found},
      {"leaks by 33 % in any 2 s", 4001, leaks(5.0), Decision::not_found},
      {"leaks by 49 % without a plateau", 4001, leaks(3.0), Decision::not_found},
      {"flushed", 3001, flushed, Decision::found},
      {"gap of less than a tenth of the plateau", 1400, with_gap(falls_to(8.0), 700, 740),
       Decision::found},
      {"gap of more than a tenth of the plateau", 1400, with_gap(falls_to(8.0), 700, 800),
       Decision::undecided, hidden},
      {"gap without end", 3000, with_gap(falls_to(8.0), 700, 3000), Decision::undecided, hidden},
      {"gap over the fall", 2000, with_gap(falls_to(8.0), 550, 850), Decision::undecided,
       "a gap of 3.01 s hides how the pressure fell by 86 %"},  // 1 - 8 / ramp(549)
      {"gap over a fall that comes back", 2000, recovers_at_once, Decision::not_found},
      {"gap in an earlier fall that came back", 3000, two_falls(8.0), Decision::found},
      {"gap in the only fall, which came back", 3000, two_falls(60.0), Decision::not_found},
      {"last fall cut short", 2000, levels({{601, 60.0}, {900, 2.0}, {1800, 60.0}, {2000, 8.0}}),
       Decision::undecided, "the trace ends 2.00 s after a fall of 87 %; 5 s needed"},
      {"negative", 2001, levels({{2001, -3.0}}), Decision::not_found, "no pressure above zero"},
      {"no numbers", 2001, levels({{2001, not_measured}}), Decision::not_found},
      {"no samples", 0, ramp, Decision::not_found},
      {"suction", 1401, falls_to(-4.0), Decision::found},
  };
  for (const auto& row : rows) {
    const LossOfResistance loss = found_in(row.samples, row.law);
    check::row = row.what;
    CHECK(loss.status == row.decision);
    if (*row.reason != '\0') { CHECK(loss.reason == row.reason); }
  }
  // A drop can be measured without a decision, unless the pressure never settles.
  CHECK(found_in(901, falls_to(8.0)).fell());
  CHECK_NEAR(found_in(901, falls_to(8.0)).plateau, 8.0, 0.0);
  CHECK(found_in(1400, with_gap(falls_to(8.0), 700, 800)).fell());
  CHECK(!found_in(651, falls_to(8.0)).fell());
  CHECK(!found_in(2000, with_gap(falls_to(8.0), 550, 850)).fell());
  // Pushes of a thumb with rests of less than 5 s.
  CHECK(found_in(4001, [](int n) { return std::fmod(step * n, 4.5) < 0.5 ? 60.0 : 2.0; }).status !=
        Decision::found);
  CHECK(found_in(1401, falls_to(0.55 * 60.0)).weak);
  CHECK(found_in(1401, falls_to(-4.0)).relative_drop > 1.0);
  CHECK_NEAR(step * static_cast<double>(found_in(3001, flushed).fallen_index), 18.0, 0.011);
  CHECK(found_in(3000, two_falls(8.0)).fallen_index == 1600);
}

struct Given {
  Values time = clinical::instants(14.0, 200.0);
  Values value{};
  Values depth{};
  [[nodiscard]] Features found() const { return prepare({time, value, depth}, 20.0, {}).features; }
};

Given of(const PressureLaw& law) {
  Given given;
  given.value = clinical::pressures(law, given.time);
  return given;
}

TEST("depth is read at the events") {
  Given given = of({});
  for (const double t : given.time) { given.depth.push_back(0.002 * t); }
  const Features found = given.found();
  CHECK_NEAR(*found[Feature::depth_of_loss].value, 0.002 * *found[Feature::time_of_loss].value,
             1e-12);
  CHECK_NEAR(*found[Feature::depth_of_peak].value, 0.002 * *found[Feature::time_of_peak].value,
             1e-12);
}

TEST("the duration of a fall is that of its law, through the filter") {
  // tau ln 9 from 90 % to 10 % of an exponential fall; a filter of 20 Hz changes it by under 2 %.
  CHECK_NEAR(*of({}).found()[Feature::drop_time].value, 0.15 * std::log(9.0), 0.02 * 0.33);
}

TEST("without a loss of resistance its features are absent, and the peak is that of the trace") {
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

TEST("only a feature that is hidden in the trace is absent, with a reason") {
  Given gap = of({});
  Given early = gap;
  for (std::size_t n = 0; n < gap.time.size(); ++n) {
    if (gap.time[n] > 6.05 && gap.time[n] < 6.25) { gap.value[n] = not_measured; }
  }
  early.time.resize(200 * 9);
  early.value.resize(200 * 9);
  struct {
    Features found;
    Feature hidden;
    const char* reason;
  } const rows[] = {
      {gap.found(), Feature::drop_time, "a gap hides the fall"},
      {early.found(), Feature::loss_of_resistance,
       // the trace ends at 9.00 s; filtered, it falls from 6.1 s
       "the trace ends 2.90 s after a fall of 87 %; 5 s needed"},
      {of({.rise = 0.5, .loss = 1.5}).found(), Feature::slope_before,
       "less than 2.1 s before the peak"},
  };
  for (const auto& [found, hidden, reason] : rows) {
    CHECK(!found[hidden].value);
    CHECK(found[hidden].reason == reason);
    CHECK(found[Feature::peak].value);
    CHECK(found[Feature::plateau].value);
  }
  CHECK(rows[0].found.loss.found());
  CHECK(rows[1].found[Feature::drop_time].value);
}

TEST("noise on samples is measured to a tenth and makes every feature uncertain") {
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

const FeatureRule of_insertion{.set = FeatureSet::insertion};

Features features_of_law(const InsertionLaw& law, double cutoff = 0.0) {
  const Recording recording = recording_of(law, "a law");
  const PreparedTrace prepared =
      prepare({recording.time, recording.force, recording.depth}, cutoff, of_insertion);
  REQUIRE(prepared.refusal.empty());
  return prepared.features;
}

void check_feature(const Features& features, Feature feature, double expected, double tolerance) {
  check::row = std::string(name_of(feature));
  REQUIRE(features[feature].value.has_value());
  CHECK_NEAR(*features[feature].value, expected, tolerance);
  check::row.clear();
}

TEST("the features of an insertion are those of its law") {
  const InsertionLaw law;
  const Features found = features_of_law(law);
  constexpr double sample = 2e-5;  // [m] advance between two samples
  check_feature(found, Feature::puncture, 1.0, 0.0);
  check_feature(found, Feature::puncture_force, law.puncture, 1e-9);
  check_feature(found, Feature::puncture_depth, law.dent, sample);
  // The contact is found up to a sample late: p d/dd of log d at a tenth of the dent, averaged.
  check_feature(found, Feature::denting_exponent, law.exponent, law.exponent * sample / 1.2e-3);
  check_feature(found, Feature::force_left, law.left, 1e-9);
  check_feature(found, Feature::largest_force, law.puncture, 1e-9);
  check_feature(found, Feature::second_rise, law.rise * (law.end - law.dent - law.fall), 1e-9);
  const double in_5_s = law.relaxed * (1.0 - std::exp(-5.0 / law.relaxation_time));
  // The force is averaged over the last 0.2 s, half of it earlier.
  const double slope = law.relaxed / law.relaxation_time * std::exp(-4.8 / law.relaxation_time);
  check_feature(found, Feature::relaxation, in_5_s, 0.2 * slope);
  const double after = -law.relaxation_time * std::log(1.0 - 0.63 * in_5_s / law.relaxed);
  check_feature(found, Feature::relaxation_time, after, 0.03);  // 0.63 of the averaged drop
  check_feature(found, Feature::withdrawal_force, law.pulled, 1e-9);
  check_feature(found, Feature::withdrawal_depth, law.pulled_at, sample);
  CHECK_NEAR(found.phases.speed, law.speed, 1e-9);
  CHECK_NEAR(*found.phases.contact_time.value, law.start / law.speed, 0.01 + 1e-9);  // a sample
}

TEST("the filter and noise change the features of an insertion within what they say") {
  const InsertionLaw law;
  Recording recording = recording_of(law, "a law");
  device::Seeded seeded(3);
  clinical::add_noise(recording.force, 0.0095, seeded);  // that of a rig of phantoms
  const Features found =
      prepare({recording.time, recording.force, recording.depth}, 20.0, of_insertion).features;
  CHECK_NEAR(found.noise, 0.0095, 0.1 * 0.0095);
  const Features exact = features_of_law(law, 20.0);
  for (const Feature feature : features_of(FeatureSet::insertion)) {
    check::row = std::string(name_of(feature));
    REQUIRE(found[feature].value.has_value());
    // Four standard uncertainties; extremes of noisy samples are biased by about two.
    CHECK_NEAR(*found[feature].value, *exact[feature].value,
               4.0 * found[feature].uncertainty + 1e-12);
    if (!is_event(feature)) { CHECK(found[feature].uncertainty > 0.0); }
  }
  check::row.clear();
  // The filter rounds the peak: 20 N/s for 1/(2 pi 20 Hz).
  CHECK_NEAR(*exact[Feature::puncture_force].value, law.puncture, 20.0 / 125.0);
}

TEST("a puncture is the first drop of 15 % within 1 mm, and no other dip") {
  CHECK(*features_of_law({.left = 4.4, .rise = 0.0})[Feature::puncture].value == 0.0);  // 12 %
  const Features absent = features_of_law({.left = 4.4, .rise = 0.0});
  CHECK(absent[Feature::puncture_force].reason == "no drop of 15 % within 1 mm; 12 % at most");
  CHECK(!absent[Feature::denting_exponent].value);
  CHECK(absent[Feature::largest_force].value);
  CHECK(*features_of_law({.left = 4.2, .rise = 0.0})[Feature::puncture].value == 1.0);  // 16 %
  const Features slow = features_of_law({.fall = 6e-3, .rise = 0.0});  // 60 % within 6 mm
  CHECK(*slow[Feature::puncture].value == 0.0);
  CHECK(slow[Feature::puncture_force].reason == "no drop of 15 % within 1 mm; 10 % at most");
}

TEST("a fall of the force at rest is a relaxation and no puncture") {
  const Features found = features_of_law({.end = 11.5e-3, .pulled_at = 8e-3});  // above the dent
  CHECK(*found[Feature::puncture].value == 0.0);
  CHECK(found[Feature::relaxation].value);
}

TEST("what an insertion does not show is absent with its reason") {
  const Features without_hold = features_of_law({.hold = 0.5});
  CHECK(without_hold[Feature::relaxation].reason == "no hold of 1 s at full depth");
  CHECK(features_of_law({.hold = 3.0})[Feature::relaxation].reason ==
        "a hold of 3 s; 4.5 s needed");
  const Features stiff = features_of_law({.relaxed = 0.0});
  check_feature(stiff, Feature::relaxation, 0.0, 1e-12);
  CHECK(stiff[Feature::relaxation_time].reason == "the force does not fall in the hold");
  const InsertionLaw law;
  Recording recording = recording_of(law, "a law");
  const auto end = static_cast<std::size_t>(law.rate * (law.advance_time() + law.hold));
  for (auto* values : {&recording.time, &recording.force, &recording.depth}) {
    values->resize(end);
  }
  const Features stays =
      prepare({recording.time, recording.force, recording.depth}, 0.0, of_insertion).features;
  CHECK(stays[Feature::withdrawal_force].reason == "the needle is not withdrawn");
  CHECK(stays[Feature::relaxation].value);
  const Features shallow =
      prepare({recording.time, recording.force, {}}, 0.0, of_insertion).features;
  CHECK(shallow[Feature::puncture].reason == "depth was not recorded");
  check_feature(shallow, Feature::largest_force, law.puncture, 1e-9);
  const Features untouched = features_of_law({.preload = 0.0, .factor = 0.01});
  CHECK(untouched[Feature::puncture].reason ==
        "no contact: the force never stays above 0.1 N over 1 mm");
  CHECK(!untouched.phases.contact);
}

TEST("a gap in the fall after a puncture does not hide the puncture") {
  const InsertionLaw law;
  Recording recording = recording_of(law, "a law");
  const auto puncture = static_cast<std::size_t>(law.rate * (law.start + law.dent) / law.speed);
  for (std::size_t n = 1; n < 10; ++n) { recording.force[puncture + n] = not_measured; }
  const Features found =
      prepare({recording.time, recording.force, recording.depth}, 0.0, of_insertion).features;
  check_feature(found, Feature::puncture_force, law.puncture, 1e-9);
  check_feature(found, Feature::force_left, law.left, 1e-9);
}

TEST("features have units of the trace, and each has its own name") {
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

}  // namespace PALPATE_FILE

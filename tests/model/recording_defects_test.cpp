// SPDX-License-Identifier: MIT
#include "model/dynamics/recording_defects.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

/// A pressure that never repeats a value, 100 samples a second.
Recording ramp(std::size_t samples) {
  Recording recording;
  for (std::size_t n = 0; n < samples; ++n) {
    recording.time.push_back(0.01 * double(n));
    recording.pressure.push_back(1000.0 + double(n));
  }
  return recording;
}

Recording counted(Recording recording) {
  leave_out_rows_out_of_order(recording);
  count_defects(recording);
  return recording;
}

TEST("a clean ramp has no defects, and its rate is that of its steps") {
  const Recording recording = counted(ramp(500));
  CHECK((recording.defects == RecordingDefects{}));
  const Sampling sampling = sampling_of(recording.time);
  CHECK_NEAR(sampling.rate, 100.0, 1e-9);  // rounding of times near 5 s
  CHECK(sampling.uneven == 0.0);
}

TEST("gaps are places, missing samples what would fill them") {
  Recording recording = ramp(500);
  for (std::size_t n = 100; n < 500; ++n) { recording.time[n] += 0.03; }
  for (std::size_t n = 300; n < 500; ++n) { recording.time[n] += 1.0; }
  const Recording found = counted(recording);
  CHECK(found.defects.gaps == 2);
  CHECK(found.defects.missing == 3 + 100);
  CHECK(found.pressure.size() == 500);  // nothing is put in
}

TEST("rows that do not come after the row before are left out whole, and counted") {
  Recording recording = ramp(10);
  recording.depth = recording.pressure;
  recording.time[3] = recording.time[2];  // twice the same
  recording.time[6] = 0.015;              // back
  recording.time[8] = nan;
  const Recording found = counted(recording);
  CHECK(found.defects.not_increasing == 3);
  CHECK((found.pressure == std::vector<double>{1000, 1001, 1002, 1004, 1005, 1007, 1009}));
  CHECK(found.depth == found.pressure);
  CHECK(found.time.size() == 7);
}

TEST("what is no number stays in as NaN") {
  Recording recording = ramp(20);
  recording.pressure[4] = nan;
  recording.pressure[5] = inf;
  recording.pressure[6] = -inf;
  const Recording found = counted(recording);
  CHECK(found.defects.not_finite == 3);
  CHECK(std::isnan(found.pressure[4]) && std::isnan(found.pressure[5]));
  CHECK(found.defects.out_of_range == 0);
  CHECK(found.pressure.size() == 20);
}

TEST("pressures that no transducer can mean are out of range, and so is what one says") {
  Recording recording = ramp(20);
  recording.pressure[3] = -101400.0;  // below vacuum
  recording.pressure[4] = 3277.0 * 133.322387415;
  recording.pressure[5] = 3276.7 * 133.322387415;  // the largest that the link carries
  std::vector<char> told(20, 0);
  told[4] = told[9] = 1;
  count_defects(recording, {}, told);
  CHECK(recording.defects.out_of_range == 3);
}

TEST("a flat stretch at an extreme counts as clipped from the stated length on") {
  const std::size_t run = DefectRules{}.flat_run;
  for (const std::size_t length : {run - 1, run, run + 7}) {
    Recording recording = ramp(200);
    for (std::size_t n = 100; n < 100 + length; ++n) { recording.pressure[n] = 5000.0; }
    CHECK(counted(recording).defects.clipped == (length < run ? 0 : length));
    for (std::size_t n = 100; n < 100 + length; ++n) { recording.pressure[n] = 1150.5; }
    CHECK(counted(recording).defects.clipped == 0);  // flat, but neither largest nor smallest
  }
  Recording constant = ramp(200);
  constant.pressure.assign(200, 700.0);
  CHECK(counted(constant).defects.clipped == 0);
}

TEST("uneven sampling is told from rounding to milliseconds") {
  Recording rounded = ramp(1200);
  Recording jittered = rounded;
  for (std::size_t n = 0; n < 1200; ++n) {
    rounded.time[n] = std::round(1000.0 * double(n) / 120.0) * 1e-3;
    jittered.time[n] += n % 2 == 0 ? 0.0 : 0.004;
  }
  CHECK(sampling_of(rounded.time).uneven == 0.0);
  CHECK_NEAR(sampling_of(rounded.time).rate, 120.0, 0.1);  // the last step is rounded too: 1 ms of 10 s
  CHECK(sampling_of(jittered.time).uneven > 0.4);
}

TEST("what cannot be used is said in words") {
  CHECK(why_unusable(ramp(2)).empty());
  CHECK(why_unusable({}) == "has no samples; at least two are needed");
  CHECK(why_unusable(ramp(1)) == "has one sample; at least two are needed");
  Recording recording = ramp(3);
  recording.depth = {1.0};
  CHECK(why_unusable(recording).starts_with("depth has 1 values and time 3"));
  recording = ramp(3);
  recording.pressure.assign(3, nan);
  CHECK(why_unusable(recording).starts_with("pressure has no number at all"));
  recording.pressure.assign(3, 0.0);
  CHECK(why_unusable(recording).empty());
  recording.time[2] = 1.7e12;  // milliseconds since 1970, called seconds
  CHECK(why_unusable(recording).starts_with("lasts more than 1e9 s"));
}

}  // namespace

// SPDX-License-Identifier: MIT

#include "validation/comparison/link_recording.hpp"

#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using clinical::largest_difference;

constexpr std::size_t plenty = 100000;
constexpr double step = 0.1 * pascals_per_mmhg;  // resolution of the link [Pa]

/// Values in whole resolution steps of the link, at the given sample rate.
Recording wave(double rate, std::size_t samples) {
  Recording recording{.sample_rate = rate};
  for (std::size_t n = 0; n < samples; ++n) {
    const double time = double(n) / rate;
    recording.time.push_back(time);
    recording.pressure.push_back(std::round(3000.0 * std::sin(time) + double(n % 7)) * step);
  }
  return recording;
}

TEST("a recording at the rate of the link is the same after sending and receiving") {
  const Recording sent = wave(120.0, 3000);
  const LinkRecording heard = recording_of_link(link_bytes(link_frames(sent)), plenty);
  REQUIRE(heard.recording.time.size() == 3000);
  CHECK(largest_difference(heard.recording.time, sent.time) <= 1e-12);  // rounding of n / 120
  // Rounding of a product.
  CHECK(largest_difference(heard.recording.pressure, sent.pressure) <= 1e-9 * step);
  CHECK((heard.recording.defects == RecordingDefects{}));
  CHECK(heard.recording.sample_rate == 120.0);
}

TEST("another rate is interpolated within the curvature of a sine and half a step") {
  Recording sent{.sample_rate = 1000.0};
  const double amplitude = 300.0 * pascals_per_mmhg;
  for (int n = 0; n <= 5000; ++n) {
    sent.time.push_back(7.0 + 1e-3 * n);
    sent.pressure.push_back(amplitude * std::sin(2.0 * 1e-3 * n));
  }
  const LinkRecording heard = recording_of_link(link_bytes(link_frames(sent)), plenty);
  std::vector<double> truth;
  for (int n = 0; n < 601; ++n) { truth.push_back(amplitude * std::sin(2.0 * n / 120.0)); }
  REQUIRE(heard.recording.pressure.size() == 601);
  // Linear interpolation over h errs by at most h^2 / 8 times the second derivative; besides, a
  // time within a thousandth of a frame of a sample takes its value.
  const double bound = 1e-6 / 8.0 * 4.0 * amplitude + 0.5 * step + 2.0 * amplitude * 1e-3 / 120.0;
  CHECK(largest_difference(heard.recording.pressure, truth) <= bound);
}

TEST("gaps and NaN are not sent, and are missing in the received recording") {
  Recording sent = wave(120.0, 1000);
  sent.pressure[500] = std::nan("");
  for (std::vector<double>* values : {&sent.time, &sent.pressure}) {
    values->erase(values->begin() + 100, values->begin() + 130);
  }
  const Recording heard = recording_of_link(link_bytes(link_frames(sent)), plenty).recording;
  CHECK(heard.defects.gaps == 2);
  CHECK(heard.defects.missing == 31);
  REQUIRE(heard.time.size() == 969);
  CHECK_NEAR(heard.time.back(), 999.0 / 120.0, 1e-12);
  CHECK(heard.defects.bad_frames == 0);
}

TEST("values beyond the range of a frame are cut, marked and counted once") {
  Recording sent = wave(120.0, 100);
  sent.pressure[50] = 4000.0 * pascals_per_mmhg;
  sent.pressure[51] = -4000.0 * pascals_per_mmhg;
  const LinkFrames frames = link_frames(sent);
  for (const std::size_t n : {49U, 50U, 51U, 52U}) {
    CHECK(frames[n]->over_range == (n == 50 || n == 51));
  }
  CHECK(frames[50]->pressure == 32767);
  CHECK(frames[51]->pressure == -32768);
  CHECK(recording_of_link(link_bytes(frames), plenty).recording.defects.out_of_range == 2);
}

TEST("damaged bytes lose only their own frames, and the defects count these") {
  const Recording sent = wave(120.0, 2000);
  std::vector<std::uint8_t> bytes = link_bytes(link_frames(sent));
  for (const std::size_t frame : {100U, 101U, 700U, 1500U}) { bytes[8 * frame + 5] ^= 0x40U; }
  bytes.erase(bytes.begin() + 8 * 1800 + 3);
  const LinkRecording heard = recording_of_link(bytes, plenty);
  const RecordingDefects& defects = heard.recording.defects;
  REQUIRE(heard.recording.time.size() == 1995);
  CHECK(defects.missing == 5);
  CHECK(defects.gaps == 4);
  CHECK(defects.bad_frames == 5);
  CHECK_NEAR(heard.recording.time.back(), 1999.0 / 120.0, 1e-12);
}

TEST("bytes without a frame are an empty recording, and reading stops at the limit") {
  const std::vector<std::uint8_t> nothing(1000, 0x41);
  CHECK(recording_of_link(nothing, plenty).recording.time.empty());
  const std::vector<std::uint8_t> many = link_bytes(link_frames(wave(120.0, 500)));
  CHECK(recording_of_link(many, 100).recording.time.size() == 101);
}

}  // namespace PALPATE_FILE

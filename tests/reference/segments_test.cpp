// SPDX-License-Identifier: MIT
#include "reference/segments.hpp"

#include "reference/solution.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using palpate::NetworkProblem;
using palpate::reference::Segment;
using palpate::reference::segments_of;

namespace {
const NetworkProblem pulsed(sample::block({.nodes = 2}), {sample::pulse(0.1)});
}  // namespace

TEST("segments begin and end at breaks and gates lie inside them") {
  const auto segments = segments_of(pulsed, {0.0, 0.01, 0.05});
  CHECK(segments.size() == 3);
  const double ends[] = {0.0, 5e-3, 15e-3, 0.05};
  for (std::size_t n = 0; n < segments.size(); ++n) {
    CHECK(segments[n].start == ends[n]);
    CHECK(segments[n].end == ends[n + 1]);
    CHECK(segments[n].gate > segments[n].start && segments[n].gate < segments[n].end);
    CHECK(segments[n].stops.back().time == segments[n].end);
  }
}

TEST("no step may be longer than a quarter of the shortest feature or a tenth of its segment") {
  for (const Segment& segment : segments_of(pulsed, {0.0, 10.0})) {
    CHECK(segment.max_step <= pulsed.shortest_feature() / 4.0);
    CHECK(segment.max_step <= (segment.end - segment.start) / 10.0);
  }
}

TEST("every requested time is a stop exactly once") {
  const auto times = sample::instants(0.05, 100);
  std::vector<int> seen(times.size(), 0);
  for (const Segment& segment : segments_of(pulsed, times)) {
    for (const auto& stop : segment.stops) {
      if (!stop.output) { continue; }
      ++seen[*stop.output];
      CHECK_NEAR(stop.time, times[*stop.output], 1e-14);
    }
  }
  CHECK(seen[0] == 0);  // the initial state needs no stop
  for (std::size_t n = 1; n < seen.size(); ++n) { CHECK(seen[n] == 1); }
}

TEST("a requested time within rounding of a break is the break") {
  const double just_before = std::nextafter(15e-3, 0.0);
  const auto segments = segments_of(pulsed, {0.0, just_before, 0.05});
  CHECK(segments.size() == 3);
  CHECK(segments[1].stops.size() == 1);
  CHECK(segments[1].stops[0].output == 1U);
}

TEST("breaks after the last requested time are ignored") {
  CHECK(segments_of(pulsed, {0.0, 4e-3}).size() == 1);
  CHECK(segments_of(pulsed, {0.0}).empty());
}

TEST("times that do not ascend from zero are refused") {
  CHECK_THROWS(segments_of(pulsed, {}), "begin at 0");
  CHECK_THROWS(segments_of(pulsed, {0.1, 0.2}), "begin at 0");
  CHECK_THROWS(segments_of(pulsed, {0.0, 0.2, 0.2}), "not later");
  CHECK_THROWS(segments_of(pulsed, {0.0, std::nan("")}), "not later");
}

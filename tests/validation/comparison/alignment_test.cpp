// SPDX-License-Identifier: MIT
#include "validation/comparison/alignment.hpp"

#include "tests/check.hpp"
#include "validation/cases/clinical_traces.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;
using clinical::PressureLaw;

/// A law whose clock began `clock` seconds before, with a needle that has moved at `speed` since the rise.
PreparedTrace prepared(const PressureLaw& law, double clock, double speed = 0.0) {
  std::vector<double> time = clinical::instants(16.0, 200.0);
  const std::vector<double> value = clinical::pressures(law, time);
  std::vector<double> depth;
  for (const double t : time) { depth.push_back(0.02 + speed * (t - law.delay)); }
  for (double& t : time) { t += clock; }
  return prepare({time, value, speed > 0.0 ? std::span<const double>(depth) : std::span<const double>()},
                 20.0, {});
}

TEST("two clocks are laid over each other by the event when there is no depth") {
  const Alignment found = align(prepared({}, 100.0), prepared({.delay = 1.0}, 0.0), AlignmentRule::automatic);
  CHECK(found.used == AlignmentRule::event && !found.judges_times());
  CHECK(found.not_by_depth.empty());
  CHECK(found.how == "by the loss of resistance");
  CHECK_NEAR(found.lag, 99.0, 1e-6);  // the same law, a second later
}

TEST("without a loss in both the peak is taken, and said to be") {
  const Alignment found =
      align(prepared({}, 0.0), prepared({.plateau = PressureLaw{}.peak}, 5.0), AlignmentRule::event);
  CHECK(found.refusal.empty());
  CHECK(found.how.find("peak") != std::string::npos);
}

TEST("depth comes first where both have it") {
  const Alignment found =
      align(prepared({}, 50.0, 0.005), prepared({.delay = 2.0}, 0.0, 0.005), AlignmentRule::automatic);
  CHECK(found.used == AlignmentRule::depth && !found.judges_times());
  CHECK_NEAR(found.lag, 48.0, 1e-6);  // both needles at the same place
}

TEST("an event at another depth is left where it is") {
  // The same speed and start, the loss a second later: by depth there is no lag to hide it.
  const Alignment found =
      align(prepared({.loss = 6.0}, 0.0, 0.005), prepared({.loss = 7.0}, 0.0, 0.005), AlignmentRule::depth);
  CHECK_NEAR(found.lag, 0.0, 1e-6);
}

TEST("by the start the first samples coincide, whatever happens later") {
  const Alignment found = align(prepared({}, 30.0), prepared({.delay = 1.0}, 10.0), AlignmentRule::start);
  CHECK(found.used == AlignmentRule::start && found.judges_times());
  CHECK_NEAR(found.lag, 20.0, 1e-9);
}

TEST("depth that was asked for and is not there is refused, not replaced") {
  CHECK(align(prepared({}, 0.0), prepared({}, 0.0, 0.005), AlignmentRule::depth).refusal ==
        "the recording has no depth");
  CHECK(align(prepared({}, 0.0, 0.005), prepared({}, 0.0), AlignmentRule::depth).refusal ==
        "the simulated trace has no depth");
}

TEST("depths that do not meet cannot align anything") {
  PreparedTrace deep = prepared({}, 0.0, 0.005);
  for (double& d : deep.input.depth.value) { d += 1.0; }
  CHECK(align(deep, prepared({}, 0.0, 0.005), AlignmentRule::depth).refusal.find("do not meet") !=
        std::string::npos);
}

TEST("a gap over the depth of the event is not bridged: the event decides, and that is said") {
  PreparedTrace gap = prepared({}, 50.0, 0.005);
  // The event is at 6.1 s, so half a second on either side of it has no depth.
  for (std::size_t n = 0; n < gap.input.depth.size(); ++n) {
    if (std::abs(gap.input.depth.time(n) - 56.1) < 0.5) { gap.input.depth.value[n] = not_measured; }
  }
  const PreparedTrace whole = prepared({.delay = 2.0}, 0.0, 0.005);
  const double depth = 1e3 * *whole.features[Feature::depth_of_loss].value;
  char expected[80];
  std::snprintf(expected, sizeof expected, "a gap hides when the simulated tip reached %.1f mm", depth);
  CHECK(align(whole, gap, AlignmentRule::depth).refusal == expected);
  const Alignment found = align(whole, gap, AlignmentRule::automatic);
  CHECK(found.used == AlignmentRule::event);
  CHECK(found.not_by_depth == expected);
  CHECK(found.how == "by the loss of resistance, not by depth: " + std::string(expected));
  CHECK_NEAR(found.lag, 2.0 - 50.0, 1e-6);
}

TEST("a depth at which a trace begins above it was passed before") {
  PreparedTrace late = prepared({}, 0.0, 0.005);
  late.input.depth.value[0] = 0.2;  // drawn back at once, as it seems
  CHECK(!align(late, prepared({}, 0.0, 0.005), AlignmentRule::depth).refusal.empty());
}

}  // namespace

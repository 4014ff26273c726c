// SPDX-License-Identifier: MIT
#include "validation/comparison/zero_phase.hpp"

#include <algorithm>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

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
  // Three periods of the cut-off leave exp(-2 pi 3 / sqrt(2)) = 2e-6 of the start of a run.
  for (std::size_t n = 0; n < 300; ++n) { CHECK_NEAR(filtered.value[n], line.value[n], 1e-5 * 0.7 * 30.0); }
}

TEST("forward or backward in time is the same") {
  Samples there = noise(400);
  Samples back = there;
  std::ranges::reverse(back.value);
  there = zero_phase(there, 8.0);
  back = zero_phase(back, 8.0);
  std::ranges::reverse(back.value);
  // Away from the ends, where each run starts in a steady state of its own.
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
  const NoiseShares shares = noise_shares(12.0, 1.0 / step);  // Parseval; midpoint rule of 2000 points
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
  CHECK(filtered.value[0] == 1.0 && filtered.value[1] == -1.0 && filtered.value[3] == 5.0);
}

TEST("a cut-off that the rate cannot carry, or none, changes nothing") {
  const Samples samples = noise(50);
  CHECK(!can_filter(40.0, 100.0) && !can_filter(0.0, 100.0) && can_filter(39.0, 100.0));
  CHECK(zero_phase(samples, 40.0).value == samples.value);
  CHECK(zero_phase(samples, 0.0).value == samples.value);
}

}  // namespace

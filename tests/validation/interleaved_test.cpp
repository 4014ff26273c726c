// SPDX-License-Identifier: MIT
#include "validation/bench/interleaved.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate::bench;

/// Work that no optimiser removes, in proportion to `amount`.
void work(long amount) {
  volatile double x = 1.0;
  for (long n = 0; n < amount; ++n) { x = std::sqrt(x + 1.0); }
}

TEST("eight times the work takes many times as long, and times stand in the order of the contenders") {
  const std::vector<Contender> contenders{
      {"heavy", [](long times) { work(8000 * times); }},
      {"light", [](long times) { work(1000 * times); }}};
  const std::vector<Timed> timed = time_interleaved(contenders, {.rounds = 5, .batch = 2e-3});
  CHECK(timed.size() == 2);
  CHECK(timed[0].name == "heavy" && timed[1].name == "light");
  const double ratio = timed[0].least / timed[1].least;
  std::printf("  ratio %.2f\n", ratio);
  CHECK(ratio > 4.0 && ratio < 16.0);  // a factor of two for what else the processor does
  for (const Timed& each : timed) { CHECK(each.least > 0.0 && each.least <= each.median); }
}

TEST("every contender has every round") {
  std::vector<int> calls(3, 0);
  std::vector<Contender> contenders;
  for (std::size_t n = 0; n < calls.size(); ++n) {
    contenders.push_back({"", [&calls, n](long times) {
                            ++calls[n];
                            work(1000 * times);
                          }});
  }
  (void)time_interleaved(contenders, {.rounds = 4, .batch = 1e-4});
  for (const int count : calls) { CHECK(count >= 4 + 1); }  // the rounds, and what found their length
}

}  // namespace

// SPDX-License-Identifier: MIT
/// What a second thread is worth to a lattice, where a second processor is free to run it.
#include <algorithm>
#include <cmath>
#include <thread>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/kernel_tables.hpp"
#include "validation/bench/kernel_variants.hpp"
#include "validation/bench/machine_limits.hpp"

namespace palpate::bench {

namespace {

constexpr double wanted_speed_up = 1.7;
/// Of the 2 that a second processor can bring, 1.8 must be left by what else the machine does.
constexpr double most_slowdown = 1.1;

struct Pair {
  int n = 0;
  KernelVariant variant{};
  double one = 0.0;  ///< [ns] per spring and step, least by the wall clock
  double two = 0.0;
  double two_median = 0.0;
  double slowdown = 0.0;  ///< of roots and quotients before, or of two copies of the same steps after

  [[nodiscard]] bool second_was_free() const { return slowdown <= most_slowdown; }
};

/// One thread and two in turn, both made anew each time: threads that wait do so by looking, so those of the
/// pair must exist only while they are timed, and then the one must not have older memory than the two.
Pair time_pair(const KernelVariant& variant, int n) {
  KernelVariant shared = variant;
  shared.threads = 2;
  std::unique_ptr<Stepping> stepping;
  const auto contender = [&](const char* name, const KernelVariant& of) {
    return Contender{name, [&](long times) { stepping->step(times); }, Clock::wall,
                     [&stepping, &of, n] {
                       stepping = stepping_of(of, n);
                       stepping->step(3);  // the first touch new memory
                     },
                     [&stepping] { stepping.reset(); }};
  };
  const Contender one = contender("one", variant);
  const Contender two = contender("two", shared);
  const std::vector<Timed> timed = time_interleaved({one, two}, {.rounds = 5, .batch = 0.03});
  const std::unique_ptr<Stepping> alone = stepping_of(variant, n);
  const std::unique_ptr<Stepping> copy = stepping_of(variant, n);
  const long times = std::max(1L, std::lround(0.02 / timed[0].least));  // 20 ms
  const double scale = 1e9 / alone->springs();
  return {.n = n,
          .variant = variant,
          .one = scale * timed[0].least,
          .two = scale * timed[1].least,
          .two_median = scale * timed[1].median,
          .slowdown = side_by_side_slowdown([&] { alone->step(times); }, [&] { copy->step(times); })};
}

Table pairs_table(const std::vector<Pair>& pairs) {
  Table table{.id = "threads",
              .title = "One thread and two",
              .caption =
                  "Nanoseconds per spring and step, least of interleaved rounds by the wall clock: the "
                  "processor time of one thread would leave out what the other does. Both compute the same "
                  "bits. Side by side: how many times longer two copies of roots and quotients took than one "
                  "before, or two copies of the same steps after; the larger.",
              .columns = {"kernel", "n", "one thread (ns)", "two threads (ns)", "two, median (ns)",
                          "one / two (1)", "side by side (1)"},
              .timing = true};
  for (const Pair& pair : pairs) {
    table.rows.push_back({std::string(pair.variant.name), static_cast<double>(pair.n), pair.one, pair.two,
                          pair.two_median, pair.one / pair.two, pair.slowdown});
  }
  return table;
}

/// Only while a second processor is free, before and after; what was timed in between is shown in any case.
std::vector<Pair> time_pairs(const CaseContext& context, double& most) {
  std::vector<Pair> pairs;
  for (const int n : context.quick ? std::vector{40} : std::vector{40, 80}) {
    for (const KernelVariant& variant : largest_variants()) {
      if (context.quick && variant.uneven) { continue; }
      const double before = side_by_side_slowdown();
      most = std::max(most, before);
      if (before > most_slowdown) { continue; }
      pairs.push_back(time_pair(variant, n));
      pairs.back().slowdown = std::max(before, pairs.back().slowdown);
      most = std::max(most, pairs.back().slowdown);
    }
  }
  return pairs;
}

void measure(const CaseContext& context, Outcome& outcome) {
  if (std::thread::hardware_concurrency() < 2) {
    outcome.skip("this machine has one processor");
    return;
  }
  double most = 0.0;
  const std::vector<Pair> pairs = time_pairs(context, most);
  if (!pairs.empty()) { outcome.tables = {pairs_table(pairs)}; }
  for (const Pair& pair : pairs) {
    if (pair.variant.uneven || !pair.second_was_free()) { continue; }
    outcome.judge({.name = "one_over_two_" + std::string(pair.variant.in_double() ? "double" : "float") +
                           "_n" + std::to_string(pair.n),
                   .value = pair.one / pair.two,
                   .lower = wanted_speed_up,
                   .bound_from = "asked of the project: two processors at least 1.7 times one"});
  }
  const std::string busy = "two copies of the same work side by side took up to " + two_digits(most) +
                           " times as long as one; at most " + two_digits(most_slowdown) +
                           " where two processors are free";
  if (outcome.quantities.empty()) {
    outcome.skip("no second processor was free: " + busy);
  } else if (most > most_slowdown) {
    outcome.notes.push_back("Not judged where no second processor was free, or memory held both up: " + busy +
                            ".");
  }
}

}  // namespace

std::vector<Case> thread_cases() {
  return {{.name = "bench/threads",
           .suite = "timing",
           .claim = "Two threads take a lattice of 40 nodes a side or more 1.7 times as fast as one.",
           .measure = measure,
           .weight = 30.0}};
}

}  // namespace palpate::bench

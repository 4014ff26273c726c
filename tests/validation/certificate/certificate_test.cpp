// SPDX-License-Identifier: MIT

#include "validation/certificate/certificate.hpp"

#include <functional>

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"
#include "validation/certificate/tail.hpp"

namespace PALPATE_FILE {

using namespace palpate::certificate;
using namespace palpate;
TEST("the limit of the probability of a miss is that of Clopper and Pearson") {
  // After no miss 1 - 0.05^(1/n).
  CHECK_NEAR(miss_probability_upper(0, 60000), 1.0 - std::pow(0.05, 1.0 / 60000.0), 1e-15);
  CHECK_NEAR(miss_probability_upper(0, 1), 0.95, 1e-15);
  CHECK_NEAR(miss_probability_upper(1, 2), std::sqrt(0.95), 1e-12);  // P(X <= 1) = 1 - p^2 = 0.05
  // If all ticks missed, or none ran, a probability of one cannot be excluded.
  CHECK_NEAR(miss_probability_upper(3, 3), 1.0, 0.0);
  CHECK_NEAR(miss_probability_upper(0, 0), 1.0, 0.0);
  for (long misses = 0; misses < 50; ++misses) {
    CHECK(miss_probability_upper(misses, 1000) < miss_probability_upper(misses + 1, 1000));
    CHECK(miss_probability_upper(misses, 2000) < miss_probability_upper(misses, 1000));
  }
  constexpr long day = 86400000;  // ticks at 1 kHz
  for (const long misses : {1L, 10L, 1000L, 1000000L, day - 1}) {
    const double limit = miss_probability_upper(misses, day);
    CHECK(limit > static_cast<double>(misses) / day);
    CHECK(limit <= 1.0);
  }
}

TEST("the ticks needed for a miss rate are the least whose limit it is") {
  CHECK(ticks_needed(1e-3) == 2995);  // log(0.05) / log(0.999) = 2994.2
  CHECK(ticks_needed(1e-3, 0.99) == 4603);
  for (const double rate : {0.5, 0.05, 1e-3, 1e-6}) {
    const long needed = ticks_needed(rate);
    CHECK(miss_probability_upper(0, needed) <= rate);
    CHECK(miss_probability_upper(0, needed - 1) > rate);
  }
}

constexpr double deadline = 1e-3;

void fill(Phase& phase, long ticks, long misses) {
  for (long n = 0; n < ticks; ++n) {
    const double due = 1e-3 * static_cast<double>(n);
    phase.record.add({.due = due, .begin = due, .end = due + (n < misses ? 2.0 : 0.5) * deadline},
                     {});
  }
}

Certificate clean(long control_misses = 0, long scene_misses = 0) {
  Certificate all;
  all.claim = {.rate = 1000.0, .deadline = deadline, .duration = 1.0, .max_miss_rate = 5e-3};
  all.budget.probes = {{.name = "first tick", .processor = 0.4 * deadline}};
  LoadResult& load = all.loads.emplace_back("idle", deadline);
  fill(load.control, 1000, control_misses);
  fill(load.scene, 1000, scene_misses);
  return all;
}

struct Row {
  const char* what;
  std::function<void(Certificate&)> change;
  Status status;
  const char* reason = "";
};

TEST("only a scene without a miss, in an environment without a miss, is certified") {
  CHECK_NEAR(clean().worst()->miss_probability_upper(), 1.0 - std::pow(0.05, 1e-3), 1e-15);
  CHECK(outcome_of(clean(0, 1)).status == Status::fail);
  CHECK_CONTAINS(outcome_of(clean(0, 1)).reason(), "1 of 1000 deadlines");
  // If the empty loop missed its deadline, the scene cannot be judged.
  CHECK(outcome_of(clean(1, 0)).status == Status::inconclusive);
  CHECK(outcome_of(clean(1, 500)).status == Status::inconclusive);
  using enum Status;
  const Row rows[] = {
      {"no change", [](auto&) {}, pass, "No tick of 1000 missed"},
      {"no real-time priority", [](auto& c) { c.rights.fifo = "Operation not permitted"; },
       inconclusive, "SCHED_FIFO (Operation not permitted)"},
      {"memory not locked", [](auto& c) { c.rights = {.memory = "Cannot allocate"}; },
       inconclusive},
      {"late probe",
       [](auto& c) { c.budget.probes = {{.name = "cold caches", .processor = 1.01e-3}}; }, fail,
       "cold caches"},
      {"probe that is not a number",
       [](auto& c) { c.budget.probes.front().processor = std::nan(""); }, fail},
      {"scene abandoned", [](auto& c) { c.loads.front().scene.hopeless = true; }, fail},
      {"empty loop abandoned", [](auto& c) { c.loads.front().control.hopeless = true; },
       inconclusive},
      {"ticks of which every second steps the tissue",
       [](auto& c) { c.claim.ticks_per_step = c.loads.front().scene.ticks_per_step = 2; }, fail,
       "1000 of the 1196 ticks without a miss under load \"idle\" that show fewer than one miss in "
       "200 with 95 % confidence, of the one tick in 2 that steps the tissue"},
      {"ticks that suffice for one miss in 200 and not in 1000",
       [](auto& c) { c.claim.max_miss_rate = 1e-3; }, fail,
       "Not enough evidence: 1000 of the 2995 ticks without a miss under load \"idle\" that show "
       "fewer than one miss in 1000 with 95 % confidence; a duration of at least 2.995 s."},
      {"one tick under the second load",
       [](auto& c) { fill(c.loads.emplace_back("cpu", deadline).scene, 1, 0); }, fail,
       "Not enough evidence: 1 of the 598 ticks without a miss under load \"cpu\""},
      {"events that the scene does not reach",
       [](auto& c) {
         c.budget.absent = {"contact", "end of the withdrawal"};
       },
       fail,
       "Not enough evidence: the scene ends before events that it declares: contact, end of the "
       "withdrawal."},
      {"no probe", [](auto& c) { c.budget.probes.clear(); }, fail, "no tick was provoked"},
      {"divergence, whatever the environment",
       [](auto& c) {
         c = clean(5, 5);
         c.budget.diverged_at = 0.25;
       },
       fail},
      {"no load", [](auto& c) { c.loads.clear(); }, inconclusive},
      {"interrupted before the scene ran",
       [](auto& c) {
         c.loads.clear();
         fill(c.loads.emplace_back("idle", deadline).control, 10, 0);
       },
       inconclusive},
  };
  for (const Row& row : rows) {
    Certificate all = clean();
    row.change(all);
    const Outcome outcome = outcome_of(all);
    check::row = row.what;
    CHECK(outcome.status == row.status);
    CHECK_CONTAINS(outcome.reason(), row.reason);
  }
}

TEST("one load that fails is enough, and it is shown") {
  Certificate all = clean();
  LoadResult& load = all.loads.emplace_back("memory", deadline);
  fill(load.control, 1000, 0);
  fill(load.scene, 1000, 2);
  CHECK(outcome_of(all).status == Status::fail);
  CHECK(all.worst()->load == "memory");
}

TEST("suspects of lost time follow from the counters; the budget is a share of the deadline") {
  Phase phase(deadline);
  CHECK(suspects(phase).empty());
  phase.times.stolen = 0.25;
  phase.counts.involuntary_switches = 3;
  CHECK_CONTAINS(suspects(phase), "hypervisor took", "3 times");
  CHECK_CONTAINS(budget_text(clean(1000, 0)), "40 % of the deadline");
}

/// Runs on its own thread, as the procedure requires, and in virtual time.
Certificate certified(CertifyPlan plan) {
  device::VirtualClock time;
  plan.clock = &time;
  plan.cache_bytes = 1U << 20U;
  Certificate result;
  std::thread([&] { result = certify(insertion_scene(0.05), plan); }).join();
  return result;
}

TEST("each load runs the empty loop and the scene, a short one repeatedly, for equal ticks") {
  const Certificate all = certified({.claim = {.duration = 0.12}, .loads = {"idle", "cpu"}});
  CHECK(all.loads.front().scene.steps() == 120);
  // At four times the rate of the scene every fourth tick steps it.
  const Certificate faster = certified({.claim = {.rate = 4000.0, .duration = 0.05}});
  CHECK(faster.loads.front().scene.record.ticks() == 200);
  CHECK(faster.loads.front().scene.steps() == 50);
  CHECK(faster.claim.ticks_needed() == 4 * 2995);
  CHECK(all.loads.size() == 2);
  for (const LoadResult& load : all.loads) {
    CHECK(load.control.record.ticks() == 120);
    CHECK(load.scene.record.ticks() == 120);
    CHECK(load.scene.restarts == 2);
    CHECK(load.control.restarts == 0);
    CHECK_CONTAINS(load.tail.refusal, "too few ticks");
  }
  CHECK(!all.interrupted);
  CHECK(all.notes.size() == (all.rights.alone ? 0 : 1));  // on one processor loads share it
}

TEST("without real-time rights nothing is certified") {
  const Certificate all = certified({.claim = {.duration = 0.05}, .ask_for_rights = false});
  CHECK(!all.rights.all());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("Ctrl-C leaves a certificate of the loads that ran") {
  const std::atomic<bool> stop{true};
  const Certificate all = certified({.stop = &stop});
  CHECK(all.interrupted);
  REQUIRE(all.loads.empty());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a loop shorter than its scene has a note, counters and the bound of a missed tick") {
  int reads = 0;
  const Certificate all = certified(
      {.claim = {.duration = 0.02}, .tissue_stiffness = 1500.0, .processor_times = [&](int) {
         return ProcessorTimes{.stolen = 1.0 * ++reads};
       }});
  REQUIRE(all.notes.size() == 1);
  CHECK_CONTAINS(all.notes.front(), "first 20 of the scene's 50 ticks");
  CHECK(reads == 4);  // before and after each loop
  CHECK_NEAR(all.loads.front().scene.times.stolen, 1.0, 0.0);
  // A tool without a device has the bound of the tissue's stiffness.
  REQUIRE(all.missed_tick.has_value());
  CHECK(!all.missed_tick->measured);
  CHECK_NEAR(all.missed_tick->bound, 0.5 * 1500.0 * 0.02 * 0.02 * 1e-6, 1e-12);  // 20 mm/s for 1 ms
}

using palpate::device::Seeded;

double exponential(Seeded& random) { return -std::log(1.0 - random.uniform(0.0, 1.0)); }

std::vector<double> pareto_sample(double shape, double scale, int count, std::uint64_t seed) {
  Seeded random(seed);
  std::vector<double> sample;
  for (int n = 0; n < count; ++n) {
    const double e = exponential(random);
    sample.push_back(scale * (shape == 0.0 ? e : std::expm1(shape * e) / shape));
  }
  return sample;
}

TEST("fitted shape and scale are within their standard errors of the true ones") {
  for (const double shape : {-0.2, 0.0, 0.3, 1.0}) {
    const ParetoFit fit = fit_pareto(pareto_sample(shape, 20e-6, 5000, 1));
    // Smith 1985: (1 + xi)^2 / n and 2 sigma^2 (1 + xi) / n; four standard errors.
    CHECK_NEAR(fit.shape, shape, 4.0 * fit.shape_error());
    CHECK_NEAR(fit.scale, 20e-6, 4.0 * 20e-6 * std::sqrt(2.0 * (1.0 + shape) / 5000.0));
  }
}

TEST("the fit is a maximum of the likelihood: its two equations hold") {
  // d/d sigma and d/d xi of n log sigma + (1 + 1/xi) sum log(1 + xi y / sigma) are zero.
  const std::vector<double> sample = pareto_sample(0.3, 1.0, 400, 2);
  const ParetoFit fit = fit_pareto(sample);
  double logs = 0.0, shares = 0.0;
  for (const double y : sample) {
    logs += std::log1p(fit.shape * y / fit.scale);
    shares += y / (fit.scale + fit.shape * y);
  }
  CHECK_NEAR(logs / 400.0, fit.shape, 1e-6);  // Grimshaw 1993
  // A flat maximum: half the digits of a double.
  CHECK_NEAR((1.0 + fit.shape) * shares / 400.0, 1.0, 1e-3);
}

TEST("the excess at q is exceeded with probability q, and the end of a bounded tail never") {
  for (const double shape : {-0.3, 0.0, 0.5}) {
    const ParetoFit fit{.shape = shape, .scale = 3.0, .count = 10};
    for (const double q : {0.5, 1e-3, 1e-8}) {
      CHECK_NEAR(fit.exceeded(fit.excess_at(q)) / q, 1.0, 1e-7);
    }
  }
  const ParetoFit bounded{.shape = -0.5, .scale = 1.0};  // ends at 2
  CHECK_NEAR(bounded.exceeded(2.5), 0.0, 0.0);
}

TEST("the interval holds the estimate, grows with confidence, and is wider above than below") {
  const std::vector<double> sample = pareto_sample(0.0, 1.0, 200, 3);
  const ParetoFit fit = fit_pareto(sample);
  const double value = fit.excess_at(1e-4);
  const ExcessInterval narrow = excess_interval(fit, sample, 1e-4, 0.5);
  const ExcessInterval wide = excess_interval(fit, sample, 1e-4, 0.95);
  CHECK(wide.lower < narrow.lower);
  CHECK(narrow.lower < value);
  CHECK(value < narrow.upper);
  CHECK(narrow.upper < wide.upper);
  CHECK(wide.upper - value > value - wide.lower);
}

std::vector<LargeTick> largest_of(long ticks, const std::function<double(long)>& time) {
  LargestTicks largest(kept_responses);
  for (long n = 0; n < ticks; ++n) { largest.add({time(n), n}); }
  return largest.sorted();
}

TEST("a tail of independent times is extrapolated one and two decades and no further") {
  Seeded random(5);
  constexpr long ticks = 20000;
  const std::vector<LargeTick> largest =
      largest_of(ticks, [&](long) { return 20e-6 * exponential(random); });
  const Tail tail = judge_tail(largest, ticks, 1e-3);
  CHECK(tail.refusal.empty());
  REQUIRE(tail.levels.size() == 2);
  CHECK(tail.fits.size() == 3);
  CHECK_NEAR(tail.levels.back().probability, 1e-2 / ticks, 1e-20);
  const double truth = 20e-6 * std::log(100.0 * ticks);
  CHECK(tail.levels.back().lower < truth);
  CHECK(truth < tail.levels.back().upper);
  CHECK(!tail.beyond_deadline);  // exp(-50): far beyond two decades
  // A deadline that one tick in 20 000 exceeds has its probability.
  const Tail near = judge_tail(largest, ticks, 20e-6 * std::log(ticks));
  REQUIRE(near.beyond_deadline.has_value());
  CHECK_NEAR(std::log(*near.beyond_deadline * ticks), 0.0, 1.5);
}

TEST("times that are correlated, change, are few or equal have no tail, and a reason") {
  Seeded random(7);
  double before = 0.0;
  const auto in_pairs = [&](long) {
    const double now = exponential(random);
    return std::max(std::exchange(before, now), now);
  };
  const Tail paired = judge_tail(largest_of(8000, in_pairs), 8000, 1e-3);
  CHECK_CONTAINS(paired.refusal, "late ticks do not follow each other");
  CHECK(!std::ranges::find(paired.checks, "alone-in-time", &Quantity::name)->holds());
  CHECK(paired.levels.empty());
  random = Seeded(9);
  const auto growing = [&](long n) {
    return exponential(random) * (1.0 + static_cast<double>(n) / 8000.0);
  };
  CHECK_CONTAINS(judge_tail(largest_of(8000, growing), 8000, 1e-3).refusal, "both halves");
  const auto rising = [](long n) { return 1e-6 * static_cast<double>(n); };
  CHECK_CONTAINS(judge_tail(largest_of(1000, rising), 1000, 1e-3).refusal, "too few");
  const auto equal = [](long) { return 1e-4; };
  CHECK_CONTAINS(judge_tail(largest_of(5000, equal), 5000, 1e-3).refusal, "all alike");
}

TEST("the extremal index of maxima over m neighbours is 1/m") {
  for (const int m : {1, 2, 4}) {
    Seeded random(8);
    std::vector<double> recent(static_cast<std::size_t>(m), 0.0);
    const auto largest = largest_of(50000, [&](long n) {
      recent[static_cast<std::size_t>(n % m)] = exponential(random);
      return *std::ranges::max_element(recent);
    });
    // About 2500/m clusters: 1/sqrt(n) of the index, four times
    CHECK_NEAR(extremal_index(exceedances(largest, 2500, 50000)), 1.0 / m,
               4.0 / m / std::sqrt(2500.0 / m));
  }
}

}  // namespace PALPATE_FILE

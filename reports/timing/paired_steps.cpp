// SPDX-License-Identifier: MIT
#include "reports/timing/paired_steps.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "model/dynamics/scene_check.hpp"
#include "reports/timing/loaded_library.hpp"
#include "validation/bench/interleaved.hpp"
#include "validation/number_words.hpp"
#include "validation/random.hpp"

namespace palpate::timing {

namespace {

constexpr double least_batch = 0.5e-3;  // [s]

struct BatchTime {
  double processor = 0.0;
  double wall = 0.0;
};

BatchTime time_of(LibrarySteps& steps, long ticks) {
  const double wall = bench::seconds_on(bench::Clock::wall);
  const double processor = bench::seconds_on(bench::Clock::processor);
  steps.run(ticks);
  return {.processor = bench::seconds_on(bench::Clock::processor) - processor,
          .wall = bench::seconds_on(bench::Clock::wall) - wall};
}

/// Both builds of one scene, at the same tick.
class PairOfSteps {
 public:
  explicit PairOfSteps(const PairedPlan& plan) : plan_(plan), head_next_(plan.head_first) {
    (plan.head_first ? head_ : base_).emplace(plan.head_first ? plan.head : plan.base);
    (plan.head_first ? base_ : head_).emplace(plan.head_first ? plan.base : plan.head);
    begin_anew();
    choose_batch();
  }

  Pair time(bool head_first) {
    if (done_ + batch_ > tick_count_) { begin_anew(); }
    done_ += batch_;
    BatchTime head;
    if (head_first) { head = time_of(*head_steps_, head_ticks()); }
    const BatchTime base = time_of(*base_steps_, batch_);
    if (!head_first) { head = time_of(*head_steps_, head_ticks()); }
    return {.base = base.processor, .head = head.processor, .base_wall = base.wall, .head_wall = head.wall};
  }
  [[nodiscard]] double batch_deadline() const { return static_cast<double>(batch_) * base_steps_->tick_length(); }
  [[nodiscard]] bool same_motion() { return base_steps_->digest() == head_steps_->digest(); }

 private:
  [[nodiscard]] long head_ticks() const { return plan_.planted ? batch_ + batch_ / planted_every : batch_; }

  /// Either build goes and comes first in turn: each then has the place in memory, and what that costs, that the other
  /// had the time before.
  void begin_anew() {
    if (head_next_) { head_steps_.reset(); }
    base_steps_.reset();
    if (!head_next_) { head_steps_.reset(); }
    if (head_next_) { head_steps_.emplace(head_->create(plan_.scene)); }
    base_steps_.emplace(base_->create(plan_.scene));
    if (!head_next_) { head_steps_.emplace(head_->create(plan_.scene)); }
    head_next_ = !head_next_;
    tick_count_ = base_steps_->tick_count();
    done_ = 0;
  }

  void choose_batch() {
    if (tick_count_ < planted_every) {
      throw InputError(plan_.scene.string() + ": " + std::to_string(tick_count_) + " ticks; at least " +
                       std::to_string(planted_every));
    }
    const double seconds = std::max(time_of(*base_steps_, planted_every).processor, 1e-7);
    const long most = tick_count_ / planted_every;
    batch_ = planted_every * std::clamp(std::lround(std::ceil(least_batch / seconds)), 1L, most);
    begin_anew();
  }

  const PairedPlan& plan_;
  std::optional<LoadedLibrary> base_, head_;
  std::optional<LibrarySteps> base_steps_, head_steps_;  // after what they are made by
  bool head_next_;
  long tick_count_ = 0;
  long batch_ = planted_every;
  long done_ = 0;
};

double next_number(std::istream& words) {
  double number = std::nan("");
  if (!(words >> number) || !(number > 0.0)) {
    throw InputError("times of a paired run: cut short; as `palpate steps --beside` prints them");
  }
  return number;
}

}  // namespace

PairedReport time_pairs(const PairedPlan& plan) {
  PairOfSteps steps(plan);
  Random random(plan.seed);
  PairedReport report;
  for (int n = 0; n < plan.pairs; ++n) { report.start.pairs.push_back(steps.time(random(0.0, 1.0) < 0.5)); }
  report.start.batch_deadline = steps.batch_deadline();
  report.same_motion = steps.same_motion();
  return report;
}

std::string to_text(const PairedReport& report) {
  std::string text = report.same_motion ? "same\n" : "different\n";
  text += exact_number(report.start.batch_deadline) + " " + std::to_string(report.start.pairs.size()) + "\n";
  for (const Pair& pair : report.start.pairs) {
    text += exact_number(pair.base) + " " + exact_number(pair.head) + " " + exact_number(pair.base_wall) + " " +
            exact_number(pair.head_wall) + "\n";
  }
  return text;
}

PairedReport paired_report_from(const std::string& text) {
  std::istringstream words(text);
  PairedReport report;
  std::string motion;
  words >> motion;
  report.same_motion = motion == "same";
  report.start.batch_deadline = next_number(words);
  const auto count = static_cast<std::size_t>(next_number(words));
  for (std::size_t n = 0; n < count; ++n) {
    Pair& pair = report.start.pairs.emplace_back();
    for (double* time : {&pair.base, &pair.head, &pair.base_wall, &pair.head_wall}) { *time = next_number(words); }
  }
  return report;
}

}  // namespace palpate::timing

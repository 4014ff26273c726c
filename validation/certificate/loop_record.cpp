// SPDX-License-Identifier: MIT
#include "validation/certificate/loop_record.hpp"

#include <algorithm>

namespace palpate::certificate {

namespace {

constexpr auto larger = [](const LargeTick& a, const LargeTick& b) { return a.seconds > b.seconds; };

void keep(Peak& peak, double seconds, long tick, const Moment& moment) noexcept {
  if (!(seconds <= peak.seconds)) { peak = {seconds, tick, moment}; }
}

}  // namespace

void Misses::add(bool missed, const TickTimes& times) noexcept {
  if (missed && run_ == 0) { run_began_ = times.due; }
  if (missed || run_ > 0) { longest_recovery_ = std::max(longest_recovery_, times.end - run_began_); }
  run_ = missed ? run_ + 1 : 0;
  count_ += missed ? 1 : 0;
  longest_run_ = std::max(longest_run_, run_);
}

LargestTicks::LargestTicks(std::size_t capacity) : capacity_(capacity) {
  heap_.resize(capacity);  // touched, so that no page is missing later
  heap_.clear();
}

void LargestTicks::add(const LargeTick& tick) noexcept {
  if (heap_.size() < capacity_) {
    heap_.push_back(tick);
    std::ranges::push_heap(heap_, larger);
    return;
  }
  if (!(tick.seconds > heap_.front().seconds)) { return; }
  std::ranges::pop_heap(heap_, larger);
  heap_.back() = tick;
  std::ranges::push_heap(heap_, larger);
}

std::vector<LargeTick> LargestTicks::sorted() const {
  std::vector<LargeTick> ticks = heap_;
  std::ranges::sort(ticks, larger);
  return ticks;
}

void LoopRecord::add(const TickTimes& times, const Moment& moment) noexcept {
  const long tick = ticks();
  const double late = times.begin - times.due;
  const double work = times.end - times.begin;
  const double answer = times.end - times.due;
  wakeup.add(late);
  compute.add(work);
  response.add(answer);
  keep(worst_wakeup, late, tick, moment);
  keep(worst_compute, work, tick, moment);
  keep(worst_response, answer, tick, moment);
  misses.add(!(answer <= deadline_), times);
  largest.add({answer, tick});
}

}  // namespace palpate::certificate

// SPDX-License-Identifier: MIT

#include "validation/certificate/paced_loop.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::certificate {

void LatencyHistogram::add(double seconds) noexcept {
  constexpr auto last = static_cast<double>(bin_count - 1);
  const double place = seconds / bin_width;
  const double bin = place < last ? std::max(place, 0.0) : last;  // NaN goes to the last bin
  ++counts_[static_cast<std::size_t>(bin)];
  minimum_ = count_ == 0 ? seconds : std::min(minimum_, seconds);
  maximum_ = count_ == 0 ? seconds : std::max(maximum_, seconds);
  ++count_;
}

std::size_t LatencyHistogram::used_bins() const {
  const auto last =
      std::find_if(counts_.rbegin(), counts_.rend(), [](std::uint32_t n) { return n > 0; });
  return static_cast<std::size_t>(counts_.rend() - last);
}

std::optional<double> LatencyHistogram::percentile(double share) const {
  constexpr double rounding = 1e-9;  // tolerance on share n
  const double rank = std::ceil(share * static_cast<double>(count_) - rounding);
  if (count_ == 0 || !(rank < static_cast<double>(count_))) { return {}; }
  double below = 0.0;
  for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
    below += counts_[bin];
    if (below >= rank) { return std::min(static_cast<double>(bin + 1) * bin_width, maximum_); }
  }
  return maximum_;
}

namespace {

constexpr auto larger = [](const LargeTick& a, const LargeTick& b) {
  return a.seconds > b.seconds;
};

void keep(Peak& peak, double seconds, long tick, const Moment& moment) noexcept {
  if (!(seconds <= peak.seconds)) { peak = {seconds, tick, moment}; }
}

}  // namespace

void Misses::add(bool missed, const TickTimes& times) noexcept {
  if (missed && run_ == 0) { run_began_ = times.due; }
  if (missed || run_ > 0) {
    longest_recovery_ = std::max(longest_recovery_, times.end - run_began_);
  }
  run_ = missed ? run_ + 1 : 0;
  count_ += missed ? 1 : 0;
  longest_run_ = std::max(longest_run_, run_);
}

LargestTicks::LargestTicks(std::size_t capacity) : capacity_(capacity) {
  heap_.resize(capacity);  // touches the memory to avoid page faults
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

// SPDX-License-Identifier: MIT
#include "reports/cli/case_runner.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>

namespace palpate::cli {

namespace {

/// Shared with the threads, and owned by them too: after an interrupt they outlive the caller.
struct Work {
  std::vector<Case> cases;
  CaseContext context;
  std::vector<std::size_t> order;  ///< longest first
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::optional<Outcome>> outcomes;
  std::vector<std::size_t> fresh;  ///< finished and not yet told
};

void work_on(const std::shared_ptr<Work>& work, const std::atomic<bool>& stop) {
  while (!stop.load()) {
    const std::size_t turn = work->next.fetch_add(1);
    if (turn >= work->order.size()) { return; }
    const std::size_t index = work->order[turn];
    Outcome outcome = run_case(work->cases[index], work->context);
    const std::scoped_lock lock(work->mutex);
    work->outcomes[index] = std::move(outcome);
    work->fresh.push_back(index);
    work->changed.notify_one();
  }
}

}  // namespace

RunnerResult run_cases(std::vector<Case> cases, const CaseContext& context, int jobs,
                       const std::atomic<bool>& stop,
                       const std::function<void(const Outcome&, std::size_t, std::size_t)>& finished) {
  const auto work = std::make_shared<Work>();
  work->cases = std::move(cases);
  work->context = context;
  const std::size_t total = work->cases.size();
  work->outcomes.resize(total);
  work->order.resize(total);
  std::iota(work->order.begin(), work->order.end(), std::size_t{0});
  std::ranges::stable_sort(work->order, std::greater<>(),
                           [&](std::size_t n) { return work->cases[n].weight; });
  std::vector<std::thread> threads;
  for (int n = 0; n < jobs; ++n) { threads.emplace_back([work, &stop] { work_on(work, stop); }); }

  std::size_t told = 0;
  while (told < total && !stop.load()) {
    std::vector<std::size_t> fresh;
    {
      std::unique_lock lock(work->mutex);
      work->changed.wait_for(lock, std::chrono::milliseconds(100),
                             [&] { return !work->fresh.empty(); });
      fresh.swap(work->fresh);
    }
    for (const std::size_t index : fresh) { finished(*work->outcomes[index], ++told, total); }
  }
  RunnerResult result;
  result.interrupted = told < total;
  for (std::thread& thread : threads) { result.interrupted ? thread.detach() : thread.join(); }
  const std::scoped_lock lock(work->mutex);
  for (const auto& outcome : work->outcomes) {
    if (outcome) { result.outcomes.push_back(*outcome); }
  }
  return result;
}

}  // namespace palpate::cli

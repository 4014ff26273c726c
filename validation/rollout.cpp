// SPDX-License-Identifier: MIT
#include "validation/rollout.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

namespace palpate {

namespace {

using Clock = std::chrono::steady_clock;

class TraceKeeper {
 public:
  TraceKeeper(Simulation& simulation, const RollOutOptions& options, Run& run)
      : simulation_(simulation), falcon_(options.falcon), run_(run), moments_(simulation, options.events) {
    run.trace.columns = simulation.columns();
    tissue_columns_ = run.trace.columns.size();
    if (falcon_ != nullptr) {
      std::ranges::move(FalconLoop::columns(), std::back_inserter(run.trace.columns));
    }
    row_.resize(run.trace.columns.size());
    const auto rows = static_cast<std::size_t>(simulation.tick_count() + 1);
    run.trace.time.reserve(rows);
    for (Column& column : run.trace.columns) { column.values.reserve(rows); }
    run.trace.text_columns = simulation.text_columns();
    words_.resize(run.trace.text_columns.size());
    const NodeVectors begin = simulation.node_positions();
    const long wanted = std::min<long>(options.frames, simulation.tick_count() + 1);
    const long frames = begin.cols() == 0 ? 0 : wanted;
    frame_interval_ = frames <= 1 ? 0.0
                                  : static_cast<double>(simulation.tick_count()) / static_cast<double>(frames - 1);
    run.trace.frame_time.resize(static_cast<std::size_t>(frames));
    run.trace.frames.assign(run.trace.frame_time.size(), begin);
  }
  void take() {
    run_.trace.time.push_back(simulation_.time());
    const std::span<double> row(row_);
    simulation_.sample(row.first(tissue_columns_));
    if (falcon_ != nullptr) { falcon_->sample(row.subspan(tissue_columns_)); }
    for (std::size_t n = 0; n < row_.size(); ++n) {
      run_.trace.columns[n].values.push_back(row_[n]);
    }
    simulation_.sample_text(words_, run_.trace.events);
    for (std::size_t n = 0; n < words_.size(); ++n) {
      run_.trace.text_columns[n].values.push_back(words_[n]);
    }
    const double energy = simulation_.energy();
    if (simulation_.ticks() == 0) { run_.energy.initial = run_.energy.maximum = energy; }
    run_.energy.final = energy;
    run_.energy.maximum = std::max(run_.energy.maximum, energy);
    take_frame();
    moments_.take(simulation_, run_.trace);
  }
  /// Room for frames that never came goes.
  void finish() {
    run_.trace.frame_time.resize(kept_);
    run_.trace.frames.resize(kept_);
    run_.moments = moments_.moments();
  }

 private:
  void take_frame() noexcept {
    const bool due = static_cast<double>(simulation_.ticks()) >= static_cast<double>(kept_) * frame_interval_ - 1e-9;
    if (kept_ == run_.trace.frames.size() || !due) { return; }
    run_.trace.frame_time[kept_] = simulation_.time();
    simulation_.node_positions(run_.trace.frames[kept_]);
    ++kept_;
  }

  Simulation& simulation_;
  FalconLoop* falcon_;
  Run& run_;
  std::size_t tissue_columns_ = 0;
  std::vector<double> row_;
  std::vector<std::string> words_;
  std::size_t kept_ = 0;  ///< frames
  double frame_interval_ = 0.0;
  MomentKeeper moments_;
};

}  // namespace

Run roll_out(Simulation& simulation, const RollOutOptions& options) {
  Run run;
  TraceKeeper keeper(simulation, options, run);
  if (options.falcon != nullptr) { options.falcon->follow(options.clock); }
  keeper.take();
  const long count = simulation.tick_count();
  auto last_progress = Clock::now();
  while (run.ticks < count && !run.diverged) {
    if (options.stop != nullptr && options.stop->load(std::memory_order_relaxed)) {
      run.interrupted = true;
      break;
    }
    if (options.clock != nullptr && options.falcon == nullptr) { options.clock->wait(); }
    const double slept = options.clock != nullptr ? options.clock->facts().slept : 0.0;
    const auto begin = Clock::now();
    const StepStatus status =
        options.falcon != nullptr ? options.falcon->tick() : simulation.tick();
    const auto end = Clock::now();
    const double waited = options.clock != nullptr ? options.clock->facts().slept - slept : 0.0;
    const double seconds = std::chrono::duration<double>(end - begin).count() - waited;
    run.seconds += seconds;
    run.slowest_tick = std::max(run.slowest_tick, seconds);
    run.steps += simulation.plan().substeps;
    ++run.ticks;
    if (status == StepStatus::diverged) {
      run.diverged = true;
      run.diverged_at = simulation.time();
    } else {
      keeper.take();
      if (options.enough && options.enough(run.trace)) { break; }
    }
    if (options.progress && end - last_progress > std::chrono::milliseconds(250)) {
      options.progress(static_cast<double>(run.ticks) / static_cast<double>(count));
      last_progress = end;
    }
  }
  keeper.finish();
  run.zero_length_springs = simulation.zero_length_springs();
  if (options.falcon != nullptr) { run.falcon = options.falcon->facts(); }
  if (options.clock != nullptr) { run.real_time = options.clock->facts(); }
  return run;
}

}  // namespace palpate

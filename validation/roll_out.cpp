// SPDX-License-Identifier: MIT

#include "validation/roll_out.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "model/stepping/simulation.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/case.hpp"
#include "validation/renumbering.hpp"

namespace palpate {

MomentKeeper::MomentKeeper(const Simulation& simulation, int most) {
  const auto& columns = simulation.columns();
  const auto force = std::ranges::find(columns, "tool.force_n", &Column::name);
  if (force == columns.end() || most <= 0) { return; }
  force_column_ = static_cast<std::size_t>(force - columns.begin());
  at_largest_ = simulation.node_positions();
  at_events_.time.resize(static_cast<std::size_t>(most));
  at_events_.positions.assign(at_events_.time.size(), at_largest_);
}

void MomentKeeper::take(Simulation& simulation, const Trace& trace) noexcept {
  if (at_events_.time.empty()) { return; }
  const double force = trace.columns[force_column_].values.back();
  if (std::isfinite(force) && force > largest_) {
    largest_ = force;
    largest_time_ = simulation.time();
    simulation.node_positions(at_largest_);
  }
  if (trace.events.size() > events_seen_ && kept_ < at_events_.time.size()) {
    at_events_.time[kept_] = simulation.time();
    simulation.node_positions(at_events_.positions[kept_]);
    ++kept_;
  }
  events_seen_ = trace.events.size();
}

Moments MomentKeeper::moments() {
  at_events_.time.resize(kept_);
  at_events_.positions.resize(kept_);
  if (largest_ > 0.0) {
    const auto after = std::ranges::lower_bound(at_events_.time, largest_time_);
    const auto place = after - at_events_.time.begin();
    if (after == at_events_.time.end() || *after != largest_time_) {
      at_events_.time.insert(after, largest_time_);
      at_events_.positions.insert(at_events_.positions.begin() + place, std::move(at_largest_));
    }
  }
  return std::move(at_events_);
}

namespace {

/// Columns are appended to buffers that are sized once.
class Sampler {
 public:
  Sampler(Simulation& simulation, const Wanted& wanted, Motion& motion)
      : simulation_(simulation), wanted_(wanted), motion_(motion) {
    const Eigen::Index samples = simulation.tick_count() / wanted.every + 2;
    motion.position.resize(simulation.problem().dof(), samples);
    if (wanted.velocity) { motion.velocity.resize(simulation.problem().dof(), samples); }
  }
  void take() {
    const auto column = static_cast<Eigen::Index>(motion_.time.size());
    motion_.time.push_back(simulation_.time());
    simulation_.coordinates(motion_.position.col(column));
    if (wanted_.velocity) { simulation_.velocities(motion_.velocity.col(column)); }
    if (wanted_.energy) { motion_.energy.push_back(simulation_.energy()); }
  }
  void finish() {
    const auto samples = static_cast<Eigen::Index>(motion_.time.size());
    motion_.position.conservativeResize(Eigen::NoChange, samples);
    if (wanted_.velocity) { motion_.velocity.conservativeResize(Eigen::NoChange, samples); }
  }

 private:
  Simulation& simulation_;
  const Wanted& wanted_;
  Motion& motion_;
};

}  // namespace

Motion simulate(const CaseContext& context, Scene scene, const SpringNetwork* network,
                const Wanted& wanted) {
  SpringNetwork own = network != nullptr                          ? *network
                      : scene.tissue.source == Source::oscillator ? SpringNetwork{}
                                                                  : build_network(scene);
  const Mutation* mutation = context.mutation;
  if (mutation != nullptr && mutation->model) { mutation->model(scene, own); }
  if (mutation != nullptr && mutation->step_twice) {
    scene.simulation.step *= 2.0;
    scene.simulation.duration *= 2.0;
  }
  const OtherOrder order(context.order, own, scene);
  std::optional<Simulation> simulation;
  if (scene.tissue.source == Source::oscillator && network == nullptr) {
    simulation.emplace(scene, context.skip);
  } else {
    simulation.emplace(scene, own, context.skip);
  }
  Motion motion;
  motion.substeps = simulation->plan().substeps;
  motion.h = simulation->plan().h;
  Sampler sampler(*simulation, wanted, motion);
  sampler.take();
  const long ticks = simulation->tick_count();
  for (long n = 1; n <= ticks; ++n) {
    const auto begin = std::chrono::steady_clock::now();
    const StepStatus status = simulation->tick();
    motion.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    motion.steps += simulation->plan().substeps;
    if (status == StepStatus::diverged) {
      motion.diverged = true;
      motion.diverged_at = simulation->time();
      break;
    }
    if (n % wanted.every == 0 || n == ticks) { sampler.take(); }
  }
  sampler.finish();
  order.undo(own, motion.position);
  order.undo(own, motion.velocity);
  if (mutation != nullptr && mutation->step_twice) {
    for (double& t : motion.time) { t *= 0.5; }
  }
  if (mutation != nullptr && mutation->motion) { mutation->motion(motion); }
  return motion;
}

Scene scene_of(const std::string& integrator, double step, double duration, int substeps) {
  Scene scene;
  scene.simulation.integrator = integrator;
  scene.simulation.step = step;
  scene.simulation.duration = duration;
  scene.simulation.substeps = substeps;
  scene.tissue.source = Source::network;
  return scene;
}

namespace {

class ToolSampler {
 public:
  ToolSampler(Simulation& simulation, const InsertionWanted& wanted, Insertion& insertion)
      : simulation_(simulation), wanted_(wanted), insertion_(insertion) {
    const auto& columns = simulation.columns();
    row_.resize(columns.size());
    const auto found = std::ranges::find(columns, "syringe.pressure_pa", &Column::name);
    pressure_ = found - columns.begin();
    if (!wanted.motion) { return; }
    const Eigen::Index samples = simulation.tick_count() / wanted.every + 2;
    insertion.position.resize(simulation.problem().dof(), samples);
    insertion.velocity.resize(simulation.problem().dof(), samples);
  }
  void take() {
    const auto column = static_cast<Eigen::Index>(insertion_.time.size());
    insertion_.time.push_back(simulation_.time());
    insertion_.energy.push_back(simulation_.energy());
    insertion_.tool.push_back(simulation_.tool());
    simulation_.sample_text(words_, insertion_.events);
    insertion_.layer.push_back(words_[0]);
    if (pressure_ < static_cast<std::ptrdiff_t>(row_.size())) {
      simulation_.sample(row_);
      insertion_.pressure.push_back(row_[static_cast<std::size_t>(pressure_)]);
    }
    if (!wanted_.motion) { return; }
    simulation_.coordinates(insertion_.position.col(column));
    simulation_.velocities(insertion_.velocity.col(column));
  }
  void finish() {
    if (!wanted_.motion) { return; }
    const auto samples = static_cast<Eigen::Index>(insertion_.time.size());
    insertion_.position.conservativeResize(Eigen::NoChange, samples);
    insertion_.velocity.conservativeResize(Eigen::NoChange, samples);
  }

 private:
  Simulation& simulation_;
  const InsertionWanted& wanted_;
  Insertion& insertion_;
  std::vector<double> row_;
  std::vector<std::string> words_{"", ""};
  std::ptrdiff_t pressure_ = 0;
};

}  // namespace

double Insertion::time_of(std::string_view kind, std::string_view detail) const {
  const auto found = std::ranges::find_if(events, [&](const Event& e) {
    return e.kind == kind && (detail.empty() || e.detail == detail);
  });
  return found == events.end() ? std::numeric_limits<double>::quiet_NaN() : found->time;
}

long Insertion::count(std::string_view kind) const {
  return std::ranges::count(events, kind, &Event::kind);
}

Insertion insert_tool(const CaseContext& context, Scene scene, const InsertionWanted& wanted) {
  SpringNetwork network = build_network(scene);
  const Mutation* mutation = context.mutation;
  if (mutation != nullptr && mutation->model) { mutation->model(scene, network); }
  if (mutation != nullptr && mutation->step_twice) {
    scene.simulation.step *= 2.0;
    scene.simulation.duration *= 2.0;
  }
  Simulation simulation(scene, network, context.skip);
  Insertion insertion;
  insertion.integrator = std::string(simulation.plan().integrator->name);
  insertion.substeps = simulation.plan().substeps;
  insertion.h = simulation.plan().h;
  ToolSampler sampler(simulation, wanted, insertion);
  sampler.take();
  const long ticks = simulation.tick_count();
  for (long n = 1; n <= ticks; ++n) {
    const auto begin = std::chrono::steady_clock::now();
    const StepStatus status = simulation.tick();
    insertion.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (status == StepStatus::diverged) {
      insertion.diverged = true;
      break;
    }
    if (n % wanted.every == 0 || n == ticks) { sampler.take(); }
  }
  sampler.finish();
  if (mutation != nullptr && mutation->step_twice) {
    for (double& t : insertion.time) { t *= 0.5; }
    for (Event& e : insertion.events) { e.time *= 0.5; }
  }
  if (mutation != nullptr && mutation->insertion) { mutation->insertion(insertion); }
  return insertion;
}

namespace {

using Clock = std::chrono::steady_clock;

class TraceKeeper {
 public:
  TraceKeeper(Simulation& simulation, const RollOutOptions& options, Run& run)
      : simulation_(simulation),
        falcon_(options.falcon),
        run_(run),
        moments_(simulation, options.events) {
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
                                  : static_cast<double>(simulation.tick_count()) /
                                        static_cast<double>(frames - 1);
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
    const bool due = static_cast<double>(simulation_.ticks()) >=
                     static_cast<double>(kept_) * frame_interval_ - 1e-9;
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

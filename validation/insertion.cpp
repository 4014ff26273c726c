// SPDX-License-Identifier: MIT
#include "validation/insertion.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include "model/dynamics/network_builder.hpp"
#include "validation/case.hpp"

namespace palpate {

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

}  // namespace palpate

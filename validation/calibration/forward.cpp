// SPDX-License-Identifier: MIT

#include "validation/calibration/forward.hpp"

#include <algorithm>
#include <exception>
#include <thread>

#include "validation/number_text.hpp"
#include "validation/roll_out.hpp"

namespace palpate::calibration {
namespace {

bool has_middle(int nodes) { return nodes > 3 && nodes % 2 == 1; }

std::string places_text(const std::vector<Parameter>& parameters, const Forward::Values& place) {
  std::string text;
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    if (place[n] == parameters[n].prior) { continue; }
    text += (text.empty() ? " at " : ", ") + parameters[n].key + " = " + plain_number(place[n], 6) +
            " " + parameters[n].unit;
  }
  return text;
}

}  // namespace

Scene coarser(Scene scene, const Coarsening& how) {
  LayerBlock& block = scene.tissue.block;
  if (how.block && block.nodes[0] == block.nodes[1] && has_middle(block.nodes[0])) {
    block.spacing *= 0.5 * (block.nodes[0] - 1);
    block.nodes = {3, 3};
  }
  scene.simulation.step *= how.step_factor;
  scene.output.frames = 0;
  scene.records.clear();
  if (scene.drive && scene.drive->depth) {
    const Drive& drive = *scene.drive;
    scene.simulation.duration = drive.start + (*drive.depth - drive.from) / drive.speed + how.after;
  }
  return scene;
}

ObservedInsertion simulate_insertion(const Scene& scene, const std::atomic<bool>* stop) {
  ModelSubject subject{Simulation(scene)};
  const Trace run = roll_out(subject, scene, {}, {.stop = stop});
  if (run.interrupted) { throw Interrupted(); }
  if (run.diverged) {
    return {.refusal = "diverges at t = " + std::to_string(run.diverged_at) + " s"};
  }
  return observe(run);
}

Forward::Forward(Scene scene, std::vector<Parameter> parameters, int jobs,
                 const std::atomic<bool>* stop, Simulate simulate)
    : scene_(std::move(scene)),
      parameters_(std::move(parameters)),
      jobs_(std::max(1, jobs)),
      stop_(stop),
      simulate_(std::move(simulate)) {
  if (!simulate_) {
    simulate_ = [stop](const Scene& changed) { return simulate_insertion(changed, stop); };
  }
}

Forward::Values Forward::priors() const {
  Values values;
  for (const Parameter& parameter : parameters_) { values.push_back(parameter.prior); }
  return values;
}

Observation Forward::simulate(const Values& place) const {
  if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) { throw Interrupted(); }
  const ObservedInsertion seen = simulate_(with_values(scene_, parameters_, place));
  if (!seen.refusal.empty()) {
    throw std::runtime_error("calibration: the simulated insertion" +
                             places_text(parameters_, place) + " " + seen.refusal);
  }
  return seen.value;
}

void Forward::simulate_new(const std::vector<Values>& places) {
  std::vector<Observation> found(places.size());
  std::vector<std::exception_ptr> thrown(places.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t n = next++; n < places.size(); n = next++) {
      try {
        found[n] = simulate(places[n]);
      } catch (...) { thrown[n] = std::current_exception(); }
    }
  };
  {
    std::vector<std::jthread> helpers;
    const auto most = std::min<std::size_t>(static_cast<std::size_t>(jobs_), places.size());
    for (std::size_t n = 1; n < most; ++n) { helpers.emplace_back(work); }
    work();
  }
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (thrown[n]) { std::rethrow_exception(thrown[n]); }
    seen_.emplace(places[n], std::move(found[n]));
  }
}

std::vector<Observation> Forward::at(const std::vector<Values>& places) {
  std::vector<Values> unseen;
  for (const Values& place : places) {
    const bool known = seen_.contains(place) || std::ranges::find(unseen, place) != unseen.end();
    if (!known) { unseen.push_back(place); }
  }
  simulate_new(unseen);
  std::vector<Observation> found;
  for (const Values& place : places) { found.push_back(seen_.at(place)); }
  return found;
}

}  // namespace palpate::calibration

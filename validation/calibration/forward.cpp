// SPDX-License-Identifier: MIT

#include "validation/calibration/forward.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <thread>

#include "validation/number_text.hpp"
#include "validation/roll_out.hpp"

namespace palpate::calibration {
namespace {

/// Number of the scene with its key and prior.
struct Slot {
  std::string key{};
  std::string unit{};
  double* value = nullptr;
  double spread = 0.0;
  std::string origin{};
};

double within_a_factor(double factor) { return std::log(factor) / normal_factor; }

Material* find_material(Scene& scene, std::string_view name) {
  const auto found = std::ranges::find(scene.materials, name, &Material::name);
  return found == scene.materials.end() ? nullptr : &*found;
}

/// Returns the layers before the epidural space; all if there is none.
std::size_t passed_layers(const Scene& scene) {
  std::size_t count = 0;
  for (const Layer& layer : scene.tissue.layers) {
    const auto found = std::ranges::find(scene.materials, layer.material, &Material::name);
    if (found != scene.materials.end() && role_of(*found) != TissueRole::tissue) { break; }
    ++count;
  }
  return count;
}

/// BMI affects only the fat (Bahk et al. 1998); without a layer of this name, the layer under the
/// skin.
std::size_t layer_of_body_mass(const Scene& scene, std::size_t count) {
  for (std::size_t n = 0; n < count; ++n) {
    const Layer& layer = scene.tissue.layers[n];
    if (layer.tissue.find("fat") != std::string::npos ||
        layer.material.find("fat") != std::string::npos) {
      return n;
    }
  }
  return std::min<std::size_t>(1, count - 1);
}

void add_materials(Scene& scene, std::size_t count, std::vector<Slot>& slots) {
  std::vector<std::string> seen;
  for (std::size_t n = 0; n < count; ++n) {
    const std::string& name = scene.tissue.layers[n].material;
    Material* material = find_material(scene, name);
    if (material == nullptr || std::ranges::find(seen, name) != seen.end()) { continue; }
    seen.push_back(name);
    const std::string key = "material." + name + ".";
    if (material->puncture_force) {
      slots.push_back({key + "puncture_force", "N", &*material->puncture_force,
                       within_a_factor(2.0), "assumed: within a factor of 2"});
    }
    slots.push_back(
        {key + "cutting_force", "N", &material->cutting_force, within_a_factor(2.0),
         "assumed: within a factor of 2; the share of cutting is ex vivo (Barnett et al. 2015)"});
    slots.push_back({key + "friction", "N/m", &material->friction, within_a_factor(std::sqrt(3.0)),
                     "dry and lubricated needles differ by up to 3: sqrt 3 to either side "
                     "(Schneider et al. 1978)"});
    slots.push_back({key + "youngs_modulus", "Pa", &material->youngs_modulus, within_a_factor(3.0),
                     "assumed: within a factor of 3; reviews span more (Kalra et al. 2016)"});
    slots.push_back({key + "indentation_toe", "m", &material->indentation_toe, within_a_factor(3.0),
                     "assumed: within a factor of 3"});
    slots.push_back({key + "friction_travel", "m", &material->friction_travel, within_a_factor(3.0),
                     "assumed: within a factor of 3"});
    slots.push_back({key + "friction_exponent", "1", &material->friction_exponent,
                     within_a_factor(2.0), "assumed: within a factor of 2"});
  }
}

std::vector<Slot> slots_of(Scene& scene) {
  std::vector<Slot> slots;
  const std::size_t count = passed_layers(scene);
  add_materials(scene, count, slots);
  if (count > 0 && scene.syringe) {
    const std::size_t n = layer_of_body_mass(scene, count);
    slots.push_back(
        {"layer." + std::to_string(n) + ".thickness", "m", &scene.tissue.layers[n].thickness, 0.7,
         "assumed: a factor of 4, as the fat differs from lean to obese (Ravi et al. 2011)"});
  }
  if (scene.syringe) {
    Syringe& syringe = *scene.syringe;
    slots.insert(slots.end(),
                 {{"syringe.thumb_force", "N", &syringe.thumb_force, within_a_factor(2.0),
                   "assumed: within a factor of 2; group means span 376 to 500 mmHg"},
                  {"syringe.compliance", "m^3/Pa", &syringe.compliance, within_a_factor(3.0),
                   "assumed: within a factor of 3; falls take 50 to 200 ms"},
                  {"syringe.tissue_resistance", "Pa s/m^3", &syringe.tissue_resistance,
                   within_a_factor(3.0), "assumed: within a factor of 3"},
                  {"syringe.epidural_resistance", "Pa s/m^3", &syringe.epidural_resistance, 0.44,
                   "epidural pressure 15 (SD 7) mmHg (Kim et al. 1996), as a log-normal"}});
  }
  return slots;
}

}  // namespace

double Parameter::standardised(double value) const { return std::log(value / prior) / spread; }
double Parameter::value(double standardised) const {
  return prior * std::exp(spread * standardised);
}

void set_default_bounds(Parameter& parameter) {
  parameter.lower = parameter.value(-4.0);
  parameter.upper = parameter.value(4.0);
}

std::vector<Parameter> parameters_of(const Scene& scene) {
  Scene copy = scene;
  std::vector<Parameter> parameters;
  for (const Slot& slot : slots_of(copy)) {
    if (!(*slot.value > 0.0)) { continue; }
    Parameter& added = parameters.emplace_back(Parameter{.key = slot.key,
                                                         .unit = slot.unit,
                                                         .prior = *slot.value,
                                                         .spread = slot.spread,
                                                         .origin = slot.origin});
    set_default_bounds(added);
  }
  return parameters;
}

std::string why_not_calibrated(const Scene& scene) {
  if (scene.tissue.source != Source::layers) {
    return "tissue.source: layers are what is calibrated; \"layers\"";
  }
  if (!scene.needle) { return "needle: is missing; a needle is what a recording is of"; }
  if (!scene.syringe) { return "syringe: is missing; a recorded pressure needs a simulated one"; }
  const Drive drive = scene.drive.value_or(Drive{});
  if (drive.kind != Drive::Kind::trajectory || drive.technique != Drive::Technique::continuous) {
    return "drive: a calibration needs kind = \"trajectory\" and technique = \"continuous\"";
  }
  const std::size_t count = passed_layers(scene);
  const bool epidural = count > 0 && count < scene.tissue.layers.size();
  if (!epidural) {
    return "layer: no epidural space under other tissue; a loss of resistance is what is compared";
  }
  double depth = 0.0;
  for (std::size_t n = 0; n < count; ++n) { depth += scene.tissue.layers[n].thickness; }
  if (!drive.depth || !(*drive.depth > depth)) {
    return "drive.depth: the needle must go past the start of the epidural space, and stop";
  }
  return {};
}

Scene with_values(Scene scene, const std::vector<Parameter>& parameters,
                  const std::vector<double>& values) {
  const std::vector<Slot> slots = slots_of(scene);
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    const auto slot = std::ranges::find(slots, parameters[n].key, &Slot::key);
    if (slot == slots.end()) { continue; }
    const double before = *slot->value;
    *slot->value = values[n];
    if (slot->key.ends_with(".thickness") && scene.drive && scene.drive->depth) {
      *scene.drive->depth += values[n] - before;
      scene.simulation.duration += std::fmax(values[n] - before, 0.0) / scene.drive->speed;
    }
  }
  return scene;
}

std::vector<std::pair<std::string, double>> changes(const Scene& scene, const Scene& changed) {
  Scene before = scene;
  Scene after = changed;
  const std::vector<Slot> old_slots = slots_of(before);
  const std::vector<Slot> new_slots = slots_of(after);
  std::vector<std::pair<std::string, double>> found;
  for (std::size_t n = 0; n < old_slots.size(); ++n) {
    if (*old_slots[n].value != *new_slots[n].value) {
      found.emplace_back(new_slots[n].key, *new_slots[n].value);
    }
  }
  if (before.drive && before.drive->depth && *before.drive->depth != *after.drive->depth) {
    found.emplace_back("drive.depth", *after.drive->depth);
  }
  if (before.simulation.duration != after.simulation.duration) {
    found.emplace_back("simulation.duration", after.simulation.duration);
  }
  return found;
}

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

Trace run_to_end(Subject& subject, const Scene& scene, const std::atomic<bool>* stop) {
  Trace run = roll_out(subject, scene, {}, {.stop = stop});
  if (run.interrupted) { throw Interrupted(); }
  return run;
}

ObservedInsertion observe_run(const Trace& run) {
  if (run.diverged) {
    return {.refusal = "diverges at t = " + std::to_string(run.diverged_at) + " s"};
  }
  return observe(run);
}

ObservedInsertion simulate_insertion(const Scene& scene, const std::atomic<bool>* stop) {
  ModelSubject subject{Simulation(scene)};
  return observe_run(run_to_end(subject, scene, stop));
}

Forward::Forward(std::vector<Scene> scenes, std::vector<Parameter> parameters, int jobs,
                 const std::atomic<bool>* stop, Simulate simulate)
    : scenes_(std::move(scenes)),
      parameters_(std::move(parameters)),
      jobs_(std::max(1, jobs)),
      stop_(stop),
      simulate_(std::move(simulate)) {
  if (!simulate_) {
    simulate_ = [stop](const Scene& changed) { return simulate_insertion(changed, stop); };
  }
  for (Scene& scene : scenes_) {
    const std::vector<Slot> slots = slots_of(scene);
    std::vector<std::size_t>& own = own_.emplace_back();
    for (std::size_t n = 0; n < parameters_.size(); ++n) {
      if (std::ranges::find(slots, parameters_[n].key, &Slot::key) != slots.end()) {
        own.push_back(n);
      }
    }
  }
}

Forward::Trial Forward::trial(std::size_t scene, const Values& place) const {
  Trial trial{.scene = scene};
  for (const std::size_t n : own_[scene]) { trial.values.push_back(place[n]); }
  return trial;
}

Forward::Values Forward::priors() const {
  Values values;
  for (const Parameter& parameter : parameters_) { values.push_back(parameter.prior); }
  return values;
}

Observation Forward::simulate(const Trial& trial) const {
  if (stop_ != nullptr && stop_->load(std::memory_order_relaxed)) { throw Interrupted(); }
  std::vector<Parameter> own;
  for (const std::size_t n : own_[trial.scene]) { own.push_back(parameters_[n]); }
  const ObservedInsertion seen = simulate_(with_values(scenes_[trial.scene], own, trial.values));
  if (!seen.refusal.empty()) {
    throw std::runtime_error("calibration: the simulated insertion" +
                             places_text(own, trial.values) + " " + seen.refusal);
  }
  return seen.value;
}

void Forward::simulate_new(const std::vector<Trial>& trials) {
  std::vector<Observation> found(trials.size());
  std::vector<std::exception_ptr> thrown(trials.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t n = next++; n < trials.size(); n = next++) {
      try {
        found[n] = simulate(trials[n]);
      } catch (...) { thrown[n] = std::current_exception(); }
    }
  };
  {
    std::vector<std::jthread> helpers;
    const auto most = std::min<std::size_t>(static_cast<std::size_t>(jobs_), trials.size());
    for (std::size_t n = 1; n < most; ++n) { helpers.emplace_back(work); }
    work();
  }
  for (std::size_t n = 0; n < trials.size(); ++n) {
    if (thrown[n]) { std::rethrow_exception(thrown[n]); }
    seen_.emplace(trials[n], std::move(found[n]));
  }
}

std::vector<Observation> Forward::at(const std::vector<Values>& places) {
  std::vector<Trial> unseen;
  for (const Values& place : places) {
    for (std::size_t scene = 0; scene < scenes_.size(); ++scene) {
      Trial next = trial(scene, place);
      const bool known = seen_.contains(next) || std::ranges::find(unseen, next) != unseen.end();
      if (!known) { unseen.push_back(std::move(next)); }
    }
  }
  simulate_new(unseen);
  std::vector<Observation> found;
  for (const Values& place : places) {
    Observation all;
    for (std::size_t scene = 0; scene < scenes_.size(); ++scene) {
      const Observation& part = seen_.at(trial(scene, place));
      all.conservativeResize(all.size() + part.size());
      all.tail(part.size()) = part;
    }
    found.push_back(std::move(all));
  }
  return found;
}

}  // namespace palpate::calibration

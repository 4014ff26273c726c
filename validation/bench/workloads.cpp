// SPDX-License-Identifier: MIT
#include "validation/bench/workloads.hpp"

#include <algorithm>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/kernel_variants.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::bench {

namespace {

Workload oscillator() {
  Workload workload{.name = "oscillator", .what = "one spring, velocity Verlet", .before = 100, .ticks = 1000};
  workload.scene.tissue.source = Source::oscillator;
  workload.scene.simulation = {.duration = 25.0, .step = 0.01, .integrator = "velocity-verlet"};
  workload.scene.simulation.substeps = 1;
  return workload;
}

Workload cube(bool as_list, Precision precision) {
  const bool single = precision == Precision::single_precision;
  Workload workload{.name = std::string("cube-") + (as_list ? "list" : "lattice") + (single ? "-float" : "-double"),
                    .what = "1000 nodes, 26 neighbours, semi-implicit Euler",
                    .scene = s26_scene(10),
                    .as_list = as_list};
  workload.scene.simulation.precision = precision;
  return workload;
}

/// While the tip pierces skin and fat.
Workload needle(const std::string& name, const std::string& what, Scene scene, const std::string& integrator) {
  scene.simulation.integrator = integrator;
  scene.simulation.solver_tolerance = 1e-2;
  return {.name = name, .what = what, .scene = std::move(scene), .before = 60, .ticks = 10};
}

}  // namespace

std::vector<Workload> workloads() {
  return {oscillator(),
          cube(true, Precision::double_precision),
          cube(true, Precision::single_precision),
          cube(false, Precision::double_precision),
          cube(false, Precision::single_precision),
          needle("needle-explicit", "a needle in seven soft layers, velocity Verlet", tools::seven_soft_layers(),
                 "velocity-verlet"),
          needle("needle-implicit", "a needle in ligament of published modulus, implicit Euler",
                 tools::seven_published_layers(6), "implicit-euler")};
}

Workload find_workload(const std::string& name) {
  std::vector<Workload> all = workloads();
  const auto found = std::ranges::find(all, name, &Workload::name);
  if (found != all.end()) { return *found; }
  std::string names;
  for (const Workload& each : all) { names += (names.empty() ? "" : ", ") + each.name; }
  throw InputError("no workload is named \"" + name + "\"; one of " + names);
}

Simulation simulation_of(const Workload& workload) {
  if (!workload.as_list) { return Simulation(workload.scene); }
  SpringNetwork network = build_network(workload.scene);
  break_lattice(network);
  return {workload.scene, network};
}

double spring_steps_of_tick(const Simulation& simulation) {
  return static_cast<double>(simulation.spring_count()) * simulation.plan().substeps;
}

}  // namespace palpate::bench

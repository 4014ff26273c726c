// SPDX-License-Identifier: MIT
/// Extremes of speed, force and step: every value stays finite, or divergence is said.
#include <cmath>

#include "validation/cases/tool_setting.hpp"

namespace palpate::tools {

namespace {

struct Extreme {
  const char* name;
  void (*make)(Scene&);
};

constexpr Extreme extremes[] = {
    {"1 m/s", [](Scene& s) { s.drive->speed = 1.0; s.simulation.duration = 0.03; }},
    {"1 um/s", [](Scene& s) { s.drive->speed = 1e-6; }},
    {"nothing to cut", [](Scene& s) { for (Material& m : s.materials) { m.cutting_force = 0.0; } }},
    {"1000 N to cut", [](Scene& s) { for (Material& m : s.materials) { m.cutting_force = 1e3; } }},
    {"no friction", [](Scene& s) { for (Material& m : s.materials) { m.friction = 0.0; } }},
    {"1000 times the friction",
     [](Scene& s) { for (Material& m : s.materials) { m.friction *= 1e3; } }},
    {"ticks of 0.1 ms", [](Scene& s) { s.simulation.step = 1e-4; }},
    {"ticks of 2 ms", [](Scene& s) { s.simulation.step = 2e-3; }},
    {"a thrust of 5 m/s",
     [](Scene& s) {
       s.drive->from = -0.02;
       s.drive->speed = 5.0;
       s.simulation.duration = 0.008;
     }},
    {"10 N at once",
     [](Scene& s) { s.drive = Drive{.kind = Drive::Kind::force, .force = 10.0, .rise = 0.0}; }},
    {"pushes of 5 N",
     [](Scene& s) {
       s.drive = Drive{.kind = Drive::Kind::force,
                       .technique = Drive::Technique::intermittent,
                       .pause = 0.02,
                       .force = 5.0,
                       .rise = 0.0,
                       .push = 0.01};
     }},
    {"a needle of a milligram",
     [](Scene& s) {
       s.needle->mass = 1e-6;
       s.drive = Drive{.kind = Drive::Kind::force, .force = 1.0, .rise = 0.1, .hand_viscosity = 0.0};
     }},
    {"single precision",
     [](Scene& s) { s.simulation.precision = Precision::single_precision; }},
    {"beyond the block", [](Scene& s) { s.drive->speed = 0.2; s.simulation.duration = 0.3; }},
};

bool finite(const Insertion& run) {
  for (const ToolReport& t : run.tool) {
    const ToolForces& f = t.forces;
    for (const double value : {t.place, t.velocity, t.depth, t.cut, t.slip, f.cutting, f.friction,
                               f.stiffness, f.total, f.applied, f.lateral, t.losses.impact}) {
      if (!std::isfinite(value)) { return false; }
    }
  }
  return !run.tool.empty();
}

void measure_stress(const CaseContext& context, Outcome& outcome) {
  std::vector<std::vector<Cell>> rows;
  for (const char* integrator : {"auto", "velocity-verlet", "implicit-euler"}) {
    double broken = 0.0;
    double diverged = 0.0;
    for (const Extreme& extreme : extremes) {
      Scene scene = seven_soft_layers();
      scene.simulation = {.duration = 0.2, .step = 1e-3, .integrator = integrator};
      extreme.make(scene);
      const Insertion run = insert_tool(context, scene);
      const bool whole = finite(run);
      broken += whole ? 0.0 : 1.0;
      diverged += run.diverged ? 1.0 : 0.0;
      double peak = 0.0;
      for (const ToolReport& t : run.tool) { peak = std::fmax(peak, t.forces.total); }
      rows.push_back({std::string(extreme.name), std::string(integrator),
                      std::string(run.diverged ? "diverged, and said so" : whole ? "finite" : "BROKEN"),
                      peak});
    }
    outcome.judge({.name = std::string("runs_with_values_that_are_not_finite_") + integrator,
                   .value = broken, .upper = 0.0,
                   .bound_from = "a run is finite, or stops and says so"});
    outcome.judge({.name = std::string("runs_that_diverged_") + integrator,
                   .value = diverged,
                   .upper = integrator == std::string("auto") ? 0.0 : 3.0,
                   .bound_from = "automatic stepping keeps every one of them; a scheme asked for by "
                                 "name may give up on a few and says so"});
  }
  outcome.tables.push_back({.id = "stress",
                            .title = "Extremes",
                            .columns = {"scene", "integrator", "outcome", "peak force (N)"},
                            .rows = rows});
}

}  // namespace

std::vector<Case> stress_cases() {
  return {{.name = "needle/stress",
           .suite = "stability",
           .claim = "At extremes of speed, force and step an insertion stays finite or says that "
                    "it diverged.",
           .measure = measure_stress,
           .weight = 6.0}};
}

}  // namespace palpate::tools

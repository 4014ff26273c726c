// SPDX-License-Identifier: MIT
#include "model/dynamics/scene_check.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>

#include "tests/check.hpp"

namespace {

using namespace palpate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

Scene good_scene() {
  Scene scene;
  scene.materials = {{.name = "fat", .youngs_modulus = 2.4e3, .density = 950.0}};
  scene.tissue.lattice.material = "fat";
  scene.loads = {{.nodes = {0}, .force = {0, 0, 1}, .start = 0.0, .end = 0.1}};
  scene.records = {{"tip", 0}};
  return scene;
}

struct Fault {
  const char* key;
  const char* part_of_message;
  std::function<void(Scene&)> plant;
};

bool reported(const std::vector<Violation>& violations, const Fault& fault) {
  return std::ranges::any_of(violations, [&](const Violation& v) {
    return v.key == fault.key && v.message.find(fault.part_of_message) != std::string::npos;
  });
}

void check_each(const std::vector<Fault>& faults) {
  for (const Fault& fault : faults) {
    Scene scene = good_scene();
    fault.plant(scene);
    const std::vector<Violation> found = check_scene(scene);
    if (!reported(found, fault)) {
      std::printf("  %s: %s\n", fault.key,
                  found.empty() ? "nothing found" : found[0].message.c_str());
    }
    CHECK(reported(found, fault));
  }
}

TEST("a good scene breaks no rule") { CHECK(check_scene(good_scene()).empty()); }

TEST("numbers of the simulation are positive and finite, and ticks are countable") {
  check_each({
      {"simulation.duration", "must be > 0", [](Scene& s) { s.simulation.duration = -1.0; }},
      {"simulation.duration", "must be > 0", [](Scene& s) { s.simulation.duration = infinite; }},
      {"simulation.duration", "at least one step", [](Scene& s) { s.simulation.duration = 1e-4; }},
      {"simulation.duration", "at most 1e9", [](Scene& s) { s.simulation.duration = 1e7; }},
      {"simulation.step", "must be > 0", [](Scene& s) { s.simulation.step = nan; }},
      {"simulation.substeps", "1 or more", [](Scene& s) { s.simulation.substeps = 0; }},
      {"simulation.threads", "must be from 1 to 64", [](Scene& s) { s.simulation.threads = 0; }},
      {"simulation.threads", "must be from 1 to 64", [](Scene& s) { s.simulation.threads = 65; }},
  });
}

TEST("materials have positive moduli and no negative damping") {
  check_each({
      {"material.fat.youngs_modulus", "must be > 0",
       [](Scene& s) { s.materials[0].youngs_modulus = 0.0; }},
      {"material.fat.density", "must be > 0", [](Scene& s) { s.materials[0].density = nan; }},
      {"material.fat.damping_ratio", "must be >= 0",
       [](Scene& s) { s.materials[0].damping_ratio = -0.1; }},
      {"material.fat.viscosity", "must be >= 0", [](Scene& s) { s.materials[0].viscosity = -1.0; }},
      {"material.fat.friction", "must be >= 0", [](Scene& s) { s.materials[0].friction = -1.0; }},
  });
}

TEST("a lattice has two nodes a side, a spacing, a known material and 6, 18 or 26 neighbours") {
  check_each({
      {"tissue.lattice.nodes", "2 or more", [](Scene& s) { s.tissue.lattice.nodes[1] = 1; }},
      {"tissue.lattice.nodes", "at most 5e7",
       [](Scene& s) {
         s.tissue.lattice.nodes = {9999, 9999, 9999};
       }},
      {"tissue.lattice.spacing", "must be > 0", [](Scene& s) { s.tissue.lattice.spacing = 0.0; }},
      {"tissue.lattice.connectivity", "6, 18 or 26",
       [](Scene& s) { s.tissue.lattice.connectivity = 7; }},
      {"tissue.lattice.material", "known are fat",
       [](Scene& s) { s.tissue.lattice.material = "bone"; }},
      {"tissue.gravity", "not finite", [](Scene& s) { s.tissue.gravity.x() = nan; }},
  });
}

TEST("uniform weights need stiffness and mass of their own, and no material") {
  const auto uniform = [](Scene& s) {
    s.tissue.lattice.weights = LatticeWeights::uniform;
    s.tissue.lattice.material = "none such";
  };
  Scene scene = good_scene();
  uniform(scene);
  CHECK(check_scene(scene).empty());
  check_each({
      {"tissue.lattice.stiffness", "must be > 0",
       [&](Scene& s) {
         uniform(s);
         s.tissue.lattice.stiffness = 0.0;
       }},
      {"tissue.lattice.node_mass", "must be > 0",
       [&](Scene& s) {
         uniform(s);
         s.tissue.lattice.node_mass = -1.0;
       }},
      {"tissue.lattice.viscosity", "must be >= 0",
       [&](Scene& s) {
         uniform(s);
         s.tissue.lattice.viscosity = -1.0;
       }},
  });
}

TEST("layers have thickness and known materials, and there is at least one") {
  const auto layered = [](Scene& s) {
    s.tissue.source = Source::layers;
    s.tissue.layers = {{"skin", "fat", 0.01}};
  };
  check_each({
      {"layer", "at least one",
       [&](Scene& s) {
         layered(s);
         s.tissue.layers.clear();
       }},
      {"layer[0].thickness", "must be > 0",
       [&](Scene& s) {
         layered(s);
         s.tissue.layers[0].thickness = 0.0;
       }},
      {"layer[0].material", "unknown material",
       [&](Scene& s) {
         layered(s);
         s.tissue.layers[0].material = "none such";
       }},
  });
}

TEST("loads act on nodes that exist, on either nodes or a face, and end after they start") {
  check_each({
      {"load[0].nodes", "0 to 999", [](Scene& s) { s.loads[0].nodes = {1000}; }},
      {"load[0].nodes", "exactly one", [](Scene& s) { s.loads[0].face = Face::z_min; }},
      {"load[0].nodes", "exactly one", [](Scene& s) { s.loads[0].nodes.clear(); }},
      {"load[0].end", "after start", [](Scene& s) { s.loads[0].end = 0.0; }},
      {"load[0].end", "need an end",
       [](Scene& s) {
         s.loads[0].end = infinite;
         s.loads[0].profile = Profile::ramp;
       }},
      {"load[0].start", "must be >= 0", [](Scene& s) { s.loads[0].start = -1.0; }},
      {"load[0].force", "not finite", [](Scene& s) { s.loads[0].force.y() = infinite; }},
  });
}

TEST("records have names of their own, quantities, and nodes that exist") {
  check_each({
      {"record[0].node", "0 to 999", [](Scene& s) { s.records[0].where = -1; }},
      {"record[0].name", "empty", [](Scene& s) { s.records[0].name.clear(); }},
      {"record[1].name", "twice", [](Scene& s) { s.records.push_back(s.records[0]); }},
      {"record[0].quantities", "at least one", [](Scene& s) { s.records[0].quantities.clear(); }},
  });
}

TEST("an oscillator has mass and neither loads nor records") {
  const auto oscillating = [](Scene& s) { s.tissue.source = Source::oscillator; };
  check_each({
      {"tissue.oscillator.mass", "must be > 0",
       [&](Scene& s) {
         oscillating(s);
         s.tissue.oscillator.mass = 0.0;
       }},
      {"load", "no [[load]]", oscillating},
      {"record", "no nodes to record", oscillating},
  });
}

TEST("a network's springs join two different nodes and its free nodes have mass") {
  const auto network = [](Scene& s) {
    s.tissue.source = Source::network;
    s.tissue.network.rest_position = NodeVectors::Zero(3, 2);
    s.tissue.network.mass = Eigen::Vector2d(1.0, 1.0);
    s.tissue.network.fixed = {1, 0};
  };
  Scene heavy = good_scene();
  network(heavy);
  heavy.tissue.network.mass(0) = 0.0;  // fixed nodes need none
  CHECK(check_scene(heavy).empty());
  check_each({
      {"tissue.network.springs", "0 to 1",
       [&](Scene& s) {
         network(s);
         s.tissue.network.springs = {{0, 2, 1, 0, 1}};
       }},
      {"tissue.network.springs", "two different",
       [&](Scene& s) {
         network(s);
         s.tissue.network.springs = {{1, 1, 1, 0, 1}};
       }},
      {"tissue.network.nodes", "must be > 0",
       [&](Scene& s) {
         network(s);
         s.tissue.network.mass(1) = 0.0;
       }},
  });
}

TEST("all broken rules are reported at once") {
  Scene scene = good_scene();
  scene.simulation.step = -1.0;
  scene.tissue.lattice.spacing = -1.0;
  scene.materials[0].density = 0.0;
  CHECK(check_scene(scene).size() >= 3);
}

}  // namespace

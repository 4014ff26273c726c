// SPDX-License-Identifier: MIT

#include "model/tissue/scene_check.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <set>

#include "model/stepping/integrator.hpp"
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

namespace {

using namespace palpate;

/// Ten nodes a side at 5 mm: the skin reaches 22.5 mm each way.
Scene with_needle() {
  Scene scene;
  scene.materials = {{.name = "fat", .youngs_modulus = 2.4e3, .density = 950.0}};
  scene.tissue.lattice.material = "fat";
  scene.needle = Needle{};
  scene.drive = Drive{};
  scene.syringe = Syringe{};
  return scene;
}

Scene with_probe() {
  Scene scene = with_needle();
  scene.needle.reset();
  scene.syringe.reset();
  scene.probe = Probe{};
  return scene;
}

/// The fault is reported, and nothing else is.
void check_each(const std::function<Scene()>& good, const std::vector<Fault>& faults) {
  CHECK(check_scene(good()).empty());
  for (const Fault& fault : faults) {
    Scene scene = good();
    fault.plant(scene);
    const std::vector<Violation> found = check_scene(scene);
    const bool reported = found.size() == 1 && found[0].key == fault.key &&
                          found[0].message.find(fault.part_of_message) != std::string::npos;
    CHECK(reported);
    if (reported) { continue; }
    std::printf("  %s, %s:\n", fault.key, fault.part_of_message);
    for (const Violation& v : found) {
      std::printf("    %s: %s\n", v.key.c_str(), v.message.c_str());
    }
  }
}

TEST("a needle has a diameter, a mass, a direction into the tissue and an entry on the skin") {
  check_each(with_needle,
             {
                 {"needle.diameter", "must be > 0", [](Scene& s) { s.needle->diameter = 0.0; }},
                 {"needle.mass", "must be > 0", [](Scene& s) { s.needle->mass = infinite; }},
                 {"needle.direction", "a length", [](Scene& s) { s.needle->direction.setZero(); }},
                 {"needle.direction", "a length", [](Scene& s) { s.needle->direction.x() = nan; }},
                 {"needle.direction", "within 60 degrees",
                  [](Scene& s) {
                    s.needle->direction = {1.74, 0.0, 1.0};
                  }},
                 {"needle.direction", "within 60 degrees",
                  [](Scene& s) {
                    s.needle->direction = {0.0, 0.0, -1.0};
                  }},
                 {"needle.entry", "|x| <= 0.0225", [](Scene& s) { s.needle->entry.x() = -0.023; }},
                 {"needle.entry", "finite", [](Scene& s) { s.needle->entry.y() = nan; }},
             });
  Scene steep = with_needle();
  steep.needle->direction = {0.0, std::sqrt(3.0), 1.0};  // just 60 degrees, of any length
  steep.needle->entry = {0.0225, -0.0225};               // a corner of the skin
  CHECK(check_scene(steep).empty());
}

TEST("the skin of a layered block bounds the entry, and nothing bounds it in a network") {
  const auto layered = [] {
    Scene scene = with_needle();
    scene.tissue.source = Source::layers;
    scene.tissue.block = {.nodes = {3, 5}, .spacing = 0.01};
    scene.tissue.layers = {{"skin", "fat", 0.02}};
    return scene;
  };
  check_each(layered, {{"needle.entry", "|x| <= 0.01 and |y| <= 0.02",
                        [](Scene& s) { s.needle->entry.x() = 0.011; }}});
  Scene network = layered();
  network.tissue.source = Source::network;
  network.tissue.network.rest_position = NodeVectors::Zero(3, 1);
  network.tissue.network.mass = Eigen::VectorXd::Ones(1);
  network.tissue.network.fixed = {0};
  network.needle->entry = {5.0, 5.0};
  CHECK(check_scene(network).empty());
}

TEST("a probe has a mass, a size and lies on the skin as a whole") {
  check_each(with_probe, {
                             {"probe.mass", "must be > 0", [](Scene& s) { s.probe->mass = 0.0; }},
                             {"probe.size", "must be > 0",
                              [](Scene& s) {
                                s.probe->size = {-0.01, -0.01};
                              }},
                             {"probe.size", "one diameter",
                              [](Scene& s) {
                                s.probe->size = {0.01, 0.02};
                              }},
                             {"probe.entry", "all of its size",
                              [](Scene& s) {
                                s.probe->entry = {0.0, 0.016};
                              }},
                             {"probe.entry", "all of its size",
                              [](Scene& s) {
                                s.probe->shape = Probe::Shape::ultrasound;
                                s.probe->size = {0.06, 0.01};
                              }},
                         });
  check_each(
      with_probe,
      {
          {"probe.map.spacing", "must be > 0", [](Scene& s) { s.probe->map = {.spacing = 0.0}; }},
          {"probe.map.sites", "both must be >= 1",
           [](Scene& s) {
             s.probe->map = {.sites = {0, 3}};
           }},
          {"probe.map.sites", "at most 10000",
           [](Scene& s) {
             s.probe->map = {.sites = {1001, 1000}, .spacing = 1e-9};
           }},
          {"probe.map", "the skin ends", [](Scene& s) { s.probe->map = {.spacing = 0.01}; }},
      });
  Scene edge = with_probe();
  edge.probe->entry = {0.015, -0.015};
  CHECK(check_scene(edge).empty());
}

TEST("a scene has one tool at most, and neither drive nor syringe without one") {
  check_each(with_needle,
             {
                 {"probe", "only one", [](Scene& s) { s.probe = Probe{}; }},
                 {"syringe", "without [needle]",
                  [](Scene& s) {
                    s.needle.reset();
                    s.probe = Probe{};
                  }},
                 {"drive", "without a tool",
                  [](Scene& s) {
                    s.needle.reset();
                    s.syringe.reset();
                  }},
                 {"needle", "has no skin", [](Scene& s) { s.tissue.source = Source::oscillator; }},
             });
  check_each(with_probe,
             {{"probe", "has no skin", [](Scene& s) { s.tissue.source = Source::oscillator; }}});
}

TEST("a drive starts outside the tissue, ends deeper, and its numbers are in range") {
  check_each(
      with_needle,
      {
          {"drive.start", "must be >= 0", [](Scene& s) { s.drive->start = -1.0; }},
          {"drive.from", "must be <= 0", [](Scene& s) { s.drive->from = 1e-3; }},
          {"drive.from", "must be <= 0", [](Scene& s) { s.drive->from = -infinite; }},
          {"drive.speed", "must be > 0", [](Scene& s) { s.drive->speed = nan; }},
          {"drive.advance", "must be > 0", [](Scene& s) { s.drive->advance = 0.0; }},
          {"drive.pause", "must be >= 0", [](Scene& s) { s.drive->pause = -1.0; }},
          {"drive.depth", "must be > from", [](Scene& s) { s.drive->depth = 0.0; }},
          {"drive.hold", "must be >= 0", [](Scene& s) { s.drive->hold = -1.0; }},
          {"drive.withdraw_speed", "must be >= 0",
           [](Scene& s) { s.drive->withdraw_speed = -1.0; }},
          {"drive.grip_stiffness", "must be > 0", [](Scene& s) { s.drive->grip_stiffness = 0.0; }},
          {"drive.force", "must be > 0", [](Scene& s) { s.drive->force = 0.0; }},
          {"drive.rise", "must be >= 0", [](Scene& s) { s.drive->rise = -1.0; }},
          {"drive.push", "must be > 0", [](Scene& s) { s.drive->push = 0.0; }},
          {"drive.withdraw_force", "must be >= 0",
           [](Scene& s) { s.drive->withdraw_force = -1.0; }},
          {"drive.hand_viscosity", "must be >= 0",
           [](Scene& s) { s.drive->hand_viscosity = -1.0; }},
      });
}

TEST("an intermittent drive makes at most a million pauses") {
  const auto tapping = [] {
    Scene scene = with_needle();
    scene.drive->technique = Drive::Technique::intermittent;
    scene.drive->pause = 0.0;
    return scene;
  };
  const auto tiny = [](Scene& s) { s.drive->advance = 1e-10; };  // 25 million in half a second
  check_each(tapping, {{"drive.technique", "2.5e+07 pauses", tiny},
                       {"drive.technique", "at most 1e6", [](Scene& s) {
                          s.drive->kind = Drive::Kind::force;
                          s.drive->push = 1e-9;
                        }}});
  Scene shallow = tapping();  // all advances are made before the time is over
  tiny(shallow);
  shallow.drive->depth = 1e-5;
  CHECK(check_scene(shallow).empty());
  Scene continuous = tapping();
  tiny(continuous);
  continuous.drive->technique = Drive::Technique::continuous;
  CHECK(check_scene(continuous).empty());
}

TEST("a syringe has area, compliance and resistances, and its thumb does not pull") {
  check_each(with_needle,
             {
                 {"syringe.plunger_area", "> 0", [](Scene& s) { s.syringe->plunger_area = 0.0; }},
                 {"syringe.compliance", "> 0", [](Scene& s) { s.syringe->compliance = nan; }},
                 {"syringe.thumb_force", ">= 0", [](Scene& s) { s.syringe->thumb_force = -1.0; }},
                 {"syringe.thumb_flow", ">= 0", [](Scene& s) { s.syringe->thumb_flow = -1.0; }},
                 {"syringe.tissue_resistance", "> 0",
                  [](Scene& s) { s.syringe->tissue_resistance = 0.0; }},
                 {"syringe.epidural_resistance", "> 0",
                  [](Scene& s) { s.syringe->epidural_resistance = 0.0; }},
                 {"syringe.open_resistance", "> 0",
                  [](Scene& s) { s.syringe->open_resistance = infinite; }},
             });
}

TEST("a needle in a tissue without materials needs layers, and other tissues refuse them") {
  const auto uniform = [] {
    Scene scene = with_needle();
    scene.tissue.lattice.weights = LatticeWeights::uniform;
    scene.tissue.layers = {{"fat", "fat", 0.01}};
    return scene;
  };
  check_each(uniform, {
                          {"layer", "at least one", [](Scene& s) { s.tissue.layers.clear(); }},
                          {"layer[0].material", "unknown material \"jelly\"",
                           [](Scene& s) { s.tissue.layers[0].material = "jelly"; }},
                          {"layer[0].thickness", "must be > 0",
                           [](Scene& s) { s.tissue.layers[0].thickness = -1.0; }},
                          {"layer", "must be left out",
                           [](Scene& s) { s.tissue.lattice.weights = LatticeWeights::cell; }},
                          {"layer", "must be left out",
                           [](Scene& s) {
                             s.needle.reset();
                             s.drive.reset();
                             s.syringe.reset();
                           }},
                      });
}

TEST("a tool is refused with printed updates that have no velocity of the instant") {
  const std::vector<Fault> faults{
      {"simulation.printed.no_time_step", "must be false",
       [](Scene& s) { s.simulation.printed.no_time_step = true; }},
      {"simulation.printed.lagged_velocity", "must be false",
       [](Scene& s) { s.simulation.printed.lagged_velocity = true; }},
  };
  check_each(with_needle, faults);
  check_each(with_probe, faults);
  Scene others = with_needle();
  others.simulation.printed = {.sign = true, .direction = true, .half_force = true};
  CHECK(check_scene(others).empty());
}

TEST("every integrator is allowed with a tool by name or refused for its half steps") {
  const std::set<std::string_view> half_steps{"leapfrog", "feynman-newton"};
  Scene refused = with_needle();
  refused.simulation.integrator = "leapfrog";
  const std::vector<Violation> found = check_scene(refused);
  REQUIRE(found.size() == 1);
  CHECK(found[0].key == "simulation.integrator");
  for (const IntegratorInfo* info : integrators()) {
    const std::string quoted = '"' + std::string(info->name) + '"';
    const bool offered = found[0].message.find(quoted, quoted.size()) != std::string::npos;
    Scene scene = with_needle();
    scene.simulation.integrator = info->name;
    const bool half = half_steps.contains(info->name);
    CHECK(offered == !half);
    CHECK(check_scene(scene).empty() == !half);
  }
}

}  // namespace

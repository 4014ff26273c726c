// SPDX-License-Identifier: MIT
#include "model/dynamics/tool_check.hpp"

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

struct Fault {
  const char* key;
  const char* part_of_message;
  std::function<void(Scene&)> plant;
};

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
  check_each(with_probe, {
                             {"probe.map.spacing", "must be > 0",
                              [](Scene& s) { s.probe->map = {.spacing = 0.0}; }},
                             {"probe.map.sites", "both must be >= 1",
                              [](Scene& s) {
                                s.probe->map = {.sites = {0, 3}};
                              }},
                             {"probe.map.sites", "at most 10000",
                              [](Scene& s) {
                                s.probe->map = {.sites = {1001, 1000}, .spacing = 1e-9};
                              }},
                             {"probe.map", "the skin ends",
                              [](Scene& s) { s.probe->map = {.spacing = 0.01}; }},
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
  CHECK(found.size() == 1 && found[0].key == "simulation.integrator");
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

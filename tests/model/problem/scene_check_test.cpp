// SPDX-License-Identifier: MIT

#include "model/tissue/scene_check.hpp"

#include <algorithm>
#include <concepts>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "model/problem/scene_keys.hpp"
#include "model/stepping/integrator.hpp"
#include "tests/check.hpp"
#include "tests/range_bounds.hpp"

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

/// Sets all numbers of a member; texts, keywords and flags do not change.
enum class Numbers { none, whole, real };
template <class T> Numbers set_numbers(T&& member, double value) {
  using Plain = std::remove_cvref_t<T>;
  if constexpr (std::same_as<Plain, double> || std::same_as<Plain, std::optional<double>>) {
    member = value;
    return Numbers::real;
  } else if constexpr (std::same_as<Plain, int> || std::same_as<Plain, std::optional<int>>) {
    member = static_cast<int>(value);
    return Numbers::whole;
  } else if constexpr (std::same_as<Plain, std::vector<int>>) {
    member.assign(1, static_cast<int>(value));
    return Numbers::whole;
  } else if constexpr (requires {
                         member.fill(int{});
                         member.setConstant(value);
                       }) {
    member.setConstant(value);
    return Numbers::real;
  } else if constexpr (requires { member.fill(int{}); }) {
    member.fill(static_cast<int>(value));
    return Numbers::whole;
  } else if constexpr (requires { member.count; }) {
    return set_numbers(member.count, value);
  } else if constexpr (requires { member.size.setConstant(value); }) {
    return set_numbers(member.size, value);
  } else if constexpr (std::same_as<Plain, NodeOf<std::variant<int, Eigen::Vector3d>>>) {
    member.where = static_cast<int>(value);
    return Numbers::whole;
  }
  return Numbers::none;
}

struct NumberKey {
  std::string name{};
  Key key{};
  bool whole = false;
};

/// Visitor of scene_keys.hpp that lists the numeric keys, and sets the values of one key.
class NumberSetter {
 public:
  NumberSetter(std::vector<NumberKey>& keys, std::string target, double value,
               std::string prefix = "")
      : keys_(keys), target_(std::move(target)), value_(value), prefix_(std::move(prefix)) {}

  template <class T> void value(std::string_view name, T&& member, const Key& key) {
    const std::string dotted = prefix_ + std::string(name);
    if (!target_.empty() && dotted != target_) { return; }
    const Numbers numbers = set_numbers(member, value_);
    if (numbers == Numbers::none) { return; }
    keys_.push_back({dotted, key, numbers == Numbers::whole});
  }
  template <class T> void table(std::string_view name, T& member) {
    NumberSetter inner(keys_, target_, value_, prefix_ + std::string(name) + ".");
    fields(inner, member);
  }
  template <class T> void optional_table(std::string_view name, std::optional<T>& member) {
    REQUIRE(member);
    table(name, *member);
  }
  template <class T> void list(std::string_view name, std::vector<T>& members) {
    REQUIRE(!members.empty());
    table(std::string(name) + "[0]", members[0]);
  }
  void exactly_one(std::string_view, std::string_view) {}
  void at_most_one(std::string_view, std::string_view) {}

 private:
  std::vector<NumberKey>& keys_;
  std::string target_;
  double value_;
  std::string prefix_;
};

/// Scene with every table, so that every key is present. It violates rules between tables.
Scene scene_of_all_tables() {
  Scene scene = good_scene();
  scene.tissue.layers = {{"fat", "fat", 0.01}};
  scene.tissue.inclusions = {{.size = {0.01, 0.01, 0.01}, .material = "fat"}};
  scene.needle = Needle{};
  scene.probe = Probe{.map = PalpationGrid{}};
  scene.drive = Drive{};
  scene.falcon = FalconDrive{};
  scene.syringe = Syringe{};
  return scene;
}

/// Returns true if check_scene rejects this value of the key with this text.
bool refuses(const std::string& key, double value, const std::string& text) {
  Scene scene = scene_of_all_tables();
  std::vector<NumberKey> keys;
  NumberSetter setter(keys, key, value);
  fields(setter, scene);
  REQUIRE(keys.size() == 1);
  return std::ranges::any_of(check_scene(scene), [&](const Violation& v) {
    return v.key == key && v.message.ends_with("; " + text);
  });
}

TEST("every bound of every key is checked: just outside is refused, just inside is not") {
  Scene scene = scene_of_all_tables();
  std::vector<NumberKey> keys;
  NumberSetter setter(keys, "", 1.0);
  fields(setter, scene);
  CHECK(keys.size() > 70);
  for (const NumberKey& number : keys) {
    const auto& [key, rule, whole] = number;
    for (const auto& [value, allowed] : test::around_bounds(rule.range, whole)) {
      const bool refused = refuses(key, value, rule.range.text());
      if (refused == allowed) {
        std::printf("  %s = %.17g; %s\n", key.c_str(), value, rule.range.text().c_str());
      }
      CHECK(refused == !allowed);
    }
    if (whole) { continue; }
    CHECK(refuses(key, nan, "must be finite"));
    CHECK(refuses(key, -infinite, "must be finite"));
    CHECK(refuses(key, infinite, "must be finite") == !rule.endless);
  }
}

TEST("a good scene breaks no rule") { CHECK(check_scene(good_scene()).empty()); }

TEST("the duration has at least one tick and at most 1e9") {
  check_each({
      {"simulation.duration", "at least one step", [](Scene& s) { s.simulation.duration = 1e-4; }},
      {"simulation.duration", "at most 1e9", [](Scene& s) { s.simulation.duration = 1e7; }},
  });
}

TEST("a lattice has a known material and at most 5e7 nodes") {
  check_each({
      {"tissue.lattice.nodes", "at most 5e7",
       [](Scene& s) {
         s.tissue.lattice.nodes = {9999, 9999, 9999};
       }},
      {"tissue.lattice.material", "known are fat",
       [](Scene& s) { s.tissue.lattice.material = "bone"; }},
  });
}

TEST("uniform weights need no material") {
  const auto uniform = [](Scene& s) {
    s.tissue.lattice.weights = LatticeWeights::uniform;
    s.tissue.lattice.material = "none such";
  };
  Scene scene = good_scene();
  uniform(scene);
  CHECK(check_scene(scene).empty());
}

TEST("layers have known materials, and there is at least one") {
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
  });
}

TEST("records have names of their own, quantities, and nodes that exist") {
  check_each({
      {"record[0].node", "0 to 999", [](Scene& s) { s.records[0].where = 1000; }},
      {"record[0].name", "empty", [](Scene& s) { s.records[0].name.clear(); }},
      {"record[1].name", "twice", [](Scene& s) { s.records.push_back(s.records[0]); }},
      {"record[0].quantities", "at least one", [](Scene& s) { s.records[0].quantities.clear(); }},
  });
}

TEST("an oscillator has neither loads nor records") {
  const auto oscillating = [](Scene& s) { s.tissue.source = Source::oscillator; };
  check_each({
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

/// Ten nodes per side at 5 mm: the skin extends 22.5 mm to each side.
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

/// Checks that each fault is reported, and no other.
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

TEST("a needle has a direction into the tissue and an entry on the skin") {
  check_each(with_needle,
             {
                 {"needle.direction", "a length", [](Scene& s) { s.needle->direction.setZero(); }},
                 {"needle.direction", "within 60 degrees",
                  [](Scene& s) {
                    s.needle->direction = {1.74, 0.0, 1.0};
                  }},
                 {"needle.direction", "within 60 degrees",
                  [](Scene& s) {
                    s.needle->direction = {0.0, 0.0, -1.0};
                  }},
                 {"needle.entry", "|x| <= 0.0225", [](Scene& s) { s.needle->entry.x() = -0.023; }},
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

TEST("a probe lies on the skin as a whole") {
  check_each(with_probe, {
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
  check_each(with_probe,
             {
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

TEST("a drive ends deeper than it starts") {
  check_each(with_needle,
             {{"drive.depth", "must be > from", [](Scene& s) { s.drive->depth = 0.0; }}});
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

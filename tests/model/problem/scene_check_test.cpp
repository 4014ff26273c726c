// SPDX-License-Identifier: MIT

#include "model/tissue/scene_check.hpp"

#include <algorithm>
#include <concepts>
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

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Vector3d;

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

/// Checks that a change to a good scene breaks the rule of this key, and no other rule.
void refuses(Scene scene, const char* key, const char* part_of_message,
             const std::function<void(Scene&)>& plant) {
  check::row = std::string(key) + ", " + part_of_message;
  CHECK(check_scene(scene).empty());
  plant(scene);
  const std::vector<Violation> found = check_scene(scene);
  for (const Violation& v : found) { check::row += "\n    " + v.key + ": " + v.message; }
  REQUIRE(found.size() == 1);
  CHECK(found[0].key == key);
  CHECK_CONTAINS(found[0].message, part_of_message);
}

void accepts(const Scene& scene) { CHECK(check_scene(scene).empty()); }

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
  scene.materials[0].stiffening = Stiffening{.rate = 1.0};
  scene.materials[0].relaxation = {{0.1, 1.0}};
  scene.materials[0].changes = {{0.1, 1e4}};
  scene.needle = Needle{};
  scene.probe = Probe{.map = PalpationGrid{}};
  scene.drive = Drive{};
  scene.falcon = FalconDrive{};
  scene.syringe = Syringe{};
  return scene;
}

/// Returns true if check_scene rejects this value of the key with this text.
bool refuses_value(const std::string& key, double value, const std::string& text) {
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
      check::row = key + " = " + check::shown(value) + "; " + rule.range.text();
      CHECK(refuses_value(key, value, rule.range.text()) == !allowed);
    }
    if (whole) { continue; }
    CHECK(refuses_value(key, nan, "must be finite"));
    CHECK(refuses_value(key, -infinite, "must be finite"));
    CHECK(refuses_value(key, infinite, "must be finite") == !rule.endless);
  }
}

TEST("the duration has at least one tick and at most 1e9") {
  refuses(good_scene(), "simulation.duration", "at least one step",
          [](Scene& s) { s.simulation.duration = 1e-4; });
  refuses(good_scene(), "simulation.duration", "at most 1e9",
          [](Scene& s) { s.simulation.duration = 1e7; });
}

TEST("a lattice has a known material and at most 5e7 nodes; uniform weights need no material") {
  Scene scene = good_scene();
  refuses(scene, "tissue.lattice.nodes", "at most 5e7",
          [](Scene& s) { s.tissue.lattice.nodes.fill(9999); });
  refuses(scene, "tissue.lattice.spacing", "from 1e-09 to 1e+09",
          [](Scene& s) { s.tissue.lattice.spacing = 1e-300; });
  refuses(scene, "tissue.lattice.spacing", "from 1e-09 to 1e+09",
          [](Scene& s) { s.tissue.lattice.spacing = 1e10; });
  refuses(scene, "tissue.lattice.material", "known are fat",
          [](Scene& s) { s.tissue.lattice.material = "bone"; });
  scene.tissue.lattice.weights = LatticeWeights::uniform;
  scene.tissue.lattice.material = "none such";
  accepts(scene);
}

TEST("layers have known materials, and there is at least one") {
  Scene scene = good_scene();
  scene.tissue.source = Source::layers;
  scene.tissue.layers = {{"skin", "fat", 0.01}};
  scene.loads.clear();
  refuses(scene, "layer", "at least one", [](Scene& s) { s.tissue.layers.clear(); });
  refuses(scene, "layer[0].material", "unknown material",
          [](Scene& s) { s.tissue.layers[0].material = "none such"; });
}

TEST("loads act on nodes that exist, on either nodes or a face, and end after they start") {
  const Scene scene = good_scene();
  refuses(scene, "load[0].nodes", "0 to 999", [](Scene& s) { s.loads[0].nodes = {1000}; });
  refuses(scene, "load[0].nodes", "node 7 twice", [](Scene& s) { s.loads[0].nodes = {7, 3, 7}; });
  refuses(scene, "load[0].nodes", "exactly one", [](Scene& s) { s.loads[0].face = Face::z_min; });
  refuses(scene, "load[0].nodes", "exactly one", [](Scene& s) { s.loads[0].nodes.clear(); });
  refuses(scene, "load[0].end", "after start", [](Scene& s) { s.loads[0].start = 0.1; });
  refuses(scene, "load[0].end", "need an end", [](Scene& s) {
    s.loads[0].end = infinite;
    s.loads[0].profile = Profile::ramp;
  });
}

TEST("records have names of their own, quantities, and nodes that exist") {
  const Scene scene = good_scene();
  refuses(scene, "record[0].node", "0 to 999", [](Scene& s) { s.records[0].where = 1000; });
  refuses(scene, "record[0].name", "empty", [](Scene& s) { s.records[0].name.clear(); });
  refuses(scene, "record[1].name", "twice", [](Scene& s) { s.records.push_back(s.records[0]); });
  refuses(scene, "record[0].quantities", "at least one",
          [](Scene& s) { s.records[0].quantities.clear(); });
}

TEST("an oscillator has neither loads nor records") {
  const auto oscillating = [](Scene& s) { s.tissue.source = Source::oscillator; };
  Scene loaded = good_scene();
  loaded.records.clear();
  refuses(loaded, "load", "no [[load]]", oscillating);
  Scene recorded = good_scene();
  recorded.loads.clear();
  refuses(recorded, "record", "no nodes to record", oscillating);
}

TEST("a network's springs join two different nodes and its free nodes have mass") {
  Scene scene = good_scene();
  scene.tissue.source = Source::network;
  scene.tissue.network.rest_position = NodeVectors::Zero(3, 2);
  scene.tissue.network.mass = Eigen::Vector2d(0.0, 1.0);  // fixed nodes need none
  scene.tissue.network.fixed = {1, 0};
  const auto joined = [](int a, int b) {
    return [=](Scene& s) { s.tissue.network.springs.push_back({a, b, 1, 0, 1}); };
  };
  refuses(scene, "tissue.network.springs", "0 to 1", joined(0, 2));
  refuses(scene, "tissue.network.springs", "two different", joined(1, 1));
  refuses(scene, "tissue.network.nodes", "must be > 0",
          [](Scene& s) { s.tissue.network.mass(1) = 0.0; });
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

TEST("a needle has a direction into the tissue and an entry on the skin") {
  Scene scene = with_needle();
  refuses(scene, "needle.direction", "a length", [](Scene& s) { s.needle->direction.setZero(); });
  for (const Vector3d& direction : {Vector3d(1.74, 0.0, 1.0), Vector3d(0.0, 0.0, -1.0)}) {
    refuses(scene, "needle.direction", "within 60 degrees",
            [&](Scene& s) { s.needle->direction = direction; });
  }
  refuses(scene, "needle.entry", "|x| <= 0.0225", [](Scene& s) { s.needle->entry.x() = -0.023; });
  scene.needle->direction = {0.0, std::sqrt(3.0), 1.0};  // just 60 degrees, of any length
  scene.needle->entry = {0.0225, -0.0225};               // a corner of the skin
  accepts(scene);
}

TEST("the skin of a layered block bounds the entry, and nothing bounds it in a network") {
  Scene scene = with_needle();
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {3, 5}, .spacing = 0.01};
  scene.tissue.layers = {{"skin", "fat", 0.02}};
  refuses(scene, "needle.entry", "|x| <= 0.01 and |y| <= 0.02",
          [](Scene& s) { s.needle->entry.x() = 0.011; });
  scene.tissue.source = Source::network;
  scene.tissue.network.rest_position = NodeVectors::Zero(3, 1);
  scene.tissue.network.mass = Eigen::VectorXd::Ones(1);
  scene.tissue.network.fixed = {0};
  scene.needle->entry = {5.0, 5.0};
  accepts(scene);
}

TEST("a probe lies on the skin as a whole") {
  Scene scene = with_probe();
  refuses(scene, "probe.size", "one diameter", [](Scene& s) { s.probe->size.y() *= 2.0; });
  refuses(scene, "probe.entry", "all of its size", [](Scene& s) { s.probe->entry.y() = 0.016; });
  refuses(scene, "probe.entry", "all of its size", [](Scene& s) {
    s.probe->shape = Probe::Shape::ultrasound;
    s.probe->size = {0.06, 0.01};
  });
  refuses(scene, "probe.map.sites", "at most 10000", [](Scene& s) {
    s.probe->map = {.sites = {1001, 1000}, .spacing = 1e-9};
  });
  refuses(scene, "probe.map", "the skin ends", [](Scene& s) { s.probe->map = {.spacing = 0.01}; });
  scene.probe->entry = {0.015, -0.015};
  accepts(scene);
}

TEST("a spherical tip is round, rigid, at rest on the skin and not narrower than its face") {
  Scene scene = with_probe();
  scene.probe->tip_radius = 0.5 * scene.probe->size.x();
  accepts(scene);
  refuses(scene, "probe.tip_radius", "must be > 0", [](Scene& s) { s.probe->tip_radius = -0.01; });
  refuses(scene, "probe.tip_radius", "at least half of probe.size, 0.0075 m",
          [](Scene& s) { s.probe->tip_radius = 0.0074; });
  refuses(scene, "probe.tip_radius", "probe.shape be \"fingertip\"",
          [](Scene& s) { s.probe->shape = Probe::Shape::ultrasound; });
  refuses(scene, "probe.tip_radius", "probe.face be \"rigid\"",
          [](Scene& s) { s.probe->face = Probe::FaceKind::uniform; });
  refuses(scene, "probe.tip_radius", "probe.entry given instead of probe.path", [](Scene& s) {
    s.probe->path = {{0.0, 0.0, 0.0}};
  });
}

TEST("the path of a probe ascends in time and stays on the skin") {
  Scene scene = with_probe();
  scene.probe->path = {{0.0, -0.002, 0.0}, {1.0, 0.002, 0.001}};
  accepts(scene);
  refuses(scene, "probe.path", "empty", [](Scene& s) { s.probe->path->clear(); });
  refuses(scene, "probe.path[1]", "times must ascend",
          [](Scene& s) { (*s.probe->path)[1].x() = 0.0; });
  refuses(scene, "probe.path[0]", "must be finite",
          [](Scene& s) { (*s.probe->path)[0].y() = std::nan(""); });
  refuses(scene, "probe.path[1]", "all of its size",
          [](Scene& s) { (*s.probe->path)[1].z() = 0.016; });
  refuses(scene, "probe.path", "without materials on a grid",
          [](Scene& s) { s.tissue.lattice.weights = LatticeWeights::uniform; });
}

TEST("a scene has one tool at most, and neither drive nor syringe without one") {
  const Scene needle = with_needle();
  refuses(needle, "probe", "only one", [](Scene& s) { s.probe = Probe{}; });
  refuses(needle, "syringe", "without [needle]", [](Scene& s) {
    s.needle.reset();
    s.probe = Probe{};
  });
  refuses(needle, "drive", "without a tool", [](Scene& s) {
    s.needle.reset();
    s.syringe.reset();
  });
  const auto oscillating = [](Scene& s) { s.tissue.source = Source::oscillator; };
  refuses(needle, "needle", "has no skin", oscillating);
  refuses(with_probe(), "probe", "has no skin", oscillating);
}

TEST("a crack needs no less force to begin than to grow, and speeds no exponent without a travel") {
  Scene scene = good_scene();
  scene.materials[0].cutting_force = 1.0;
  refuses(scene, "material[0].puncture_force", "at least the cutting_force of 1 N",
          [](Scene& s) { s.materials[0].puncture_force = 0.5; });
  refuses(scene, "material[0].friction_exponent", "or friction_travel added",
          [](Scene& s) { s.materials[0].friction_exponent = 0.2; });
  scene.materials[0].puncture_force = 1.0;
  scene.materials[0].friction_travel = 1e-3;
  scene.materials[0].friction_exponent = 0.2;
  accepts(scene);
}

TEST("the other hand has a share only in a needle that the thumb drives") {
  Scene scene = good_scene();
  scene.needle = Needle{};
  scene.syringe = Syringe{};
  refuses(scene, "syringe.hand_share", "thumb = \"drives\"",
          [](Scene& s) { s.syringe->hand_share = 0.5; });
  scene.syringe = Syringe{.thumb = Syringe::Thumb::drives, .hand_share = 0.5};
  accepts(scene);
}

TEST("a drive ends deeper than it starts") {
  refuses(with_needle(), "drive.depth", "must be > from", [](Scene& s) { s.drive->depth = 0.0; });
}

TEST("an intermittent drive makes at most a million pauses") {
  Scene scene = with_needle();
  scene.drive->technique = Drive::Technique::intermittent;
  scene.drive->pause = 0.0;
  refuses(scene, "drive.technique", "2.5e+07 pauses",
          [](Scene& s) { s.drive->advance = 1e-10; });  // 25 million in half a second
  refuses(scene, "drive.technique", "at most 1e6", [](Scene& s) {
    s.drive->kind = Drive::Kind::force;
    s.drive->push = 1e-9;
  });
  scene.drive->advance = 1e-10;
  scene.drive->depth = 1e-5;  // all advances are made before the time is over
  accepts(scene);
  scene.drive->depth.reset();
  scene.drive->technique = Drive::Technique::continuous;
  accepts(scene);
}

TEST("a needle in a tissue without materials needs layers, and other tissues refuse them") {
  Scene scene = with_needle();
  scene.tissue.lattice.weights = LatticeWeights::uniform;
  scene.tissue.layers = {{"fat", "fat", 0.01}};
  refuses(scene, "layer", "at least one", [](Scene& s) { s.tissue.layers.clear(); });
  refuses(scene, "layer[0].material", "unknown material \"jelly\"",
          [](Scene& s) { s.tissue.layers[0].material = "jelly"; });
  refuses(scene, "layer", "must be left out",
          [](Scene& s) { s.tissue.lattice.weights = LatticeWeights::cell; });
  refuses(scene, "layer", "must be left out", [](Scene& s) {
    s.needle.reset();
    s.drive.reset();
    s.syringe.reset();
  });
}

TEST("a tool is refused with printed updates that have no velocity of the instant") {
  for (const Scene& scene : {with_needle(), with_probe()}) {
    refuses(scene, "simulation.printed.no_time_step", "must be false",
            [](Scene& s) { s.simulation.printed.no_time_step = true; });
    refuses(scene, "simulation.printed.lagged_velocity", "must be false",
            [](Scene& s) { s.simulation.printed.lagged_velocity = true; });
  }
  Scene others = with_needle();
  others.simulation.printed = {.sign = true, .direction = true, .half_force = true};
  accepts(others);
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

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT

#include "reports/cli/falcon_script.hpp"

#include <limits>

#include "fixtures/io/toml_file.hpp"

namespace palpate::cli {
namespace {

using namespace device::falcon;

enum class ButtonName { plus, forward, centre, minus };
constexpr auto words(ButtonName e) { return in_order(e, "plus", "forward", "centre", "minus"); }

Buttons buttons_of(ButtonName name) {
  return {.plus = name == ButtonName::plus,
          .forward = name == ButtonName::forward,
          .centre = name == ButtonName::centre,
          .minus = name == ButtonName::minus};
}

}  // namespace
}  // namespace palpate::cli

namespace palpate::device::falcon {

constexpr auto words(LinkFault::Kind e) {
  return in_order(e, "latency", "drop", "duplicate", "corrupt", "unplug", "power-loss",
                  "stuck-encoder", "stuck-button");
}
constexpr auto words(LinkFault::Direction e) { return in_order(e, "both", "to-device", "to-host"); }

}  // namespace palpate::device::falcon

namespace palpate::io {

using namespace device::falcon;

constexpr Key seconds{.unit = "s", .range = range::non_negative};
constexpr Key delay{.unit = "s", .range = range::from_to(0.0, 60.0)};

template <class Visitor> void read_button(Visitor& v, Buttons& buttons, const Key& key) {
  std::optional<cli::ButtonName> name;
  v.value("button", name, key);
  if (name) { buttons = cli::buttons_of(*name); }
}

// Keys of a script, each listed once as in scene_keys.hpp; read by io::TomlReader.
template <class Visitor> void fields(Visitor& v, LinkFault& f) {
  v.value("kind", f.kind, required({}));
  v.value("direction", f.direction, {});
  v.value("probability", f.probability, {.range = range::share});
  v.value("start", f.start, seconds);
  v.value("end", f.end, {.unit = "s", .range = range::positive});
  v.value("latency", f.latency, delay);
  v.value("jitter", f.jitter, delay);
  v.value("run", f.run, {.range = range::at_least(1)});
  v.value("leg", f.leg, {.range = range::at_least(1)});
  read_button(v, f.buttons, {});
}

template <class Visitor> void fields(Visitor& v, GripScript::Pose& p) {
  v.value("time", p.time, required({.unit = "s", .range = range::non_negative}));
  v.value("counts", p.counts, required({}));
}

template <class Visitor> void fields(Visitor& v, GripScript::Press& p) {
  p.end = std::numeric_limits<double>::infinity();
  read_button(v, p.buttons, required({}));
  v.value("start", p.start, seconds);
  v.value("end", p.end, {.unit = "s", .range = range::positive});
}

template <class Visitor> void fields(Visitor& v, GripScript& g) {
  v.value("homed", g.homed, {});
  v.value("power_on", g.power_on, {});
  v.list("pose", g.poses);
  v.list("press", g.presses);
}

template <class Visitor> void fields(Visitor& v, FirmwareOptions& f) {
  v.value("watchdog", f.watchdog, {.unit = "s", .range = range::positive});
  v.value("load_silence", f.load_silence, {.unit = "s", .range = range::positive});
  v.value("loaded", f.loaded, {});
}

template <class Visitor> void fields(Visitor& v, cli::FalconScript& s) {
  int seed = 1;
  std::optional<FirmwareOptions> firmware;
  std::optional<GripScript> grip;
  v.value("seed", seed, {.range = range::non_negative});
  v.optional_table("firmware", firmware);
  v.optional_table("grip", grip);
  v.list("fault", s.faults.faults);
  s.faults.seed = static_cast<std::uint64_t>(seed);
  s.sets_firmware = firmware.has_value();
  s.moves_grip = grip.has_value();
  s.firmware = firmware.value_or(FirmwareOptions{});
  s.grip = grip.value_or(GripScript{});
}

}  // namespace palpate::io

namespace palpate::cli {
namespace {

/// Checks rules between keys.
class ScriptCheck {
 public:
  ScriptCheck(const io::Places& places, io::Problems& problems)
      : places_(places), problems_(problems) {}

  void window(double start, double end, const std::string& table) {
    must(end > start, table + ".end", "= " + io::number_text(end) + " s; must be > start");
  }
  void fault(const LinkFault& fault, const std::string& table) {
    window(fault.start, fault.end, table);
    must(fault.leg <= 3, table + ".leg", "= " + std::to_string(fault.leg) + "; must be 1, 2 or 3");
    must(fault.kind != LinkFault::Kind::stuck_button || fault.buttons != Buttons{},
         table + ".button",
         "is missing; a stuck button must be " + io::choices_text<ButtonName>("or"));
  }
  void poses(const std::vector<GripScript::Pose>& poses) {
    for (std::size_t n = 1; n < poses.size(); ++n) {
      must(poses[n].time > poses[n - 1].time, "grip.pose[" + std::to_string(n) + "].time",
           "= " + io::number_text(poses[n].time) + " s; must be > that of the pose before");
    }
    for (std::size_t n = 0; n < poses.size(); ++n) {
      counts(poses[n].counts, "grip.pose[" + std::to_string(n) + "].counts");
    }
  }
  void counts(const std::array<int, 3>& counts, const std::string& key) {
    constexpr int most = std::numeric_limits<std::int16_t>::max();
    for (const int count : counts) {
      must(count >= -most - 1 && count <= most, key,
           "has " + std::to_string(count) + "; must be from -32768 to 32767");
    }
  }

 private:
  void must(bool holds, const std::string& key, const std::string& text) {
    if (!holds && !problems_.about(key)) { problems_.add(places_, key, key + " " + text); }
  }
  const io::Places& places_;
  io::Problems& problems_;
};

io::TomlDocument read_document(const std::filesystem::path& path,
                               const std::vector<std::string>& overrides, io::Problems& problems) {
  if (!path.empty()) { return io::read_toml(path, "a script", overrides, problems); }
  io::TomlDocument document;
  document.places.file = "no --script";
  for (const std::string& text : overrides) {
    io::apply_override(document.root, text, document.places, problems);
  }
  return document;
}

}  // namespace

FalconScript read_falcon_script(const std::filesystem::path& path,
                                const std::vector<std::string>& overrides) {
  io::Problems problems;
  const io::TomlDocument document = read_document(path, overrides, problems);
  FalconScript script;
  const auto nowhere = [](std::string_view) { return std::string{}; };
  io::TomlReader reader(document.root, "", document.places, problems, nowhere);
  io::fields(reader, script);
  reader.refuse_unknown_keys();
  ScriptCheck rules(document.places, problems);
  for (std::size_t n = 0; n < script.faults.faults.size(); ++n) {
    rules.fault(script.faults.faults[n], "fault[" + std::to_string(n) + "]");
  }
  for (std::size_t n = 0; n < script.grip.presses.size(); ++n) {
    const GripScript::Press& press = script.grip.presses[n];
    rules.window(press.start, press.end, "grip.press[" + std::to_string(n) + "]");
  }
  rules.poses(script.grip.poses);
  rules.counts(script.grip.power_on, "grip.power_on");
  problems.throw_if_any();
  return script;
}

}  // namespace palpate::cli

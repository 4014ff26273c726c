// SPDX-License-Identifier: MIT

#include "reports/cli/falcon_script.hpp"

#include <limits>

#include "fixtures/io/toml_file.hpp"

namespace palpate::cli {
namespace {

using namespace device::falcon;

enum class ButtonName { plus, forward, centre, minus };

struct FaultDraft {
  LinkFault fault{};
  std::optional<ButtonName> button{};
};

struct PressDraft {
  ButtonName button = ButtonName::centre;
  double start = 0.0;
  double end = std::numeric_limits<double>::infinity();
};

struct GripDraft {
  GripScript grip{};
  std::vector<PressDraft> presses{};
};

struct ScriptDraft {
  int seed = 1;
  std::optional<FirmwareOptions> firmware{};
  std::optional<GripDraft> grip{};
  std::vector<FaultDraft> faults{};
};

Buttons buttons_of(ButtonName name) {
  return {.plus = name == ButtonName::plus,
          .forward = name == ButtonName::forward,
          .centre = name == ButtonName::centre,
          .minus = name == ButtonName::minus};
}

}  // namespace
}  // namespace palpate::cli

namespace palpate {

using cli::ButtonName;
using device::falcon::LinkFault;

template <>
inline constexpr auto words<LinkFault::Kind> =
    std::to_array<WordOf<LinkFault::Kind>>({{"latency", LinkFault::Kind::latency},
                                            {"drop", LinkFault::Kind::drop},
                                            {"duplicate", LinkFault::Kind::duplicate},
                                            {"corrupt", LinkFault::Kind::corrupt},
                                            {"unplug", LinkFault::Kind::unplug},
                                            {"power-loss", LinkFault::Kind::power_loss},
                                            {"stuck-encoder", LinkFault::Kind::stuck_encoder},
                                            {"stuck-button", LinkFault::Kind::stuck_button}});
template <>
inline constexpr auto words<LinkFault::Direction> =
    std::to_array<WordOf<LinkFault::Direction>>({{"both", LinkFault::Direction::both},
                                                 {"to-device", LinkFault::Direction::to_device},
                                                 {"to-host", LinkFault::Direction::to_host}});
template <>
inline constexpr auto words<ButtonName> =
    std::to_array<WordOf<ButtonName>>({{"plus", ButtonName::plus},
                                       {"forward", ButtonName::forward},
                                       {"centre", ButtonName::centre},
                                       {"minus", ButtonName::minus}});

}  // namespace palpate

namespace palpate::io {

constexpr Key seconds{.unit = "s", .range = range::non_negative};

// Keys of a script, each listed once as in scene_keys.hpp; read by io::TomlReader.
template <class Visitor> void fields(Visitor& v, cli::FaultDraft& f) {
  v.value("kind", f.fault.kind, {.required = true});
  v.value("direction", f.fault.direction, {});
  v.value("probability", f.fault.probability, {.range = range::share});
  v.value("start", f.fault.start, seconds);
  v.value("end", f.fault.end, {.unit = "s", .range = range::positive});
  v.value("latency", f.fault.latency, seconds);
  v.value("jitter", f.fault.jitter, seconds);
  v.value("run", f.fault.run, {.range = range::at_least(1)});
  v.value("leg", f.fault.leg, {.range = range::at_least(1)});
  v.value("button", f.button, {});
}

template <class Visitor> void fields(Visitor& v, device::falcon::GripScript::Pose& p) {
  v.value("time", p.time, {.unit = "s", .range = range::non_negative, .required = true});
  v.value("counts", p.counts, {.required = true});
}

template <class Visitor> void fields(Visitor& v, cli::PressDraft& p) {
  v.value("button", p.button, {.required = true});
  v.value("start", p.start, seconds);
  v.value("end", p.end, {.unit = "s", .range = range::positive});
}

template <class Visitor> void fields(Visitor& v, cli::GripDraft& g) {
  v.value("homed", g.grip.homed, {});
  v.value("power_on", g.grip.power_on, {});
  v.list("pose", g.grip.poses);
  v.list("press", g.presses);
}

template <class Visitor> void fields(Visitor& v, device::falcon::FirmwareOptions& f) {
  v.value("watchdog", f.watchdog, {.unit = "s", .range = range::positive});
  v.value("load_silence", f.load_silence, {.unit = "s", .range = range::positive});
  v.value("loaded", f.loaded, {});
}

template <class Visitor> void fields(Visitor& v, cli::ScriptDraft& s) {
  v.value("seed", s.seed, {.range = range::non_negative});
  v.optional_table("firmware", s.firmware);
  v.optional_table("grip", s.grip);
  v.list("fault", s.faults);
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
  void fault(const FaultDraft& draft, const std::string& table) {
    window(draft.fault.start, draft.fault.end, table);
    must(draft.fault.leg <= 3, table + ".leg",
         "= " + std::to_string(draft.fault.leg) + "; must be 1, 2 or 3");
    must(draft.fault.kind != LinkFault::Kind::stuck_button || draft.button, table + ".button",
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

void check(const ScriptDraft& draft, const io::Places& places, io::Problems& problems) {
  ScriptCheck rules(places, problems);
  for (std::size_t n = 0; n < draft.faults.size(); ++n) {
    rules.fault(draft.faults[n], "fault[" + std::to_string(n) + "]");
  }
  if (!draft.grip) { return; }
  for (std::size_t n = 0; n < draft.grip->presses.size(); ++n) {
    const PressDraft& press = draft.grip->presses[n];
    rules.window(press.start, press.end, "grip.press[" + std::to_string(n) + "]");
  }
  rules.poses(draft.grip->grip.poses);
  rules.counts(draft.grip->grip.power_on, "grip.power_on");
}

FalconScript finished(const ScriptDraft& draft) {
  FalconScript script{.firmware = draft.firmware.value_or(FirmwareOptions{}),
                      .faults = {.seed = static_cast<std::uint64_t>(draft.seed)},
                      .sets_firmware = draft.firmware.has_value(),
                      .moves_grip = draft.grip.has_value()};
  for (FaultDraft each : draft.faults) {
    if (each.button) { each.fault.buttons = buttons_of(*each.button); }
    script.faults.faults.push_back(each.fault);
  }
  if (!draft.grip) { return script; }
  script.grip = draft.grip->grip;
  for (const PressDraft& press : draft.grip->presses) {
    script.grip.presses.push_back({buttons_of(press.button), press.start, press.end});
  }
  return script;
}

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
  ScriptDraft draft;
  const auto nowhere = [](std::string_view) { return std::string{}; };
  io::TomlReader reader(document.root, "", document.places, problems, nowhere);
  io::fields(reader, draft);
  reader.refuse_unknown_keys();
  check(draft, document.places, problems);
  problems.throw_if_any();
  return finished(draft);
}

}  // namespace palpate::cli

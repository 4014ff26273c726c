// SPDX-License-Identifier: MIT

#include "validation/subject/capabilities.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace palpate {

namespace {

/// In the order of the bits.
constexpr std::array<std::string_view, 15> capability_names{
    "springs",    "spring-damping", "fixed-nodes",        "initial-state", "loads",
    "gravity",    "state",          "set-state",          "energy",        "tool-needle",
    "tool-probe", "syringe",        "own-discretisation", "material-laws", "repeat"};

}  // namespace

std::string names_of(Capabilities bits) {
  std::string text;
  for (std::size_t n = 0; n < capability_names.size(); ++n) {
    if ((bits >> n & 1U) == 0) { continue; }
    text.append(text.empty() ? "" : " ").append(capability_names[n]);
  }
  return text;
}

Capabilities needs_of(const Scene& scene, const SpringNetwork& network) {
  if (scene.tissue.source == Source::oscillator) {
    throw CannotDo("an oscillator is not tissue; only the model has it");
  }
  if (scene.simulation.printed.any()) {
    throw CannotDo("only the model has the printed equations of the paper");
  }
  const auto changes = [](const Material& material) { return !material.changes.empty(); };
  if (std::ranges::any_of(scene.materials, changes)) {
    throw CannotDo("only the model changes materials during a run");
  }
  if (scene.probe && (scene.probe->face != Probe::FaceKind::rigid || scene.probe->tip_radius)) {
    throw CannotDo("only the model has probes with probe.face = \"uniform\" or probe.tip_radius");
  }
  Capabilities needs = 0;
  const auto add = [&](bool needed, Capabilities bit) { needs |= needed ? bit : 0; };
  add(!network.springs.empty(), PALPATE_CAN_SPRINGS);
  add(is_damped(network.springs), PALPATE_CAN_SPRING_DAMPING);
  add(std::ranges::count(network.fixed, 1) > 0, PALPATE_CAN_FIXED_NODES);
  add(network.initial_velocity.cols() > 0 || network.initial_displacement.cols() > 0,
      PALPATE_CAN_INITIAL_STATE);
  add(!scene.loads.empty(), PALPATE_CAN_LOADS);
  add(!scene.tissue.gravity.isZero(0.0), PALPATE_CAN_GRAVITY);
  add(scene.needle.has_value(), PALPATE_CAN_NEEDLE);
  add(scene.probe.has_value(), PALPATE_CAN_PROBE);
  add(scene.syringe.has_value(), PALPATE_CAN_SYRINGE);
  add(has_volume_terms(network) || !network.laws.empty(), PALPATE_CAN_MATERIAL_LAWS);
  return needs;
}

Capabilities missing(Capabilities capabilities, const Scene& scene, Capabilities needs) {
  const bool layers =
      scene.tissue.source == Source::layers || scene.tissue.source == Source::lattice;
  const bool own = (capabilities & PALPATE_CAN_OWN_DISCRETISATION) != 0 && layers &&
                   (scene.needle || scene.probe);
  if (own) {
    needs &= ~(PALPATE_CAN_SPRINGS | PALPATE_CAN_SPRING_DAMPING | PALPATE_CAN_FIXED_NODES |
               PALPATE_CAN_MATERIAL_LAWS);
  }
  return needs & ~capabilities;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/stepping/tool_contact.hpp"

namespace palpate {

Coupling coupling_of(const Scene& scene, const Drive& drive) {
  if (drive.kind == Drive::Kind::force) { return {.viscosity = drive.hand_viscosity}; }
  if (!drive.is_coupled()) { return {}; }
  const FalconDrive falcon = scene.falcon.value_or(FalconDrive{});
  return {falcon.coupling_stiffness, falcon.coupling_viscosity};
}

std::string_view name_of(ToolEvent event) {
  switch (event) {
    case ToolEvent::contact: return "contact";
    case ToolEvent::puncture: return "puncture";
    case ToolEvent::loss_of_resistance: return "loss-of-resistance";
    case ToolEvent::bone: return "bone";
    case ToolEvent::dural_puncture: return "dural-puncture";
    case ToolEvent::withdrawn: break;
  }
  return "withdrawn";
}

ToolState::ToolState(const Scene& scene, const SpringNetwork& network) : path_(scene, network) {
  if (scene.syringe) { syringe_.emplace(*scene.syringe); }
  if (path_.sliding_face()) { sliding_ = scene.probe; }
  centre_ = path_.origin().head<2>();
}

std::vector<Column> tool_columns(const Scene& scene) {
  std::vector<Column> columns;
  const auto add = [&](const char* name, const char* unit) { columns.push_back({name, unit, {}}); };
  add("tool.depth_m", "m");
  for (const char* name : {"tool.force_n", "tool.cutting_n", "tool.friction_n", "tool.stiffness_n",
                           "tool.applied_n"}) {
    add(name, "N");
  }
  if (scene.syringe) {
    add("syringe.pressure_pa", "Pa");
    add("syringe.thumb_n", "N");
  }
  add("tool.insertion_m", "m");
  add("tool.cut_m", "m");
  add("tool.lateral_n", "N");
  if (scene.probe && scene.probe->path) {
    add("probe.x_m", "m");
    add("probe.y_m", "m");
  }
  return columns;
}

void ToolState::sample(std::span<double> row) const noexcept {
  const ToolForces f = forces();
  std::size_t column = 0;
  for (const double value :
       {place_ * path_.direction().z(), f.total, f.cutting, f.friction, f.stiffness, f.applied}) {
    row[column++] = value;
  }
  if (syringe_) {
    row[column++] = syringe_->pressure();
    row[column++] = syringe_->thumb();
  }
  for (const double value : {place_, in_tissue() ? cut_ : 0.0, f.lateral}) {
    row[column++] = value;
  }
  if (sliding_) {
    row[column++] = centre_.x();
    row[column++] = centre_.y();
  }
}

void ToolState::sample_text(std::span<std::string> row, std::vector<Event>& events) {
  row[0] = in_tissue() ? interval().label : "";
  row[1].clear();
  for (const ToolHappening& happening : happenings()) {
    const std::string name(name_of(happening.event));
    row[1] += (row[1].empty() ? "" : ";") + name;
    events.push_back({happening.time, name, path_.intervals()[happening.interval].label});
  }
  clear_happenings();
}

void ToolState::happen(double t, ToolEvent event, std::size_t interval) noexcept {
  if (happening_count_ < happenings_.size()) {
    happenings_[happening_count_++] = {t, event, interval};
  }
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/stepping/tool_system.hpp"

#include <cmath>

namespace palpate {

namespace {

/// Maximum number of repetitions of a step that violates the contact laws of tip or shaft.
constexpr int most_revisions = 6;

}  // namespace

template <class Real>
ToolRun<Real>::ToolRun(const Scene& scene, const NetworkProblem& problem,
                       NetworkSystem<Real>& tissue, bool implicit)
    : tissue_(tissue),
      contact_(scene, problem, tissue.layout()),
      system_(tissue, contact_),
      implicit_(implicit),
      audit_(scene.output.audit) {
  if (scene.syringe) { syringe_.emplace(*scene.syringe); }
  scratch_.setZero(system_.dof());
}

template <class Real> void ToolRun<Real>::begin(State<Real>& state) {
  if (contact_.is_coordinate()) {
    const Eigen::Index last = state.position.size();
    state.position.conservativeResize(last + 1);
    state.velocity.conservativeResize(last + 1);
    state.position(last) = static_cast<Real>(contact_.initial_place());
    state.velocity(last) = Real(0);
  }
  contact_.begin(state);
  if (implicit_) { before_ = state; }
}

template <class Real>
void ToolRun<Real>::step(Integrator<Real>& integrator, State<Real>& state, double t,
                         double h) noexcept {
  if (contact_.begin_step(t, h, state, implicit_)) { system_.forget(); }
  const double before = audit_ ? damping_power(state) : 0.0;
  if (implicit_) { before_ = state; }
  integrator.step(system_, state, t, h);
  for (int n = 0; implicit_ && n < most_revisions && contact_.update_active_set(state); ++n) {
    state = before_;
    integrator.step(system_, state, t, h);
  }
  if (audit_) { damped_ += 0.5 * h * (before + damping_power(state)); }
  contact_.end_step(t + h, state);
  if (syringe_) { syringe_->advance(h, contact_.in_tissue(), contact_.interval().role); }
}

template <class Real>
double ToolRun<Real>::measure(double t, double gate, const State<Real>& state,
                              const Vector<Real>& velocity) noexcept {
  return system_.measure(t, gate, state.position, velocity, scratch_);
}

/// Returns the power dissipated by the tissue's dampers [W].
template <class Real> double ToolRun<Real>::damping_power(const State<Real>& state) noexcept {
  tissue_.damping(state.position, state.velocity, scratch_);
  const Eigen::Index n = tissue_.layout().size;
  return std::abs(static_cast<double>(scratch_.head(n).dot(state.velocity.head(n))));
}

template <class Real> std::vector<Column> ToolRun<Real>::columns() const {
  std::vector<Column> columns;
  const auto add = [&](const char* name, const char* unit) { columns.push_back({name, unit, {}}); };
  add("tool.depth_m", "m");
  for (const char* name : {"tool.force_n", "tool.cutting_n", "tool.friction_n", "tool.stiffness_n",
                           "tool.applied_n"}) {
    add(name, "N");
  }
  if (syringe_) {
    add("syringe.pressure_pa", "Pa");
    add("syringe.thumb_n", "N");
  }
  add("tool.insertion_m", "m");
  add("tool.cut_m", "m");
  add("tool.lateral_n", "N");
  return columns;
}

template <class Real> std::vector<TextColumn> ToolRun<Real>::text_columns() {
  return {{"tool.layer", {}}, {"tool.event", {}}};
}

template <class Real> void ToolRun<Real>::sample(std::span<double> row) const noexcept {
  const ToolForces& f = contact_.forces();
  std::size_t place = 0;
  for (const double value : {contact_.place() * contact_.path().direction().z(), f.total, f.cutting,
                             f.friction, f.stiffness, f.applied}) {
    row[place++] = value;
  }
  if (syringe_) {
    row[place++] = syringe_->pressure();
    row[place++] = syringe_->thumb();
  }
  row[place++] = contact_.place();
  row[place++] = contact_.in_tissue() ? contact_.cut() : 0.0;
  row[place++] = f.lateral;
}

template <class Real>
void ToolRun<Real>::sample_text(std::span<std::string> row, std::vector<Event>& events) {
  row[0] = contact_.in_tissue() ? contact_.interval().label : "";
  row[1].clear();
  for (const ToolHappening& happening : contact_.happenings()) {
    const std::string name(name_of(happening.event));
    row[1] += (row[1].empty() ? "" : ";") + name;
    events.push_back({happening.time, name, contact_.path().intervals()[happening.interval].label});
  }
  contact_.clear_happenings();
}

template <class Real> ToolReport ToolRun<Real>::report() const noexcept {
  ToolLosses losses = contact_.losses();
  losses.damping = damped_;
  return {contact_.place(), contact_.velocity(), contact_.depth(),  contact_.cut(),
          contact_.slip(),  contact_.mass(),     contact_.forces(), losses};
}

template <class Real> double ToolRun<Real>::kinetic_energy() const noexcept {
  return contact_.is_coordinate()
             ? 0.5 * contact_.mass() * contact_.velocity() * contact_.velocity()
             : 0.0;
}

template <class Real> std::size_t ToolRun<Real>::memory_bytes() const noexcept {
  return system_.memory_bytes() + bytes_of(before_.position, before_.velocity, scratch_);
}

template class ToolRun<double>;
template class ToolRun<float>;

}  // namespace palpate

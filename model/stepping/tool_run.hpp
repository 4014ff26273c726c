// SPDX-License-Identifier: MIT
#pragma once
/// A needle or a probe in a run: its contact with the tissue, its syringe, and what is recorded of them.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/dynamics/scene.hpp"
#include "model/dynamics/syringe.hpp"
#include "model/dynamics/trace.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/tool_contact.hpp"
#include "model/stepping/tool_report.hpp"
#include "model/stepping/tool_system.hpp"

namespace palpate {

template <class Real>
class ToolRun {
 public:
  /// The scene has a needle or a probe; `tissue` outlives this. An `implicit` scheme's steps may be taken again.
  ToolRun(const Scene& scene, const NetworkProblem& problem, NetworkSystem<Real>& tissue, bool implicit);
  ToolRun(const ToolRun&) = delete;
  ToolRun& operator=(const ToolRun&) = delete;

  /// The tissue's first state, to which a tool that is a coordinate adds its own.
  void begin(State<Real>& state);
  /// The tissue with the tool in it.
  [[nodiscard]] System<Real>& system() noexcept { return system_; }
  /// From t to t + h [s]. Steps are taken again while tip or shaft broke their laws in them.
  void step(Integrator<Real>& integrator, State<Real>& state, double t, double h) noexcept;
  /// Forces of a state, not of the last stage of a step: what a tick is there for. Returns the springs' energy [J].
  double measure(double t, double gate, const State<Real>& state, const Vector<Real>& velocity) noexcept;

  /// Beside those of the tissue, in the order of sample() and sample_text().
  [[nodiscard]] std::vector<Column> columns() const;
  [[nodiscard]] static std::vector<TextColumn> text_columns();
  void sample(std::span<double> row) const noexcept;
  /// The layer and what happened since the last call, which goes to `events` too.
  void sample_text(std::span<std::string> row, std::vector<Event>& events);
  [[nodiscard]] ToolReport report() const noexcept;
  [[nodiscard]] ToolMotion motion() const noexcept { return {contact_.place(), contact_.velocity()}; }
  [[nodiscard]] double kinetic_energy() const noexcept;  ///< [J]; none where its trajectory is prescribed
  void move_handle(double place, double velocity) noexcept { contact_.move_handle(place, velocity); }
  [[nodiscard]] std::span<const ToolHappening> happenings() const noexcept { return contact_.happenings(); }
  void forget_happenings() noexcept { contact_.clear_happenings(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  [[nodiscard]] double damping_power(const State<Real>& state) noexcept;

  NetworkSystem<Real>& tissue_;
  ToolContact<Real> contact_;
  ToolSystem<Real> system_;
  std::optional<SyringePressure> syringe_;
  bool implicit_;
  bool audit_;
  double damped_ = 0.0;  ///< [J]
  State<Real> before_;   ///< the step that may be taken again
  Vector<Real> scratch_;
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Insertion of a tool into a tissue as a hybrid differential equation, smooth between events
/// (model/EQUATIONS.md, "Needle tip", "Shaft friction", "Lateral lock", "Tool forces"). CVODE
/// locates events by root finding. It shares no code with the model's integration or its needle.

#include <vector>

#include "model/problem/scene.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

/// Checks of the solver itself.
struct InsertionChecks {
  std::vector<double> event_depth{};  ///< xi of the tip in undeformed tissue, one per event [m]
  double largest_drift = 0.0;  ///< largest position error of a constraint between two restarts [m]
  double largest_slip = 0.0;  ///< largest velocity error of a constraint between two restarts [m/s]
};

struct InsertionOptions {
  enum class Account { forces, energy } account = Account::forces;  ///< energy halves the speed
  /// Response of a sticking shaft to a jump of the tool's speed. With `slips` its force is bounded,
  /// so that it slips; with `plastic` it receives an impulse like the stuck tip.
  enum class ShaftImpact { slips, plastic } shaft_impact = ShaftImpact::slips;
  double longest_step = 1e-3;  ///< largest step between event checks [s]
  long event_limit = 200'000;
};

/// Returns the solution with the columns of a run, and tool.velocity_m_per_s (s'), tool.tip_depth_m
/// (xi in undeformed tissue; xi_0 while the tip is outside) and tool.deepest_cut_m (d; xi_0 before
/// the first cut). Forces are on the needle along n, against its insertion (Eq. 2). Lateral forces
/// are tool.lateral_{x,y,z}_n. The energy balance since t = 0 is, without loads, energy_j +
/// loss.*_j = energy_j(0) + loss.hand_j, where energy_j is stored in tissue, tool and grip.
/// loss.damping_j needs InsertionOptions::Account::energy. Relaxing tissue and creeping friction
/// have no balance of energy, and then no such column.
///
/// Events have the kinds of a run ("contact", "puncture", "loss-of-resistance", "dural-puncture":
/// the first of a layer) and "cut-resumed" (in a layer that was cut before), "stopped" (the cutting
/// tip sticks), "released" (the stuck tip leaves the end of its track), "returned" (to that end),
/// "withdrawn" (from the skin), "knot-passed", "knot-let-go" (of the lateral lock), "shaft-sticks",
/// "shaft-slips", "bone-contact" and "bone-left". Their detail is the layer.
///
/// `times` [s] ascend from 0. At an event or a jump, an instant holds the
/// state just before it; at 0, the state just after. For soft tissue only (functional iteration).
/// Throws SolverError if CVODE fails, if the tool begins inside the tissue, if modes do not settle,
/// at more than event_limit events, or if Account::energy is asked for without a balance of energy.
Trace solve_insertion(const Scene& scene, const SpringNetwork& network,
                      const std::vector<double>& times, const Tolerance& tolerance,
                      const InsertionOptions& options = {}, InsertionChecks* checks = nullptr);

}  // namespace palpate::reference

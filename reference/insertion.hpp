// SPDX-License-Identifier: MIT
#pragma once
/// Insertion of a tool into a tissue as a hybrid differential equation, smooth between events
/// (model/EQUATIONS.md, "Needle tip", "Shaft friction", "Lateral lock", "Tool forces"). CVODE
/// locates events by root finding. It shares no code with the model's integration or its needle.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

struct InsertionEvent {
  enum class Kind {
    contact,             ///< the tip reaches the skin
    puncture,            ///< first puncture of a layer
    loss_of_resistance,  ///< first puncture of the epidural space
    dural_puncture,      ///< first puncture of dura
    cut_resumed,         ///< cutting again in a layer that was punctured before
    stopped,             ///< the cutting tip sticks
    released,            ///< the stuck tip leaves the end of its track
    returned,            ///< the tip reaches the end of its track again
    withdrawn,           ///< the tip leaves the skin
    knot_passed,
    knot_let_go,
    shaft_sticks,
    shaft_slips,
    bone_contact,
    bone_left
  };
  Kind kind = Kind::contact;
  double time = 0.0;   ///< [s]
  double place = 0.0;  ///< position s of the tip [m]
  double depth = 0.0;  ///< xi of the tip in undeformed tissue [m]
  std::string layer{};
};

/// Energy balance since t = 0 [J]. Without loads: stored(t) + dampers + friction + cutting +
/// impacts = stored(0) + hand.
struct InsertionEnergy {
  double hand = 0.0;      ///< work of the hand
  double dampers = 0.0;   ///< only with InsertionOptions::Account::energy
  double friction = 0.0;  ///< of the shaft
  double cutting = 0.0;
  double impacts = 0.0;  ///< of tip, locked contact points, and bone
  double stored = 0.0;   ///< in tissue, tool and grip: elastic, kinetic, potential
};

/// State and forces at one instant. Forces are on the needle along n, against its insertion (Eq.
/// 2).
struct InsertionInstant {
  double time = 0.0;       ///< [s]
  double place = 0.0;      ///< s [m]
  double velocity = 0.0;   ///< s' [m/s]
  double cut = 0.0;        ///< d [m]; xi_0 before the first cut
  double depth = 0.0;      ///< xi of the tip in undeformed tissue [m]; xi_0 while it is outside
  double total = 0.0;      ///< F_r [N]
  double cutting = 0.0;    ///< F_c [N]
  double friction = 0.0;   ///< F_f [N]
  double stiffness = 0.0;  ///< F_s [N]
  double applied = 0.0;    ///< F_applied [N]
  Eigen::Vector3d lateral{0.0, 0.0, 0.0};  ///< force on the needle across n [N]
  Eigen::VectorXd position{};              ///< q of the free nodes, as in NetworkProblem [m]
  Eigen::VectorXd velocities{};            ///< [m/s]
  InsertionEnergy energy{};
};

struct InsertionOptions {
  enum class Account { forces, energy } account = Account::forces;  ///< energy halves the speed
  /// Response of a sticking shaft to a jump of the tool's speed. With `slips` its force is bounded,
  /// so that it slips; with `plastic` it receives an impulse like the stuck tip.
  enum class ShaftImpact { slips, plastic } shaft_impact = ShaftImpact::slips;
  double longest_step = 1e-3;  ///< largest step between event checks [s]
  long event_limit = 200'000;
};

struct Insertion {
  std::string version{};  ///< "SUNDIALS 6.4.1"
  std::vector<InsertionInstant> instants{};
  std::vector<InsertionEvent> events{};  ///< in order of time
  long steps = 0;
  long evaluations = 0;
  double seconds = 0.0;        ///< wall time
  double largest_drift = 0.0;  ///< largest position error of a constraint between two restarts [m]
  double largest_slip = 0.0;  ///< largest velocity error of a constraint between two restarts [m/s]
};

/// Solves an insertion. `times` [s] ascend from 0. At an event or a jump, an instant holds the
/// state just before it; at 0, the state just after. For soft tissue only (functional iteration).
/// Throws SolverError if CVODE fails, if the tool begins inside the tissue, if modes do not settle,
/// or at more than event_limit events.
Insertion solve_insertion(const Scene& scene, const SpringNetwork& network,
                          const std::vector<double>& times, const Tolerance& tolerance,
                          const InsertionOptions& options = {});

}  // namespace palpate::reference

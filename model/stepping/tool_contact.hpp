// SPDX-License-Identifier: MIT
#pragma once
/// Needle or probe in contact with a network: modes of tip and shaft, the forces that they exchange
/// with the nodes, and the changes of mode between two steps (model/EQUATIONS.md, "Needle tip",
/// "Shaft friction", "Lateral lock", "Tool forces"). Everything is allocated on construction.

#include <array>
#include <span>
#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/tool.hpp"
#include "model/stepping/constraint_compliance.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate {

/// Spring and damper between the hand, or what it holds, and a tool that is a coordinate.
struct Coupling {
  double stiffness = 0.0;  ///< [N/m]
  double viscosity = 0.0;  ///< [N s/m]
};

template <class Real> class ToolContact {
 public:
  ToolContact(const Scene& scene, const NetworkProblem& problem, const NodeLayout& layout);

  /// Under an applied force the tool is one more coordinate, after those of the network.
  [[nodiscard]] bool is_coordinate() const { return tool_ >= 0; }
  [[nodiscard]] double mass() const { return mass_; }
  [[nodiscard]] const Coupling& coupling() const { return coupling_; }
  /// Where the hand holds the far end of the coupling from now on, s [m] and s' [m/s].
  void move_handle(double place, double velocity) noexcept {
    handle_place_ = place;
    handle_velocity_ = velocity;
  }
  [[nodiscard]] double initial_place() const { return start_place_; }
  /// The state at t = 0: a tip that begins on the skin is in contact from then on.
  void begin(const State<Real>& state) noexcept;

  /// Before a step from t to t + h: where the trajectory goes in it; sticking parts keep up with a
  /// jump of its speed. `predict` moves the depth on linearly instead of with the state. Returns
  /// whether the state changed.
  bool begin_step(double t, double h, State<Real>& state, bool predict) noexcept;
  /// Adds what tool and tissue do to each other to the forces f of a state.
  void apply(double t, const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept;
  /// product = A x of the free Jacobian becomes that of the Jacobian with what sticks held.
  void hold(const Vector<Real>& x, const Vector<Real>& mass, Vector<Real>& product) noexcept;
  /// The same for a preconditioner; learn_compliance() allocates.
  void learn_compliance(Eigen::Index dof, const typename ConstraintCompliance<Real>::Solve& solve);
  void begin_linear_solve() noexcept;
  void constrain_solution(const Vector<Real>& r, Vector<Real>& solution) const noexcept {
    held_.correct(r, solution);
  }
  /// After an implicit step: false if tip and shaft kept to their laws in it. Else they now do what
  /// the law they broke says, and the step is to be taken again (model/EQUATIONS.md, "Held
  /// constraints").
  bool update_active_set(const State<Real>& state) noexcept;
  /// After a step that ended at t: changes of mode, and no drift where something sticks.
  void end_step(double t, State<Real>& state) noexcept;

  [[nodiscard]] const NeedlePath& path() const { return path_; }
  [[nodiscard]] const ToolForces& forces() const { return forces_; }  ///< of the last apply()
  [[nodiscard]] double place() const { return place_; }               ///< s [m]
  [[nodiscard]] double velocity() const { return velocity_; }         ///< s' [m/s]
  [[nodiscard]] double depth() const { return depth_; }  ///< of the tip in undeformed tissue [m]
  [[nodiscard]] double cut() const { return cut_; }      ///< deepest ever cut [m]
  [[nodiscard]] double slip() const { return slip_; }    ///< of the shaft [m/s]
  [[nodiscard]] TipMode tip() const { return tip_; }
  [[nodiscard]] ShaftMode shaft() const { return shaft_; }
  [[nodiscard]] bool in_tissue() const { return tip_ != TipMode::outside; }
  [[nodiscard]] const PathInterval& interval() const {
    return path_.intervals()[path_.interval_at(depth_)];
  }
  [[nodiscard]] const ToolLosses& losses() const { return losses_; }
  /// What happened since the last clear_happenings(); never more than fits.
  [[nodiscard]] std::span<const ToolHappening> happenings() const {
    return {happenings_.data(), happening_count_};
  }
  void clear_happenings() { happening_count_ = 0; }

 private:
  using Support = typename ConstraintCompliance<Real>::Support;
  struct Knot {
    std::size_t first;
    std::size_t count;
    double depth;         ///< xi_k
    double held;          ///< part of n.sum w x of fixed nodes, minus n.sum w X of all
    double mobility;      ///< G_k
    double displacement;  ///< U_k
    double velocity;      ///< V_k
    double acceleration;  ///< of the free nodes under all but the contact
  };
  /// What tip and shaft share of the network, and what they take.
  struct Contact {
    double tip_tip = 0.0;  ///< Gram entries with the tool's own 1/m [1/kg]
    double tip_shaft = 0.0;
    double shaft_shaft = 0.0;
    bool tip_held = false;  ///< its constraint carries the force
    bool shaft_held = false;
  };

  /// The drive's trajectory through a step; whether the state changed.
  bool follow(double t, double h, State<Real>& state) noexcept;
  void gather(const Vector<Real>& q, const Vector<Real>& v) noexcept;
  void place_tool(double t, const Vector<Real>& q, const Vector<Real>& v) noexcept;
  /// xi of the material at place s of the line; below the first knot's depth: outside.
  [[nodiscard]] double depth_at(double s) const noexcept;
  [[nodiscard]] double displacement_at(NeedlePath::Place at) const noexcept;
  [[nodiscard]] double velocity_at(NeedlePath::Place at) const noexcept;
  void weigh() noexcept;  ///< shares and Gram entries at the present depth
  void solve(double tool_acceleration) noexcept;
  void take_tip(double needed) noexcept;
  void take_shaft(double needed) noexcept;
  [[nodiscard]] bool may_hold_shaft() const noexcept;
  void push(std::size_t knot, double force, Vector<Real>& f) const noexcept;
  [[nodiscard]] bool is_locked(const Knot& knot) const noexcept;
  /// Share of the tip's and the shaft's force that falls to a knot.
  [[nodiscard]] double tip_share(std::size_t knot) const noexcept;
  /// Impulses or forces (tip, shaft) that bring the given differences of what is held to zero.
  [[nodiscard]] Eigen::Vector2d solve_contact_forces(double tip, double shaft, bool tip_held,
                                                     bool shaft_held) const noexcept;
  void match_velocities(State<Real>& state) noexcept;
  void match_positions(State<Real>& state) noexcept;
  void account(double h) noexcept;
  void meet_bone(double t, State<Real>& state) noexcept;
  void change_modes(double t, const Contact& held) noexcept;
  [[nodiscard]] double depth_rate() const noexcept;
  void change_tip(double t) noexcept;
  /// From one mode; `here`: depth of the place where the tip is.
  void change_outside(double here, double t) noexcept;
  void change_in_track(double here, double t) noexcept;
  void change_stuck(double t) noexcept;
  void change_cutting(double here, double t) noexcept;
  void leave(double t) noexcept;
  /// What a step's solution may be off the laws of tip and shaft without breaking them.
  struct Slack {
    double velocity = 0.0;  ///< [m/s]
    double tip = 0.0;       ///< [N]
    double shaft = 0.0;     ///< [N]
  };
  [[nodiscard]] Slack slack() const noexcept;
  void predict_cutting() noexcept;
  bool update_tip(double rate, const Slack& slack) noexcept;
  bool update_shaft(double slip, const Slack& slack) noexcept;
  void change_shaft() noexcept;
  void turn_shaft(double h) noexcept;
  [[nodiscard]] double slip_now() const noexcept;
  void enter(std::size_t interval, double t) noexcept;
  /// What cutting and rubbing take at this instant [W].
  [[nodiscard]] Eigen::Vector2d dissipated_power() const noexcept;
  void happen(double t, ToolEvent event, std::size_t interval) noexcept;
  /// F_c that the tip meets; its interval changes only between steps.
  [[nodiscard]] double cutting_force() const noexcept {
    return path_.intervals()[path_.interval_at(cut_)].cutting_force;
  }
  [[nodiscard]] double tool_mobility() const noexcept;
  /// On a tool that is a coordinate [N].
  [[nodiscard]] double hand(double t) const noexcept;

  NeedlePath path_;
  Drive drive_;
  Trajectory trajectory_;
  bool needle_ = true;
  Eigen::Index tool_ = -1;  ///< its coordinate
  Eigen::Index stride_;     ///< between those of a node
  double mass_ = 0.0;
  Coupling coupling_{};
  double start_place_ = 0.0;
  Eigen::Vector3d n_;
  std::array<Eigen::Vector3d, 2> across_;  ///< unit vectors square to n and each other

  std::vector<Support> supports_;
  std::vector<Knot> knots_;
  ConstraintCompliance<Real> held_{};  ///< only implicit schemes ask for it
  std::vector<double> shaft_share_;    ///< l_k / L
  double limit_ = 0.0;                 ///< L [N]
  NeedlePath::Place at_{};             ///< of the tip between the knots
  Contact contact_{};

  TipMode tip_ = TipMode::outside;
  ShaftMode shaft_ = ShaftMode::stick;
  bool at_bone_ = false;
  bool bone_seen_ = false;
  bool clear_ = true;     ///< off the skin by more than a rebound
  bool present_ = false;  ///< contact was told, and no withdrawal since
  double place_ = 0.0;
  double velocity_ = 0.0;
  double depth_ = 0.0;
  double cut_ = 0.0;
  double slip_ = 0.0;
  double tip_force_ = 0.0;    ///< T
  double shaft_force_ = 0.0;  ///< F_f
  double bone_force_ = 0.0;
  std::size_t deepest_ = 0;  ///< interval that was entered last
  bool entered_ = false;     ///< any interval at all

  double tolerance_ = 0.0;  ///< of the solver, relative
  double step_begin_ = 0.0;
  double step_length_ = 0.0;
  double step_tip_force_ = 0.0;  ///< T over the last implicit step [N]
  double step_tip_change_ =
      0.0;                ///< and what it grew by since the one before, if the tip stuck in both
  double stopped_ = 0.0;  ///< velocity against the tissue that a tip had that begins to stick [m/s]
  bool stuck_before_ = false;
  double place_begin_ = 0.0;
  double handle_place_ = 0.0;
  double handle_velocity_ = 0.0;
  bool predict_ = false;
  double depth_begin_ = 0.0;
  double depth_rate_ = 0.0;
  Eigen::Vector2d lag_{0.0,
                       0.0};  ///< what tip and shaft must lose in an implicit step to stick [m/s^2]
  Eigen::Vector2d dissipated_power_begin_{0.0, 0.0};
  bool first_evaluation_ = false;
  double hand_power_begin_ = 0.0;
  double hand_power_end_ = 0.0;

  Eigen::Vector3d sideways_{0.0, 0.0, 0.0};  ///< of the tissue on the needle [N]
  ToolForces forces_{};
  ToolLosses losses_{};
  std::array<ToolHappening, 32> happenings_{};
  std::size_t happening_count_ = 0;
};

}  // namespace palpate

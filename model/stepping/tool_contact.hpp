// SPDX-License-Identifier: MIT
#pragma once
/// Contact of a needle or probe with a network: modes of tip and shaft, contact forces on the
/// nodes, and mode changes between two steps (model/EQUATIONS.md, "Needle tip", "Shaft friction",
/// "Lateral lock", "Tool forces"). The constructor allocates all memory.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/tool.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/constraint_compliance.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate {

/// Spring and damper between the hand, or the device that it holds, and a tool with a coordinate.
struct Coupling {
  double stiffness = 0.0;  ///< [N/m]
  double viscosity = 0.0;  ///< [N s/m]
};

/// Position, modes, forces and events of a tool, without reference to the tissue's coordinates.
class ToolState {
 public:
  explicit ToolState(const Scene& scene, const SpringNetwork& network);

  /// Sets the hand's end of the coupling: position s [m] and velocity s' [m/s].
  void move_handle(double place, double velocity) noexcept {
    handle_place_ = place;
    handle_velocity_ = velocity;
  }
  [[nodiscard]] ToolMotion motion() const noexcept { return {place_, velocity_}; }
  [[nodiscard]] ToolReport report() const noexcept {
    return {place_, velocity_, depth_, cut_, slip_, mass_, forces_, losses_};
  }
  /// Energy of a tool with a coordinate [J]; zero under a prescribed trajectory.
  [[nodiscard]] double kinetic_energy() const noexcept {
    return 0.5 * mass_ * velocity_ * velocity_;
  }
  /// Adds energy that the tissue's dampers dissipated [J].
  void add_damping_loss(double energy) noexcept { losses_.damping += energy; }

  /// Columns of sample() and sample_text(), in the same order.
  [[nodiscard]] std::vector<Column> columns() const;
  void sample(std::span<double> row) const noexcept;
  [[nodiscard]] static std::vector<TextColumn> text_columns() {
    return {{"tool.layer", {}}, {"tool.event", {}}};
  }
  /// Writes the layer and the events since the last call, and appends the events to `events`.
  void sample_text(std::span<std::string> row, std::vector<Event>& events);
  /// Events since the last clear_happenings(); events beyond the capacity are dropped.
  [[nodiscard]] std::span<const ToolHappening> happenings() const {
    return {happenings_.data(), happening_count_};
  }
  void clear_happenings() { happening_count_ = 0; }

 protected:
  [[nodiscard]] bool in_tissue() const { return tip_ != TipMode::outside; }
  [[nodiscard]] const PathInterval& interval() const {
    return path_.intervals()[path_.interval_at(depth_)];
  }
  void happen(double t, ToolEvent event, std::size_t interval) noexcept;

  NeedlePath path_;
  std::optional<SyringePressure> syringe_{};
  TipMode tip_ = TipMode::outside;
  double mass_ = 0.0;      ///< [kg]; zero under a prescribed trajectory
  double place_ = 0.0;     ///< s [m]
  double velocity_ = 0.0;  ///< s' [m/s]
  double depth_ = 0.0;     ///< of the tip, in undeformed tissue [m]
  double cut_ = 0.0;       ///< largest cut depth so far [m]
  double slip_ = 0.0;      ///< sliding velocity of the shaft [m/s]
  double handle_place_ = 0.0;
  double handle_velocity_ = 0.0;
  ToolForces forces_{};  ///< of the last apply()
  ToolLosses losses_{};

 private:
  std::array<ToolHappening, 32> happenings_{};
  std::size_t happening_count_ = 0;
};

template <class Real> class ToolContact : public ToolState {
 public:
  ToolContact(const Scene& scene, const NetworkProblem& problem, const NodeLayout& layout);

  /// Returns true under an applied force: the tool then has a coordinate, after those of the
  /// network.
  [[nodiscard]] bool is_coordinate() const { return tool_ >= 0; }
  [[nodiscard]] double mass() const { return mass_; }
  [[nodiscard]] const Coupling& coupling() const { return coupling_; }
  /// Initialises the contact at t = 0 and adds the tool's coordinate to the state. A tip that
  /// begins on the skin is in contact.
  void begin(State<Real>& state);

  /// Evaluates the trajectory for a step from t to t + h. Sticking parts follow a jump of its
  /// velocity. With `predict` the depth is extrapolated linearly and not taken from the state.
  /// Returns true if it changed the state.
  bool begin_step(double t, double h, State<Real>& state, bool predict) noexcept;
  /// Adds the contact forces between tool and tissue to the forces f of a state.
  void apply(double t, const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept;
  /// Changes product = A x of the unconstrained Jacobian to the product with the constrained
  /// Jacobian.
  void hold(const Vector<Real>& x, const Vector<Real>& mass, Vector<Real>& product) noexcept;
  /// Computes the constraint compliance for a preconditioner; allocates.
  void learn_compliance(Eigen::Index dof, const typename ConstraintCompliance<Real>::Solve& solve);
  void begin_linear_solve() noexcept;
  void constrain_solution(const Vector<Real>& r, Vector<Real>& solution) const noexcept {
    held_.correct(r, solution);
  }
  /// Checks the contact laws after an implicit step. Returns true if tip and shaft satisfied them.
  /// Otherwise it changes their active constraints and the caller must repeat the step
  /// (model/EQUATIONS.md, "Held constraints").
  bool update_active_set(const State<Real>& state) noexcept;
  /// Updates the modes after a step that ended at t and removes the drift of sticking parts.
  void end_step(double t, State<Real>& state) noexcept;

 private:
  using Support = typename ConstraintCompliance<Real>::Support;
  struct Knot {
    std::size_t first;
    std::size_t count;
    double depth;         ///< xi_k
    double held;          ///< part of n.sum w x from fixed nodes, minus n.sum w X of all nodes
    double mobility;      ///< G_k
    double displacement;  ///< U_k
    double velocity;      ///< V_k
    double acceleration;  ///< of the free supports, without the contact force
  };
  /// Coupling of tip and shaft with the network, and their forces.
  struct Contact {
    double tip_tip = 0.0;  ///< Gram entries including the tool's 1/m [1/kg]
    double tip_shaft = 0.0;
    double shaft_shaft = 0.0;
    bool tip_held = false;  ///< the force is the reaction of an active constraint
    bool shaft_held = false;
  };

  /// Evaluates the drive's trajectory over a step. Returns true if it changed the state.
  bool follow(double t, double h, State<Real>& state) noexcept;
  void gather(const Vector<Real>& q, const Vector<Real>& v) noexcept;
  void place_tool(double t, const Vector<Real>& q, const Vector<Real>& v) noexcept;
  /// Returns xi of the material at position s of the line. Values below the depth of the first
  /// contact point are outside the tissue.
  [[nodiscard]] double depth_at(double s) const noexcept;
  [[nodiscard]] double displacement_at(NeedlePath::Place at) const noexcept;
  [[nodiscard]] double velocity_at(NeedlePath::Place at) const noexcept;
  void weigh() noexcept;  ///< computes shares and Gram entries at the current depth
  void solve(double tool_acceleration) noexcept;
  void take_tip(double needed) noexcept;
  void take_shaft(double needed) noexcept;
  [[nodiscard]] bool may_hold_shaft() const noexcept;
  void push(std::size_t knot, double force, Vector<Real>& f) const noexcept;
  [[nodiscard]] bool is_locked(const Knot& knot) const noexcept;
  /// Returns the share of the tip's or the shaft's force on a contact point.
  [[nodiscard]] double tip_share(std::size_t knot) const noexcept;
  /// Returns the impulses or forces (tip, shaft) that reduce the given constraint residuals to
  /// zero.
  [[nodiscard]] Eigen::Vector2d solve_contact_forces(double tip, double shaft, bool tip_held,
                                                     bool shaft_held) const noexcept;
  void match_velocities(State<Real>& state) noexcept;
  void match_positions(State<Real>& state) noexcept;
  void account(double h) noexcept;
  void meet_bone(double t, State<Real>& state) noexcept;
  void change_modes(double t, const Contact& held) noexcept;
  [[nodiscard]] double depth_rate() const noexcept;
  void change_tip(double t) noexcept;
  /// Changes the mode of a tip that is outside the tissue; `here` is the depth of the material at
  /// the tip.
  void change_outside(double here, double t) noexcept;
  void change_in_track(double here, double t) noexcept;
  void change_stuck(double t) noexcept;
  void change_cutting(double here, double t) noexcept;
  void leave(double t) noexcept;
  /// Tolerances on the contact laws of tip and shaft for the solution of a step.
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
  /// Dissipated power of cutting and friction [W].
  [[nodiscard]] Eigen::Vector2d dissipated_power() const noexcept;
  /// Cutting force F_c at the tip; its interval changes only between steps.
  [[nodiscard]] double cutting_force() const noexcept {
    return path_.intervals()[path_.interval_at(cut_)].cutting_force;
  }
  [[nodiscard]] double tool_mobility() const noexcept;
  /// Force of the hand on a tool with a coordinate [N].
  [[nodiscard]] double hand(double t) const noexcept;

  Drive drive_;
  Trajectory trajectory_;
  bool needle_ = true;
  Eigen::Index tool_ = -1;  ///< coordinate of the tool
  Eigen::Index stride_;     ///< between the coordinates of a node
  Coupling coupling_{};
  Eigen::Vector3d n_;
  std::array<Eigen::Vector3d, 2> across_;  ///< unit vectors orthogonal to n and to each other

  std::vector<Support> supports_;
  std::vector<Knot> knots_;
  ConstraintCompliance<Real> held_{};  ///< used by implicit schemes only
  std::vector<double> shaft_share_;    ///< l_k / L
  double limit_ = 0.0;                 ///< L [N]
  NeedlePath::Place at_{};             ///< position of the tip between the contact points
  Contact contact_{};

  ShaftMode shaft_ = ShaftMode::stick;
  bool at_bone_ = false;
  bool bone_seen_ = false;
  bool clear_ = true;         ///< the tip is off the skin by more than a rebound
  bool present_ = false;      ///< contact was reported, and no withdrawal since
  double tip_force_ = 0.0;    ///< T
  double shaft_force_ = 0.0;  ///< F_f
  double bone_force_ = 0.0;
  std::size_t deepest_ = 0;  ///< last interval that the tip entered
  bool entered_ = false;     ///< the tip entered at least one interval

  double tolerance_ = 0.0;  ///< relative tolerance of the solver
  double step_begin_ = 0.0;
  double step_length_ = 0.0;
  double step_tip_force_ = 0.0;   ///< T over the last implicit step [N]
  double step_tip_change_ = 0.0;  ///< change of T since the step before, if the tip stuck in both
  double stopped_ = 0.0;  ///< velocity relative to the tissue of a tip that begins to stick [m/s]
  bool stuck_before_ = false;
  double place_begin_ = 0.0;
  bool predict_ = false;
  double depth_begin_ = 0.0;
  double depth_rate_ = 0.0;
  Eigen::Vector2d lag_{
      0.0, 0.0};  ///< deceleration that tip and shaft need in an implicit step to stick [m/s^2]
  Eigen::Vector2d dissipated_power_begin_{0.0, 0.0};
  bool first_evaluation_ = false;
  double hand_power_begin_ = 0.0;
  double hand_power_end_ = 0.0;

  Eigen::Vector3d sideways_{0.0, 0.0, 0.0};  ///< force of the tissue on the needle [N]
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Contact of a needle or probe with a network: modes of tip and shaft, contact forces on the
/// nodes, and mode changes between two steps (model/EQUATIONS.md, "Needle tip", "Shaft friction",
/// "Lateral lock", "Tool forces"). The constructor allocates all memory.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/kernels/relaxation.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/problem/tool.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/constraint_compliance.hpp"
#include "model/stepping/creeping_friction.hpp"
#include "model/stepping/tool_report.hpp"

namespace palpate {

/// Spring and damper between the hand, or the device that it holds, and a tool with a coordinate.
struct Coupling {
  double stiffness = 0.0;  ///< [N/m]
  double viscosity = 0.0;  ///< [N s/m]
};
Coupling coupling_of(const Scene& scene, const Drive& drive);

/// State that a tool keeps between two steps.
struct ToolMemory {
  Eigen::Vector2d centre_{0.0, 0.0};  ///< of a sliding probe [m]
  std::optional<SyringePressure> syringe_{};
  TipMode tip_ = TipMode::outside;
  double place_ = 0.0;     ///< s [m]
  double velocity_ = 0.0;  ///< s' [m/s]
  double depth_ = 0.0;     ///< of the tip, in undeformed tissue [m]
  double cut_ = 0.0;       ///< largest cut depth so far [m]
  double slip_ = 0.0;      ///< sliding velocity of the shaft [m/s]
  double handle_place_ = 0.0;
  double handle_velocity_ = 0.0;
  ToolForces forces_{};  ///< of the last apply()
  ToolLosses losses_{};
  std::array<ToolHappening, 32> happenings_{};
  std::size_t happening_count_ = 0;
};

/// Position, modes, forces and events of a tool, without reference to the tissue's coordinates.
class ToolState : protected ToolMemory {
 public:
  explicit ToolState(const Scene& scene, const SpringNetwork& network);

  /// Sets the hand's end of the coupling: position s [m] and velocity s' [m/s].
  void move_handle(double place, double velocity) noexcept {
    handle_place_ = place;
    handle_velocity_ = velocity;
  }
  [[nodiscard]] ToolMotion motion() const noexcept { return {place_, velocity_}; }
  [[nodiscard]] ToolReport report() const noexcept {
    return {.place = place_,
            .velocity = velocity_,
            .depth = depth_,
            .cut = cut_,
            .slip = slip_,
            .mass = mass_,
            .touching = in_tissue(),
            .forces = forces(),
            .losses = losses_};
  }
  /// Forces of the last evaluation.
  [[nodiscard]] ToolForces forces() const noexcept {
    ToolForces all = forces_;
    all.lateral = lateral_force(all.on_tool, path_.direction());
    return all;
  }
  /// Energy of a tool with a coordinate [J]; zero under a prescribed trajectory.
  [[nodiscard]] double kinetic_energy() const noexcept {
    return 0.5 * mass_ * velocity_ * velocity_;
  }
  /// Adds energy that the tissue's dampers dissipated [J].
  void add_damping_loss(double energy) noexcept { losses_.damping += energy; }

  /// Writes the values of tool_columns().
  void sample(std::span<double> row) const noexcept;
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
  std::optional<Probe> sliding_{};  ///< a probe with a path
  double mass_ = 0.0;               ///< [kg]; zero under a prescribed trajectory
};

/// State that the contact keeps between two steps and cannot compute from the positions and
/// velocities of the tissue.
struct ContactMemory {
  double theta_ = 0.0;  ///< of an implicit scheme; 0 for an explicit one
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
  double step_begin_ = 0.0;
  double step_length_ = 0.0;
  double step_tip_force_ = 0.0;   ///< T over the last implicit step [N]
  double step_tip_change_ = 0.0;  ///< change of T since the step before, if the tip stuck in both
  double stopped_ = 0.0;  ///< velocity relative to the tissue of a tip that begins to stick [m/s]
  bool stuck_before_ = false;
  double place_begin_ = 0.0;
  double gap_begin_ = 0.0;  ///< distance that the tip is ahead of its cut before a step [m]
  double depth_begin_ = 0.0;
  bool first_evaluation_ = false;
  double hand_power_begin_ = 0.0;
  double hand_power_end_ = 0.0;
};

template <class Real> class ToolContact : public ToolState, private ContactMemory {
 public:
  ToolContact(const Scene& scene, const NetworkProblem& problem, const NodeLayout& layout,
              TipCompliance compliance = {})
      : ToolState(scene, problem.network()),
        compliance_(std::move(compliance)),
        drive_(scene.drive.value_or(Drive{})),
        trajectory_(drive_, scene.simulation.duration + scene.simulation.step),
        needle_(scene.needle.has_value()),
        stride_(layout.stride),
        coupling_(coupling_of(scene, drive_)),
        n_(path_.direction()),
        tolerance_(std::max(scene.simulation.solver_tolerance,
                            64.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()))) {
    if (drive_.kind != Drive::Kind::trajectory) {
      tool_ = layout.size;
      mass_ = scene.needle ? scene.needle->mass : scene.probe->mass;
    }
    const NodeVectors& held = problem.held_position();
    for (const NeedlePath::Knot& knot : path_.knots()) {
      Knot mine{supports_.size(), 0, knot.depth, 0.0, 0.0, 0.0, 0.0, 0.0};
      for (const NeedlePath::Support& s : path_.supports(knot)) {
        const Eigen::Index c = layout.first[static_cast<std::size_t>(s.node)];
        if (sliding_) {
          const double rest = n_.dot(problem.network().rest_position.col(s.node));
          columns_.push_back({static_cast<std::size_t>(s.column),
                              c < 0 ? no_support : supports_.size(), rest,
                              c < 0 ? n_.dot(held.col(s.node)) - rest : -rest});
        }
        mine.held -= s.weight * n_.dot(problem.network().rest_position.col(s.node));
        if (c < 0) {
          mine.held += s.weight * n_.dot(held.col(s.node));
          continue;
        }
        const double inverse_mass = 1.0 / problem.mass()(problem.coordinate(s.node));
        supports_.push_back({c, s.weight, inverse_mass});
        mine.mobility += s.weight * s.weight * inverse_mass;
      }
      mine.count = supports_.size() - mine.first;
      knots_.push_back(mine);
    }
    if (sliding_) { share_.resize(path_.sliding_face()->node.size()); }
    across_[0] = n_.unitOrthogonal();
    across_[1] = n_.cross(across_[0]);
    shaft_share_.assign(knots_.size(), 0.0);
    for (std::size_t n = 0; needle_ && n < path_.intervals().size(); ++n) {
      const PathInterval& interval = path_.intervals()[n];
      if (!(interval.friction > 0.0 && interval.friction_travel > 0.0)) { continue; }
      drags_.push_back({.interval = n,
                        .law = {.travel = interval.friction_travel,
                                .exponent = interval.friction_exponent,
                                .friction = interval.friction},
                        .share = std::vector<double>(knots_.size(), 0.0)});
    }
    if (!compliance_.value.empty()) {
      relaxation_.resize(path_.intervals().size());
      for (std::size_t n = 0; n < relaxation_.size(); ++n) {
        relaxation_[n].add(path_.intervals()[n].law, 1);
      }
    }
    place_ = place_begin_ = handle_place_ = drive_.from;
    depth_ = cut_ = knots_.front().depth;
  }

  /// Returns the kinetic energy and the energy of the tissue that tip and shaft press and drag [J].
  [[nodiscard]] double stored_energy() const noexcept {
    double energy = kinetic_energy() + pressed_;
    for (const ShaftDrag& one : drags_) { energy += one.law.energy(); }
    return energy;
  }
  /// Returns true under an applied force: the tool then has a coordinate, after those of the
  /// network.
  [[nodiscard]] bool is_coordinate() const { return tool_ >= 0; }
  [[nodiscard]] double mass() const { return mass_; }
  [[nodiscard]] const Coupling& coupling() const { return coupling_; }
  /// Initialises the contact at t = 0 and adds the tool's coordinate to the state. A tip that
  /// begins on the skin is in contact.
  void begin(State<Real>& state) {
    if (is_coordinate()) {
      state.position.conservativeResize(tool_ + 1);
      state.velocity.conservativeResize(tool_ + 1);
      state.position(tool_) = static_cast<Real>(drive_.from);
      state.velocity(tool_) = Real(0);
    }
    gather(state.position, state.velocity);
    change_tip(0.0);
  }

  /// Returns true if continue_from() can take the state of another contact.
  [[nodiscard]] bool resembles(const ToolContact& other) const {
    const auto of_same_interval = [](const ShaftDrag& a, const ShaftDrag& b) {
      return a.interval == b.interval;
    };
    return knots_.size() == other.knots_.size() && supports_.size() == other.supports_.size() &&
           path_.intervals().size() == other.path_.intervals().size() &&
           std::ranges::equal(drags_, other.drags_, of_same_interval) &&
           is_coordinate() == other.is_coordinate();
  }
  /// Takes the state of the same tool between two steps, in tissue with other stiffnesses at the
  /// same positions. The caller computes the forces.
  void continue_from(const ToolContact& from, const State<Real>& state) noexcept {
    if (sliding_ && centre_ != from.centre_) { press_at(from.centre_); }
    static_cast<ToolMemory&>(*this) = from;
    for (std::size_t n = 0; n < drags_.size(); ++n) {
      drags_[n].law.length = from.drags_[n].law.length;
      drags_[n].law.force = from.drags_[n].law.force;
      drags_[n].force = from.drags_[n].force;
      drags_[n].slope = from.drags_[n].slope;
      std::ranges::copy(from.drags_[n].share, drags_[n].share.begin());
    }
    // Without compliance before, the contact has no past.
    for (std::size_t n = 0; n < std::min(relaxation_.size(), from.relaxation_.size()); ++n) {
      relaxation_[n].continue_from(from.relaxation_[n], [&](std::size_t) {
        const double softness = compliance_.at(depth_);
        return softness > 0.0 ? from.compliance_.at(depth_) / softness : 1.0;
      });
    }
    static_cast<ContactMemory&>(*this) = from;
    gather(state.position, state.velocity);
    weigh();
    contact_.tip_held = from.contact_.tip_held;
    contact_.shaft_held = from.contact_.shaft_held;
    pressed_ = pressed_energy();
    dissipated_power_begin_ = dissipated_power();
    depth_rate_ = depth_rate();
  }

  /// Evaluates the trajectory for a step from t to t + h. Sticking parts follow a jump of its
  /// velocity. An implicit scheme gives its theta; the depth is then extrapolated linearly and not
  /// taken from the state. An explicit scheme gives 0.
  /// Returns true if it changed the state.
  bool begin_step(double t, double h, State<Real>& state, double theta) noexcept {
    step_begin_ = t;
    step_length_ = h;
    const bool predict = theta > 0.0;
    predict_ = predict;
    theta_ = theta;
    tried_.reset();
    depth_begin_ = depth_;
    first_evaluation_ = true;
    if (sliding_) { slide(t + h); }
    const bool changed = !is_coordinate() && follow(t, h, state);
    if (predict && in_tissue()) {
      gather(state.position, state.velocity);
      place_ = is_coordinate() ? static_cast<double>(state.position(tool_)) : place_begin_;
      gap_begin_ = gap_at_cut();
      relax_to(theta * h);
      weigh();
      lag_ = Eigen::Vector2d(velocity_ - velocity_at(at_), slip_now()) / h;
      if (softness_ > 0.0) { lag_.x() = (lag_.x() + gap() / (theta * h * h)) / theta; }
      predict_cutting();
    }
    return changed;
  }
  /// State of the tool before a step, from which the step can be taken again.
  struct Memory {
    ToolMemory tool;
    ContactMemory contact;
  };
  [[nodiscard]] Memory memory() const noexcept { return {*this, *this}; }
  void go_back(const Memory& start) noexcept {
    if (sliding_ && centre_ != start.tool.centre_) { press_at(start.tool.centre_); }
    static_cast<ToolMemory&>(*this) = start.tool;
    static_cast<ContactMemory&>(*this) = start.contact;
  }
  /// Adds the contact forces between tool and tissue to the forces f of a state.
  void apply(double t, const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept {
    gather(q, v);
    place_tool(t, q, v);
    relax_to(t - step_begin_);
    weigh();
    const double dragged = add_drag(t - step_begin_, f);
    for (Knot& knot : knots_) {
      Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
      for (const Support& s : supports_of(knot)) {
        acceleration +=
            (s.weight * s.inverse_mass) * at_node(f, s.coordinate, stride_).template cast<double>();
      }
      knot.acceleration = n_.dot(acceleration);
      if (!is_locked(knot)) { continue; }
      const Eigen::Vector3d force = (knot.acceleration * n_ - acceleration) / knot.mobility;
      add_force(knot, force, f);
      sideways_ -= force;
    }
    const double pushed = is_coordinate() ? hand(t) : 0.0;
    solve(is_coordinate() && !at_bone_ ? (pushed - dragged) / mass_ : 0.0);
    push(tip_force_, shaft_force_, f);
    const double tissue = tip_force_ + shaft_force_ + dragged;
    bone_force_ = 0.0;
    if (is_coordinate()) {
      if (at_bone_) { bone_force_ = std::max(pushed - tissue, 0.0); }
      f(tool_) = static_cast<Real>(pushed - tissue - bone_force_);
    } else {
      bone_force_ = drive_.grip_stiffness * std::max(trajectory_.place(t) - path_.bone(), 0.0);
    }
    const bool cuts = tip_ == TipMode::cutting;
    forces_.cutting = cuts ? tip_force_ : 0.0;
    forces_.friction = shaft_force_ + dragged;
    forces_.stiffness = (cuts ? 0.0 : tip_force_) + bone_force_;
    forces_.total = forces_.cutting + forces_.friction + forces_.stiffness;
    forces_.applied = is_coordinate() ? pushed : forces_.total;
    forces_.on_tool = sideways_ - forces_.total * n_;
    hand_power_end_ = forces_.applied * velocity_;
    if (first_evaluation_) { hand_power_begin_ = hand_power_end_; }
    first_evaluation_ = false;
    sideways_.setZero();
  }
  /// Changes product = A x of the unconstrained Jacobian to the product with the constrained
  /// Jacobian.
  void hold(const Vector<Real>& x, const Vector<Real>& mass, Vector<Real>& product) noexcept {
    add_drag_jacobian(x, product);
    double tip = 0.0;
    double shaft = 0.0;
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      const Knot& knot = knots_[k];
      Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
      for (const Support& s : supports_of(knot)) {
        const Eigen::Index c = s.coordinate;
        const Eigen::Matrix<Real, 3, 1> force =
            at_node(product, c, stride_) -
            at_node(mass, c, stride_).cwiseProduct(at_node(x, c, stride_));
        acceleration += (s.weight * s.inverse_mass) * force.template cast<double>();
      }
      const double along = n_.dot(acceleration);
      tip -= tip_share(k) * along;
      if (limit_ > 0.0) { shaft -= shaft_share_[k] * along; }
      if (!is_locked(knot)) { continue; }
      add_force(knot, (along * n_ - acceleration) / knot.mobility, product);
    }
    if (is_coordinate()) {
      const double own = static_cast<double>(product(tool_) - mass(tool_) * x(tool_));
      if (at_bone_) {
        product(tool_) = mass(tool_) * x(tool_);
      } else {
        tip += own / mass_;
        shaft += own / mass_;
      }
    }
    if (!contact_.tip_held && !contact_.shaft_held) { return; }
    const Eigen::Vector2d force =
        solve_contact_forces(tip, shaft, contact_.tip_held, contact_.shaft_held);
    push(force.x(), force.y(), product);
    if (is_coordinate() && !at_bone_) { product(tool_) -= static_cast<Real>(force.sum()); }
  }
  /// Computes the constraint compliance for a preconditioner; allocates.
  void learn_compliance(Eigen::Index dof, const typename ConstraintCompliance<Real>::Solve& solve) {
    std::vector<std::size_t> begin;
    for (const Knot& knot : knots_) { begin.push_back(knot.first); }
    begin.push_back(supports_.size());
    held_.learn(supports_, begin, drags_.size(), tool_, mass_, dof, solve);
  }
  /// Adds the rows of hold(): tip, shaft, two directions across the needle for each locked contact
  /// point, a tool stopped by bone, and creeping friction.
  void begin_linear_solve() noexcept {
    held_.clear();
    const double own = is_coordinate() && !at_bone_ ? 1.0 : 0.0;
    if (contact_.tip_held) {
      const std::size_t count = std::min<std::size_t>(2, knots_.size() - at_.knot);
      const auto row = held_.add_row(at_.knot, count, own, step_softness());
      for (std::size_t n = 0; n < count; ++n) { row[n] = -tip_share(at_.knot + n) * n_; }
    }
    if (contact_.shaft_held) {
      const std::size_t count =
          std::min(at_.knot + 2, knots_.size());  // no friction beyond the tip
      const auto row = held_.add_row(0, count, own);
      for (std::size_t k = 0; k < count; ++k) { row[k] = -shaft_share_[k] * n_; }
    }
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      if (!is_locked(knots_[k])) { continue; }
      held_.add_row(k, 1, 0.0)[0] = across_[0];
      held_.add_row(k, 1, 0.0)[0] = across_[1];
    }
    if (is_coordinate() && at_bone_) { held_.add_row(0, 0, 1.0); }
    for (const ShaftDrag& one : drags_) {
      if (!(one.slope > 0.0)) { continue; }
      const auto row =
          held_.add_force_row(0, knots_.size(), own, 1.0 / (theta_ * step_length_ * one.slope));
      for (std::size_t k = 0; k < knots_.size(); ++k) { row[k] = -one.share[k] * n_; }
    }
    held_.factorise();
  }
  /// Returns a number for the modes of tip, shaft and bone and the number of locked contact points.
  [[nodiscard]] long constraint_set() const noexcept {
    const auto locked =
        std::ranges::count_if(knots_, [this](const Knot& knot) { return is_locked(knot); });
    return ((locked * 4 + static_cast<long>(tip_)) * 3 + static_cast<long>(shaft_)) * 2 +
           static_cast<long>(at_bone_);
  }
  void constrain_solution(const Vector<Real>& r, Vector<Real>& solution) const noexcept {
    held_.correct(r, solution);
  }
  /// Checks the contact laws of tip and shaft after an implicit step. Returns true if it changed
  /// their active constraints, and the caller must repeat the step (model/EQUATIONS.md, "Held
  /// constraints"). Constraints that this step was solved with before are not tried again.
  bool update_active_set(const State<Real>& state) noexcept {
    if (!in_tissue()) { return false; }
    gather(state.position, state.velocity);
    if (is_coordinate()) { velocity_ = static_cast<double>(state.velocity(tool_)); }
    place_ = is_coordinate() ? static_cast<double>(state.position(tool_))
                             : place_begin_ + velocity_ * step_length_;
    const Slack allowed = slack();
    const auto [tip_before, shaft_before] = std::pair{tip_, shaft_};
    tried_.set(mode_number());
    const bool tip = update_tip(velocity_ - velocity_at(at_), allowed);
    const bool shaft = update_shaft(slip_now(), allowed);
    first_evaluation_ = true;
    if (!tip && !shaft) { return false; }
    if (!tried_.test(mode_number())) { return true; }
    // No set of constraints satisfies the laws; end_step() limits the forces.
    tip_ = tip_before;
    shaft_ = shaft_before;
    return false;
  }
  /// Updates the modes after a step that ended at t and removes the drift of sticking parts.
  void end_step(double t, State<Real>& state) noexcept {
    gather(state.position, state.velocity);
    end_drag(state);
    lag_.setZero();
    const bool stuck = tip_ == TipMode::stuck;
    step_tip_change_ = stuck && stuck_before_ ? tip_force_ - step_tip_force_ : 0.0;
    step_tip_force_ = tip_force_;
    stuck_before_ = stuck;
    if (predict_) {  // if update_active_set found no solution, the force is limited by the law
      predict_ = false;
      if (contact_.tip_held) { take_tip(tip_force_); }
      if (contact_.shaft_held) { take_shaft(shaft_force_); }
    }
    place_tool(t, state.position, state.velocity);
    const Contact held = contact_;
    account(t - step_begin_);
    meet_bone(t, state);
    change_modes(t, held);
    reach_drag();
    remember_contact();
    if (in_tissue()) {
      match_positions(state);
      match_velocities(state);
    }
    // The work of the tip on the tissue at d, less the change of the energy stored there, is the
    // loss in cutting.
    const double pressed = pressed_energy();
    losses_.cutting += pressed_ - pressed;
    pressed_ = pressed;
    dissipated_power_begin_ = dissipated_power();
    depth_rate_ = depth_rate();
    if (syringe_) {
      const bool at_rest = std::abs(velocity_) < resting;
      syringe_->advance(
          step_length_,
          syringe_->resistance(in_tissue(), interval().role, interval().outflow_resistance),
          syringe_->thumb_limit(forces_.total, at_rest));
    }
  }

 private:
  using Support = typename ConstraintCompliance<Real>::Support;
  /// Relative determinant below which the constraints of tip and shaft are treated as one.
  static constexpr double independent = 1e-6;
  /// Velocity [m/s] below which a tip that presses with its cutting force does not cut.
  static constexpr double still = 1e-9;
  /// Speed of a needle below which the thumb tests [m/s]: a tenth of a slow advance.
  static constexpr double resting = 1e-4;
  /// Distance from the skin [m] at which the tip has left it. Smaller rebounds of a resting tip are
  /// not reported.
  static constexpr double clear_of_skin = 1e-6;
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
  static constexpr std::size_t no_support = std::numeric_limits<std::size_t>::max();
  /// Column of skin nodes that a sliding face may press.
  struct FaceColumn {
    std::size_t column;
    std::size_t support;  ///< no_support for a fixed node
    double rest;          ///< depth of the node at rest [m]
    double held;          ///< part of Knot::held per unit of weight [m]
  };
  /// Coupling of tip and shaft with the network, and their forces.
  struct Contact {
    double tip_tip = 0.0;  ///< Gram entries including the tool's 1/m [1/kg]
    double tip_shaft = 0.0;
    double shaft_shaft = 0.0;
    bool tip_held = false;  ///< the force is the reaction of an active constraint
    bool shaft_held = false;
  };

  /// Creeping friction of the shaft on one interval.
  struct ShaftDrag {
    std::size_t interval = 0;
    CreepingFriction law{};
    double force = 0.0;           ///< of the last apply() [N]
    double slope = 0.0;           ///< of this force over the shaft's velocity [N s/m]
    std::vector<double> share{};  ///< of the contact points
  };

  [[nodiscard]] std::size_t mode_number() const noexcept {
    return static_cast<std::size_t>(tip_) * 3 + static_cast<std::size_t>(shaft_);
  }
  [[nodiscard]] double dragging_velocity(const ShaftDrag& one) const noexcept {
    double velocity = velocity_;
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      velocity -= one.share[k] * knots_[k].velocity;
    }
    return velocity;
  }
  /// Adds creeping friction to the forces, `s` seconds after the begin of a step, and returns its
  /// sum [N]. An implicit step has the force of its end.
  double add_drag(double s, Vector<Real>& f) noexcept {
    double sum = 0.0;
    for (ShaftDrag& one : drags_) {
      const auto [force, slope] =
          one.law.after(predict_ ? step_length_ : s, dragging_velocity(one));
      one.force = force;
      one.slope = slope;
      sum += force;
      if (force == 0.0) { continue; }
      for (std::size_t k = 0; k < knots_.size(); ++k) {
        if (one.share[k] > 0.0) { add_force(knots_[k], one.share[k] * force * n_, f); }
      }
    }
    return sum;
  }
  /// Adds the product with the Jacobian of creeping friction.
  void add_drag_jacobian(const Vector<Real>& x, Vector<Real>& product) noexcept {
    for (const ShaftDrag& one : drags_) {
      if (!(one.slope > 0.0)) { continue; }
      const bool moves = is_coordinate() && !at_bone_;
      double along = moves ? static_cast<double>(x(tool_)) : 0.0;
      for (std::size_t k = 0; k < knots_.size(); ++k) {
        if (one.share[k] == 0.0) { continue; }
        for (const Support& s : supports_of(knots_[k])) {
          along -= one.share[k] * s.weight *
                   n_.dot(at_node(x, s.coordinate, stride_).template cast<double>());
        }
      }
      const double force = theta_ * step_length_ * one.slope * along;
      if (moves) { product(tool_) += static_cast<Real>(force); }
      for (std::size_t k = 0; k < knots_.size(); ++k) {
        if (one.share[k] > 0.0) { add_force(knots_[k], -one.share[k] * force * n_, product); }
      }
    }
  }
  /// Takes the forces of creeping friction at the end of a step.
  void end_drag(const State<Real>& state) noexcept {
    if (drags_.empty()) { return; }
    if (is_coordinate()) { velocity_ = static_cast<double>(state.velocity(tool_)); }
    for (ShaftDrag& one : drags_) {
      if (!(one.law.limit() > 0.0)) { continue; }
      const double before = one.law.energy();
      if (!predict_) { one.force = one.law.after(step_length_, dragging_velocity(one)).force; }
      one.law.force = one.force;
      losses_.friction +=
          one.force * step_length_ * dragging_velocity(one) - (one.law.energy() - before);
    }
  }
  /// Returns how far the shaft pulls the surface out along the needle [m], <= 0.
  [[nodiscard]] double pulled_surface() const noexcept {
    const bool dragged = !drags_.empty() && drags_.front().interval == 0;
    return dragged ? std::min(drags_.front().law.drag(), 0.0) : 0.0;
  }
  /// Adapts creeping friction to the depth of the tip.
  void reach_drag() noexcept {
    for (ShaftDrag& one : drags_) {
      const double before = one.law.energy();
      const PathInterval& tissue = path_.intervals()[one.interval];
      const double end = std::max(std::min(tissue.end, knots_.back().depth), tissue.begin);
      one.law.reach(depth_ - tissue.begin, in_tissue() ? end - tissue.begin : 0.0);
      const double limit = path_.friction(one.interval, tissue.begin + one.law.length, one.share);
      for (double& share : one.share) { share = limit > 0.0 ? share / limit : 0.0; }
      losses_.friction -= one.law.energy() - before;
    }
  }
  /// Moves the face of a sliding probe to its centre at a time.
  void slide(double t) noexcept {
    const Eigen::Vector2d centre = sliding_->centre(t);
    if (centre != centre_) { press_at(centre); }
  }
  /// Moves the face of a sliding probe: new weights of its contact point.
  void press_at(const Eigen::Vector2d& centre) noexcept {
    centre_ = centre;
    path_.sliding_face()->press(centre, share_);
    Knot& knot = knots_.front();
    knot.depth = knot.held = knot.mobility = 0.0;
    for (const FaceColumn& column : columns_) {
      const double weight = share_[column.column];
      knot.depth += weight * column.rest;
      knot.held += weight * column.held;
      if (column.support == no_support) { continue; }
      Support& support = supports_[column.support];
      support.weight = weight;
      knot.mobility += weight * weight * support.inverse_mass;
    }
    depth_ = cut_ = knot.depth;
    if (held_.learned()) { held_.reweigh(supports_, 2); }
  }
  /// Evaluates the drive's trajectory over a step. Returns true if it changed the state.
  bool follow(double t, double h, State<Real>& state) noexcept {
    const double from = std::min(trajectory_.place(t), path_.bone());
    const double to = std::min(trajectory_.place(t + h), path_.bone());
    const double velocity = (to - from) / h;
    // Rounding of position differences is not a jump.
    const double rounding =
        8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to)) / h;
    place_begin_ = from;
    if (std::abs(velocity - velocity_) <= rounding) { return false; }
    velocity_ = velocity;
    if (!in_tissue()) { return false; }
    gather(state.position, state.velocity);
    weigh();
    contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0 &&
                        velocity_ > velocity_at(at_);  // the tip can push but not pull
    turn_shaft(h);
    match_velocities(state);
    dissipated_power_begin_ = dissipated_power();
    return true;
  }
  void gather(const Vector<Real>& q, const Vector<Real>& v) noexcept {
    const Eigen::Matrix<Real, 3, 1> n = n_.template cast<Real>();
    for (Knot& knot : knots_) {
      knot.displacement = knot.held;
      knot.velocity = 0.0;
      for (const Support& s : supports_of(knot)) {
        const auto place = at_node(q, s.coordinate, stride_).template cast<double>();
        knot.displacement += s.weight * n_.dot(place);
        knot.velocity += s.weight * static_cast<double>(n.dot(at_node(v, s.coordinate, stride_)));
      }
    }
  }
  void place_tool(double t, const Vector<Real>& q, const Vector<Real>& v) noexcept {
    if (is_coordinate()) {
      place_ = static_cast<double>(q(tool_));
      velocity_ = static_cast<double>(v(tool_));
    } else {
      place_ = place_begin_ + velocity_ * (t - step_begin_);
    }
    switch (tip_) {
      case TipMode::outside: depth_ = knots_.front().depth; break;
      case TipMode::stuck: depth_ = cut_; break;
      case TipMode::cutting:
      case TipMode::in_track:
        depth_ = predict_ ? depth_begin_ + depth_rate_ * (t - step_begin_) : depth_of_tip();
        if (tip_ == TipMode::in_track && relaxes()) { depth_ = std::min(depth_, cut_); }
        break;
    }
  }
  /// Returns xi of the material at position s of the line. Values below the depth of the first
  /// contact point are outside the tissue.
  [[nodiscard]] double depth_at(double s) const noexcept {
    std::size_t k = 0;
    while (k + 1 < knots_.size() && s >= knots_[k + 1].depth + knots_[k + 1].displacement) { ++k; }
    const double low = knots_[k].depth + knots_[k].displacement;
    if (k + 1 == knots_.size()) { return knots_[k].depth + (s - low); }
    const double high = knots_[k + 1].depth + knots_[k + 1].displacement;
    if (!(high > low) || s < low) { return knots_[k].depth + (s - low); }
    return knots_[k].depth + (s - low) / (high - low) * (knots_[k + 1].depth - knots_[k].depth);
  }
  [[nodiscard]] double between_knots(NeedlePath::Place at, double Knot::*value) const noexcept {
    const double low = knots_[at.knot].*value;
    return at.share == 0.0 ? low : low + at.share * (knots_[at.knot + 1].*value - low);
  }
  [[nodiscard]] double velocity_at(NeedlePath::Place at) const noexcept {
    return between_knots(at, &Knot::velocity);
  }
  /// Returns the depth of the material at the tip. A tip that cuts presses the tissue before it
  /// with the cutting force: d + U(d) + g(d, F_c) = s. The first solution at or beyond the cut is
  /// taken, at most the end of the interval. Returns a depth before the cut if there is none.
  [[nodiscard]] double depth_of_tip() const noexcept {
    if (tip_ != TipMode::cutting || compliance_.value.empty()) { return depth_at(place_); }
    const double force = cutting_force();
    const auto missing = [&](double depth) {  // distance that the tip still has to go
      return place_ - depth - between_knots(path_.place(depth), &Knot::displacement) -
             dent_at(depth, force);
    };
    double low = cut_;
    double rest = missing(low);
    if (!(rest > 0.0)) { return rest < 0.0 ? low + rest : low; }
    const double border = path_.intervals()[path_.interval_at(cut_)].end;
    while (low < border) {
      const double high = std::min(border, end_of_piece(low));
      if (std::isinf(high)) { return low + rest; }
      const double next = missing(high);
      if (!(next > 0.0)) { return low + (high - low) * rest / (rest - next); }
      low = high;
      rest = next;
    }
    return border;
  }
  /// Returns the gap of the contact at a depth under a force on the tissue that the tip presses
  /// [m].
  [[nodiscard]] double dent_at(double depth, double force) const noexcept {
    return compliance_.is_linear() ? compliance_.at(depth) * force : law_at(depth).gap(force);
  }
  /// Returns the law of the contact at a depth, in the tissue that the tip presses.
  [[nodiscard]] DentLaw law_at(double depth) const noexcept {
    const std::size_t interval = path_.interval_at(cut_);
    return compliance_.law(depth, path_.intervals()[interval].indentation_toe, interval);
  }
  /// Returns the end of the piece of the path from `depth` on in which U and c_s are linear [m].
  [[nodiscard]] double end_of_piece(double depth) const noexcept {
    double end = std::numeric_limits<double>::infinity();
    const std::size_t next = path_.place(depth).knot + 1;
    if (next < knots_.size()) { end = knots_[next].depth; }
    return std::min(end, compliance_.next(depth));
  }
  /// Returns the distance by which a sticking tip presses the tissue that the grid does not resolve
  /// [m].
  [[nodiscard]] double gap() const noexcept {
    return place_ - cut_ - between_knots(at_, &Knot::displacement) - crept_;
  }
  [[nodiscard]] double gap_at_cut() const noexcept {
    return place_ - cut_ - between_knots(path_.place(cut_), &Knot::displacement);
  }
  /// Returns the distance by which a tip with compliance presses further in an implicit step than
  /// with the force T [m]; its sign decides the mode.
  [[nodiscard]] double gap_beyond(double force) const noexcept {
    return theta_ * gap_at_cut() + (1.0 - theta_) * gap_begin_ - dent_at(cut_, force);
  }
  /// Returns T at the present positions [N]; zero for a sticking tip without compliance, which does
  /// no work relative to the tissue.
  [[nodiscard]] double pressing_force() const noexcept {
    if (tip_ == TipMode::cutting) { return cutting_force(); }
    if (tip_ != TipMode::stuck || softness_ == 0.0) { return 0.0; }
    return std::clamp(gap() / softness_, 0.0, strength());
  }
  /// Returns the energy of the tissue that the tip presses [J].
  [[nodiscard]] double pressed_energy() const noexcept {
    const double force = pressing_force();
    if (compliance_.is_linear()) { return 0.5 * softness_ * force * force; }
    const DentLaw law = law_at(depth_);
    return law.is_linear() ? 0.5 * softness_ * force * force : law.energy(law.gap(force));
  }
  /// Compliance of that tissue in an implicit step, as a mobility [1/kg].
  [[nodiscard]] double step_softness() const noexcept {
    return predict_ && softness_ > 0.0 ? softness_ / (theta_ * theta_ * step_length_ * step_length_)
                                       : 0.0;
  }
  /// Returns true if the tip moves with the tissue, without compliance between them.
  [[nodiscard]] bool tip_is_rigid() const noexcept { return contact_.tip_held && softness_ == 0.0; }
  [[nodiscard]] bool relaxes() const noexcept {
    return softness_ > 0.0 && !relaxation_.empty() && contact_relaxation().active();
  }
  [[nodiscard]] const Relaxation<double>& contact_relaxation() const noexcept {
    return relaxation_[path_.interval_at(cut_)];
  }
  /// Prepares the relaxation of the contact for a stage `s` seconds after the begin of a step.
  void relax_to(double s) noexcept {
    if (tip_ == TipMode::stuck && relaxes()) { relaxation_[path_.interval_at(cut_)].at(s); }
  }
  /// Returns the distance by which a tip without force is ahead of its cut, `s` seconds after the
  /// begin of a step, while the tissue before it recovers from its relaxation [m].
  [[nodiscard]] double residual_gap(double s) noexcept {
    if (!relaxes()) { return 0.0; }
    relaxation_[path_.interval_at(cut_)].at(s);
    const Relaxed now = contact_relaxation().of(0);
    return law_at(cut_).gap(now.held / now.share);
  }
  /// Returns true if a tip without force has reached the tissue at the end of its cut; `here` is
  /// the depth of the material at the tip.
  [[nodiscard]] bool reaches_cut(double here) noexcept {
    return relaxes() ? gap_at_cut() >= residual_gap(step_length_) : here >= cut_;
  }
  /// Remembers the state at the end of a step. A tip that cuts enters tissue that was not loaded
  /// before; tissue from which the tip has gone recovers without force.
  void remember_contact() noexcept {
    if (!relaxes()) { return; }
    Relaxation<double>& relaxation = relaxation_[path_.interval_at(cut_)];
    if (tip_ == TipMode::cutting) {
      const double force = pressing_force();
      relaxation.restart(&force);
      return;
    }
    relaxation.at(step_length_);
    const Relaxed now = relaxation.of(0);
    const double elastic = tip_ == TipMode::stuck
                               ? std::max(0.0, law_at(depth_).force(gap_at_cut()))
                               : now.held / now.share;
    relaxation.remember(&elastic);
    soften();
  }
  /// Computes the compliance at the current depth, and what relaxation, a toe and a table make of
  /// it: the tangent at the current gap, in an implicit step at the gap before it.
  void soften() noexcept {
    softness_ = compliance_.at(depth_);
    crept_ = 0.0;
    if (tip_ != TipMode::stuck || (compliance_.is_linear() && !relaxes())) { return; }
    const Relaxed now = relaxes() ? contact_relaxation().of(0) : Relaxed{};
    const DentLaw law = law_at(depth_);
    if (law.is_linear()) {
      softness_ /= now.share;
      crept_ = softness_ * now.held;
      return;
    }
    const double gap = predict_ ? gap_begin_ : gap_at_cut();
    softness_ = 1.0 / (now.share * law.slope(gap));
    crept_ = gap - softness_ * (now.share * law.force(gap) - now.held);
  }
  /// Computes shares and Gram entries at the current depth.
  void weigh() noexcept {
    at_ = path_.place(depth_);
    soften();
    limit_ = needle_ && in_tissue() ? path_.friction(depth_, shaft_share_) : 0.0;
    if (limit_ > 0.0) {
      for (double& share : shaft_share_) { share /= limit_; }
    }
    const double own = tool_mobility();
    contact_ = {own, own, own, false, false};
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      const double tip = tip_share(k);
      const double shaft = shaft_share(k);
      contact_.tip_tip += tip * tip * knots_[k].mobility;
      contact_.tip_shaft += tip * shaft * knots_[k].mobility;
      contact_.shaft_shaft += shaft * shaft * knots_[k].mobility;
    }
    if (tip_ == TipMode::stuck && contact_.tip_tip > 0.0) { contact_.tip_tip += step_softness(); }
  }
  /// Computes T and F_f within their laws. `tool_acceleration` is that of the tool without them.
  void solve(double tool_acceleration) noexcept {
    const auto [tip, shaft] = relative_to_tissue(tool_acceleration + lag_.x(),
                                                 tool_acceleration + lag_.y(), &Knot::acceleration);
    const bool sticks = shaft_ == ShaftMode::stick && may_hold_shaft();
    const bool stuck = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
    const double slipping = shaft_ == ShaftMode::backward ? -limit_ : limit_;
    const bool rigid = tip_ == TipMode::stuck && !stuck;  // only fixed nodes support the tip
    if (tip_ == TipMode::cutting || (rigid && velocity_ > 0.0)) {
      // Bone has no finite cutting force: the tip keeps its force at arrival, and the reaction of
      // the bone is added.
      if (std::isfinite(cutting_force())) { tip_force_ = cutting_force(); }
    } else if (!rigid || velocity_ < 0.0) {
      tip_force_ = 0.0;
    }
    contact_.tip_held = contact_.shaft_held = false;
    const bool pressed = stuck && softness_ > 0.0 && !predict_;  // the position gives the force
    if (pressed) { take_tip(gap() / softness_); }
    shaft_force_ = shaft_ == ShaftMode::stick && !sticks ? std::clamp(shaft_force_, -limit_, limit_)
                                                         : slipping;
    if (stuck && sticks && !pressed) {
      const Eigen::Vector2d both = solve_contact_forces(tip, shaft, true, true);
      take_tip(both.x());
      take_shaft(both.y());
      if (contact_.tip_held && contact_.shaft_held) { return; }
    }
    if (sticks && (pressed || !contact_.tip_held)) {  // the tip's force is known
      take_shaft((shaft - contact_.tip_shaft * tip_force_) / contact_.shaft_shaft);
    }
    if (stuck && !contact_.shaft_held && !pressed) {  // the shaft's force is known
      take_tip((tip - contact_.tip_shaft * shaft_force_) / contact_.tip_tip);
    }
  }
  /// Sets the tip force to the one that sticking needs, or to the nearest force within the law.
  /// Implicit steps take the needed force, so that Newton's method has a fixed set of constraints;
  /// update_active_set() checks the law at the end of the step.
  void take_tip(double needed) noexcept {
    const double within = std::clamp(needed, 0.0, strength());
    contact_.tip_held = predict_ || within == needed;
    tip_force_ = contact_.tip_held ? needed : within;
  }
  void take_shaft(double needed) noexcept {
    const double within = std::clamp(needed, -limit_, limit_);
    contact_.shaft_held = predict_ || within == needed;
    shaft_force_ = contact_.shaft_held ? needed : within;
  }
  [[nodiscard]] bool may_hold_shaft() const noexcept {
    if (!(limit_ > 0.0 && contact_.shaft_shaft > 0.0)) { return false; }
    // A tip on fixed nodes alone constrains nothing that the shaft could.
    const bool constrains = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
    if (!constrains || (softness_ > 0.0 && !predict_)) { return true; }
    const double product = contact_.tip_tip * contact_.shaft_shaft;
    return product - contact_.tip_shaft * contact_.tip_shaft > independent * product;
  }
  [[nodiscard]] std::span<const Support> supports_of(const Knot& knot) const noexcept {
    return std::span(supports_).subspan(knot.first, knot.count);
  }
  /// Adds a force on a contact point to the forces f on its nodes.
  void add_force(const Knot& knot, const Eigen::Vector3d& force, Vector<Real>& f) const noexcept {
    for (const Support& s : supports_of(knot)) {
      at_node(f, s.coordinate, stride_) += (s.weight * force).template cast<Real>();
    }
  }
  /// Adds the forces of tip and shaft [N] to f.
  void push(double tip, double shaft, Vector<Real>& f) const noexcept {
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      const double force = tip_share(k) * tip + shaft_share(k) * shaft;
      if (force == 0.0) { continue; }
      for (const Support& s : supports_of(knots_[k])) {
        at_node(f, s.coordinate, stride_) += (s.weight * force * n_).template cast<Real>();
      }
    }
  }
  /// Returns the given rates of tip and shaft minus those of the tissue next to them.
  [[nodiscard]] std::array<double, 2> relative_to_tissue(double tip, double shaft,
                                                         double Knot::*rate) const noexcept {
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      tip -= tip_share(k) * knots_[k].*rate;
      if (limit_ > 0.0) { shaft -= shaft_share_[k] * knots_[k].*rate; }
    }
    return {tip, shaft};
  }
  [[nodiscard]] bool is_locked(const Knot& knot) const noexcept {
    return needle_ && in_tissue() && knot.depth < depth_ && knot.mobility > 0.0;
  }
  /// Returns the share of the tip's or the shaft's force on a contact point.
  [[nodiscard]] double tip_share(std::size_t knot) const noexcept {
    return knot == at_.knot ? 1.0 - at_.share : knot == at_.knot + 1 ? at_.share : 0.0;
  }
  [[nodiscard]] double shaft_share(std::size_t knot) const noexcept {
    return limit_ > 0.0 ? shaft_share_[knot] : 0.0;
  }
  /// Returns the impulses or forces (tip, shaft) that reduce the given constraint residuals to
  /// zero.
  [[nodiscard]] Eigen::Vector2d solve_contact_forces(double tip, double shaft, bool tip_held,
                                                     bool shaft_held) const noexcept {
    const Contact& c = contact_;
    if (tip_held && shaft_held) {
      const double determinant = c.tip_tip * c.shaft_shaft - c.tip_shaft * c.tip_shaft;
      return {(c.shaft_shaft * tip - c.tip_shaft * shaft) / determinant,
              (c.tip_tip * shaft - c.tip_shaft * tip) / determinant};
    }
    return {tip_held ? tip / c.tip_tip : 0.0, shaft_held ? shaft / c.shaft_shaft : 0.0};
  }
  void match_velocities(State<Real>& state) noexcept {
    const auto [tip, shaft] = relative_to_tissue(velocity_, velocity_, &Knot::velocity);
    const Eigen::Vector2d impulse =
        solve_contact_forces(tip, shaft, tip_is_rigid(), contact_.shaft_held);
    losses_.impact += 0.5 * (impulse.x() * tip + impulse.y() * shaft);
    losses_.impulse += impulse.sum();
    if (!is_coordinate()) { losses_.jerk += impulse.sum() * velocity_; }
    for (std::size_t k = 0; k < knots_.size(); ++k) {
      Knot& knot = knots_[k];
      const double along = tip_share(k) * impulse.x() + shaft_share(k) * impulse.y();
      const bool locked = is_locked(knot);
      if (along == 0.0 && !locked) { continue; }
      Eigen::Vector3d change = along * n_;
      if (locked) {
        Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
        for (const Support& s : supports_of(knot)) {
          velocity +=
              s.weight * at_node(state.velocity, s.coordinate, stride_).template cast<double>();
        }
        const Eigen::Vector3d sideways = (velocity - n_.dot(velocity) * n_) / knot.mobility;
        losses_.impact += 0.5 * sideways.squaredNorm() * knot.mobility;
        change -= sideways;
      }
      knot.velocity += along * knot.mobility;
      for (const Support& s : supports_of(knot)) {
        at_node(state.velocity, s.coordinate, stride_) +=
            (s.weight * s.inverse_mass * change).template cast<Real>();
      }
    }
    if (is_coordinate() && !at_bone_) {
      velocity_ -= impulse.sum() / mass_;
      state.velocity(tool_) = static_cast<Real>(velocity_);
    }
  }
  void match_positions(State<Real>& state) noexcept {
    if (!tip_is_rigid()) { return; }
    const double push_by = gap() / contact_.tip_tip;
    for (const std::size_t k : {at_.knot, at_.knot + 1}) {
      if (k >= knots_.size()) { break; }
      const double share = tip_share(k) * push_by;
      knots_[k].displacement += share * knots_[k].mobility;
      for (const Support& s : supports_of(knots_[k])) {
        at_node(state.position, s.coordinate, stride_) +=
            (share * s.weight * s.inverse_mass * n_).template cast<Real>();
      }
    }
    if (is_coordinate() && !at_bone_) {
      place_ -= push_by / mass_;
      state.position(tool_) = static_cast<Real>(place_);
    }
  }
  /// Adds the work of the hand and the dissipated energy in a step of h.
  void account(double h) noexcept {
    losses_.hand += 0.5 * h * (hand_power_begin_ + hand_power_end_);
    if (!in_tissue()) { return; }
    weigh();
    const Eigen::Vector2d lost = 0.5 * h * (dissipated_power_begin_ + dissipated_power());
    losses_.cutting += lost.x();
    losses_.friction += lost.y();
  }
  void meet_bone(double t, State<Real>& state) noexcept {
    if (!is_coordinate()) {
      at_bone_ = trajectory_.place(t) >= path_.bone();
    } else if (!at_bone_ && place_ >= path_.bone() && velocity_ > 0.0) {
      place_ = path_.bone();
      losses_.impact += 0.5 * mass_ * velocity_ * velocity_;
      velocity_ = 0.0;
      state.position(tool_) = static_cast<Real>(place_);
      state.velocity(tool_) = Real(0);
      at_bone_ = true;
    } else if (at_bone_ && bone_force_ == 0.0) {
      at_bone_ = false;
    }
    if (at_bone_ && !bone_seen_) {
      happen(t, ToolEvent::bone, path_.interval_at(path_.bone()));
      bone_seen_ = true;
    }
  }
  /// Changes the modes of tip and shaft; `held` is the contact at the end of the step.
  void change_modes(double t, const Contact& held) noexcept {
    contact_.tip_held = held.tip_held;
    if (tip_ == TipMode::cutting) { enter(path_.interval_at(cut_), t); }
    change_tip(t);
    weigh();
    contact_.tip_held = held.tip_held;
    contact_.shaft_held = held.shaft_held;
    change_shaft();
    contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
    contact_.shaft_held = shaft_ == ShaftMode::stick && may_hold_shaft();
    stopped_ = tip_ == TipMode::stuck ? velocity_ - velocity_at(at_) : 0.0;
  }
  /// Returns the velocity of the tip through the undeformed tissue [m/s], for schemes that predict
  /// the depth.
  [[nodiscard]] double depth_rate() const noexcept {
    const bool moves = tip_ == TipMode::cutting || tip_ == TipMode::in_track;
    if (!moves || at_.knot + 1 >= knots_.size()) { return 0.0; }
    const Knot& low = knots_[at_.knot];
    const Knot& high = knots_[at_.knot + 1];
    double stretch = 1.0 + (high.displacement - low.displacement) / (high.depth - low.depth);
    const double ahead = compliance_.next(depth_);
    if (tip_ == TipMode::cutting && std::isfinite(ahead)) {
      const double force = cutting_force();
      stretch += (dent_at(ahead, force) - dent_at(depth_, force)) / (ahead - depth_);
    }
    return stretch > 0.0 ? (velocity_ - velocity_at(at_)) / stretch : 0.0;
  }
  void change_tip(double t) noexcept {
    const double here = depth_of_tip();
    switch (tip_) {
      case TipMode::outside: change_outside(here, t); break;
      case TipMode::in_track: change_in_track(here, t); break;
      case TipMode::stuck: change_stuck(t); break;
      case TipMode::cutting: change_cutting(here, t); break;
    }
  }
  /// Changes the mode of a tip that is outside the tissue; `here` is the depth of the material at
  /// the tip.
  void change_outside(double here, double t) noexcept {
    const double skin = knots_.front().depth;
    if (here >= skin && (cut_ > skin || reaches_cut(here))) {
      tip_ = cut_ > skin ? TipMode::in_track : TipMode::stuck;
      depth_ = cut_ > skin ? std::min(here, cut_) : cut_;
      tip_force_ = 0.0;
      if (clear_) { happen(t, ToolEvent::contact, path_.interval_at(skin)); }
      present_ = present_ || clear_;
      clear_ = false;
    } else if (here < skin - clear_of_skin) {
      leave(t);
      clear_ = true;
    }
  }
  void change_in_track(double here, double t) noexcept {
    const double skin = knots_.front().depth;
    depth_ = relaxes() ? std::min(here, cut_) : here;
    if (reaches_cut(here)) {
      tip_ = TipMode::stuck;
      tip_force_ = 0.0;
      depth_ = cut_;
    } else if (here < skin + pulled_surface()) {
      tip_ = TipMode::outside;
      depth_ = skin;
      leave(t);
    }
  }
  void change_stuck(double t) noexcept {
    depth_ = cut_;
    const double rate = velocity_ - velocity_at(at_);
    const bool rests = softness_ > 0.0 && tip_force_ > 0.0 && !(rate > still);
    if (contact_.tip_held || rests || (contact_.tip_tip <= 0.0 && velocity_ == 0.0)) { return; }
    if (tip_force_ > 0.0 || (strength() == 0.0 && velocity_ > velocity_at(at_))) {
      tip_ = TipMode::cutting;
      enter(path_.interval_at(cut_), t);
      if (softness_ > 0.0) { change_cutting(depth_of_tip(), t); }
    } else {
      tip_ = cut_ > knots_.front().depth ? TipMode::in_track : TipMode::outside;
    }
  }
  void change_cutting(double here, double t) noexcept {
    const std::size_t before = path_.interval_at(cut_);
    if (softness_ > 0.0 && here < cut_) {  // softer tissue, into which the tip has not sunk yet
      tip_ = TipMode::stuck;
      depth_ = cut_;
      return;
    }
    cut_ = depth_ =
        std::max(here, knots_.front().depth);  // a step can end slightly behind the deepest point
    const std::size_t after = path_.interval_at(cut_);
    if (after <= before) {
      if (!(velocity_ > velocity_at(path_.place(cut_)))) { tip_ = TipMode::stuck; }
      return;
    }
    const auto& intervals = path_.intervals();
    if (strength() > intervals[before].cutting_force) {
      tip_ = TipMode::stuck;
      if (after > before + 1) { enter(after - 1, t); }
      // A tip that sank through softer tissue at once can press the layer with more than it bears.
      // Behind a gap it meets a free surface, which gives way in the next step.
      const bool from_gap = intervals[after - 1].youngs_modulus == 0.0;
      if (softness_ > 0.0 && !from_gap && gap_at_cut() > dent_at(cut_, strength())) {
        tip_ = TipMode::cutting;
        enter(after, t);
        change_cutting(depth_of_tip(), t);
      }
    } else {
      enter(after, t);
      // Less resistance: the tip sinks in at once.
      if (softness_ > 0.0) { change_cutting(depth_of_tip(), t); }
    }
  }
  void leave(double t) noexcept {
    if (present_) { happen(t, ToolEvent::withdrawn, 0); }
    present_ = false;
  }
  /// Tolerances on the contact laws of tip and shaft for the solution of a step.
  struct Slack {
    double velocity = 0.0;  ///< [m/s]
    double tip = 0.0;       ///< [N]
    double shaft = 0.0;     ///< [N]
  };
  /// Returns the tolerances on the contact laws: the solver's tolerance on velocities, the rounding
  /// of positions, and the forces that change the constrained velocities by these amounts. A
  /// smaller violation is solver error, and another solve would give the opposite violation. The
  /// remainder is corrected at the end of the step.
  [[nodiscard]] Slack slack() const noexcept {
    constexpr double roundings = 8.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
    double fastest = std::abs(velocity_);
    for (const Knot& knot : knots_) { fastest = std::max(fastest, std::abs(knot.velocity)); }
    const double velocity =
        tolerance_ * fastest +
        roundings * std::max(std::abs(place_), knots_.back().depth) / step_length_;
    Slack allowed{.velocity = velocity};
    const auto force = [&](std::size_t row) {
      return velocity / (step_length_ * held_.response_of(row));
    };
    if (contact_.tip_held) { allowed.tip = force(0); }
    if (contact_.shaft_held) { allowed.shaft = force(contact_.tip_held ? 1 : 0); }
    return allowed;
  }
  /// Predicts whether the tip cuts in an implicit step. The force of a sticking tip is extrapolated
  /// from the last step. A tip that begins to stick must accelerate the tissue to its own velocity,
  /// with the known compliance. If the predicted force exceeds F_c, the step begins with a cutting
  /// tip, which avoids a second solve; update_active_set() corrects a wrong prediction.
  void predict_cutting() noexcept {
    if (tip_ != TipMode::stuck || !held_.learned() || !(contact_.tip_tip > 0.0)) { return; }
    const double response =
        held_.response_at(at_.knot, at_.share, n_) + tool_mobility() + step_softness();
    const double more = stuck_before_ ? step_tip_change_ : stopped_ / (step_length_ * response);
    if (step_tip_force_ + more > strength()) { tip_ = TipMode::cutting; }
  }
  /// Updates the constraint of the tip; `rate` is its velocity relative to the tissue at the end of
  /// the step [m/s].
  bool update_tip(double rate, const Slack& slack) noexcept {
    const TipMode before = tip_;
    switch (tip_) {
      case TipMode::outside: break;
      case TipMode::stuck:
        if (!contact_.tip_held) { break; }
        if (tip_force_ > strength() + slack.tip) { tip_ = TipMode::cutting; }
        if (tip_force_ < -slack.tip) { tip_ = TipMode::in_track; }
        break;
      case TipMode::cutting:
      case TipMode::in_track:
        if (softness_ > 0.0) {  // the condition that a sticking tip would violate
          const double length = slack.velocity * step_length_;
          const bool sticks =
              tip_ == TipMode::cutting
                  ? gap_beyond(cutting_force()) < -length
                  : gap_beyond(0.0) - residual_gap(theta_ * step_length_) > length &&
                        depth_begin_ >= cut_;
          tip_ = sticks ? TipMode::stuck : tip_;
        } else if (tip_ == TipMode::cutting ? rate < -slack.velocity
                                            : rate > slack.velocity && depth_begin_ >= cut_) {
          tip_ = contact_.tip_tip > 0.0 ? TipMode::stuck : tip_;
        }
        break;
    }
    return tip_ != before;
  }
  bool update_shaft(double slip, const Slack& slack) noexcept {
    if (!may_hold_shaft()) { return false; }
    const ShaftMode before = shaft_;
    if (shaft_ == ShaftMode::stick) {
      if (contact_.shaft_held && std::abs(shaft_force_) > limit_ + slack.shaft) {
        shaft_ = shaft_force_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
      }
    } else if (shaft_ == ShaftMode::forward ? slip < -slack.velocity : slip > slack.velocity) {
      shaft_ = ShaftMode::stick;
    }
    return shaft_ != before;
  }
  void change_shaft() noexcept {
    if (!(limit_ > 0.0)) {
      shaft_ = ShaftMode::stick;
      shaft_force_ = 0.0;
      slip_ = 0.0;
      return;
    }
    slip_ = slip_now();
    const bool turned = (shaft_ == ShaftMode::forward && slip_ <= 0.0) ||
                        (shaft_ == ShaftMode::backward && slip_ >= 0.0);
    if (turned) {
      shaft_ = ShaftMode::stick;
    } else if (shaft_ == ShaftMode::stick && !contact_.shaft_held) {
      // The slip follows the force that exceeded the limit, because its own value is still rounding
      // error. A shaft that has just reached tissue was not sticking.
      const double sense = may_hold_shaft() && shaft_force_ != 0.0 ? shaft_force_ : slip_;
      shaft_ = sense > 0.0 ? ShaftMode::forward : ShaftMode::backward;
    }
  }
  /// Sets the shaft's mode after a jump of the drive. The shaft slides in the direction of motion,
  /// or sticks if its limited friction can stop the slip within the step.
  void turn_shaft(double h) noexcept {
    slip_ = limit_ > 0.0 ? slip_now() : 0.0;
    const bool rests = may_hold_shaft() && std::abs(slip_) <= limit_ * contact_.shaft_shaft * h;
    contact_.shaft_held = rests;
    if (rests) {
      shaft_ = ShaftMode::stick;
    } else if (slip_ != 0.0) {
      shaft_ = slip_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
    }
  }
  [[nodiscard]] double slip_now() const noexcept {
    return relative_to_tissue(velocity_, velocity_, &Knot::velocity)[1];
  }
  /// Reports that the tip begins to cut an interval, once for each interval and in order.
  void enter(std::size_t interval, double t) noexcept {
    for (std::size_t next = entered_ ? deepest_ + 1 : 0; next <= interval; ++next) {
      const TissueRole role = path_.intervals()[next].role;
      happen(t,
             role == TissueRole::epidural_space ? ToolEvent::loss_of_resistance
             : role == TissueRole::dura         ? ToolEvent::dural_puncture
                                                : ToolEvent::puncture,
             next);
      deepest_ = next;
      entered_ = true;
    }
  }
  /// Power of the tip relative to the tissue, of which the pressed tissue stores a part, and
  /// dissipated power of friction [W].
  [[nodiscard]] Eigen::Vector2d dissipated_power() const noexcept {
    const double slip = slip_now();
    return {pressing_force() * (velocity_ - velocity_at(at_)),
            shaft_ == ShaftMode::stick ? 0.0 : limit_ * std::abs(slip)};
  }
  /// Cutting force F_c at the tip; its interval changes only between steps.
  [[nodiscard]] double cutting_force() const noexcept {
    return path_.intervals()[path_.interval_at(cut_)].cutting_force;
  }
  /// Force at which a sticking tip begins to cut: F_p in an interval that it has not cut before,
  /// F_c at the end of its own track.
  [[nodiscard]] double strength() const noexcept {
    const std::size_t here = path_.interval_at(cut_);
    const PathInterval& interval = path_.intervals()[here];
    return entered_ && here <= deepest_ ? interval.cutting_force : interval.puncture_force;
  }
  [[nodiscard]] double tool_mobility() const noexcept {
    return is_coordinate() && !at_bone_ ? 1.0 / mass_ : 0.0;
  }
  /// Force of the hand on a tool with a coordinate [N].
  [[nodiscard]] double hand(double t) const noexcept {
    const double pushed = drive_.kind == Drive::Kind::force ? hand_force(drive_, t) : 0.0;
    return pushed + coupling_.stiffness * (handle_place_ - place_) +
           coupling_.viscosity * (handle_velocity_ - velocity_);
  }

  TipCompliance compliance_;
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
  std::vector<FaceColumn> columns_;    ///< of a sliding probe
  std::vector<double> share_;          ///< of the columns in the force of a sliding probe
  ConstraintCompliance<Real> held_{};  ///< used by implicit schemes only
  std::vector<double> shaft_share_;    ///< l_k / L
  std::vector<ShaftDrag> drags_{};     ///< intervals with creeping friction
  double limit_ = 0.0;                 ///< L [N]
  NeedlePath::Place at_{};             ///< position of the tip between the contact points
  Contact contact_{};
  double softness_ = 0.0;  ///< compliance at the tip's depth [m/N]
  double crept_ = 0.0;     ///< part of the gap that relaxation leaves without force [m]
  std::vector<Relaxation<double>> relaxation_{};  ///< of that tissue, for each interval
  double pressed_ = 0.0;                          ///< energy of that tissue [J]

  double tolerance_ = 0.0;  ///< relative tolerance of the solver
  bool predict_ = false;
  std::bitset<12> tried_{};  ///< modes that the present step was solved with
  double depth_rate_ = 0.0;
  /// Deceleration that tip and shaft need in an implicit step to stick [m/s^2].
  Eigen::Vector2d lag_{0.0, 0.0};
  Eigen::Vector2d dissipated_power_begin_{0.0, 0.0};

  Eigen::Vector3d sideways_{0.0, 0.0, 0.0};  ///< force of the tissue on the needle [N]
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Motion of the hand as linear segments: position [m] under a prescribed trajectory, else force
/// [N] (model/problem/scene.hpp, Drive). Only the references use it.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/problem/scene.hpp"
#include "reference/insertion.hpp"
#include "reference/needle_track.hpp"
#include "reference/network_equations.hpp"

namespace palpate::reference {

struct HandPiece {
  double start = 0.0;  ///< start of the segment, which lasts until the next one starts [s]
  double value = 0.0;  ///< at the start [m] or [N]
  double rate = 0.0;   ///< [m/s] or [N/s]

  [[nodiscard]] double at(double time) const { return value + rate * (time - start); }
};

/// Returns the segments from t = 0 to at least `end` [s], in ascending order, with different rates
/// or values.
std::vector<HandPiece> hand_motion(const Drive& drive, double end);

}  // namespace palpate::reference

namespace palpate::reference::insertion {

// Equation of motion between two events, with constraints eliminated at the level of accelerations.
// Private to reference/insertion*.cpp. y = [u; v; s; s'; work of the hand; loss in dampers,
// friction, cutting; z of springs and cells; z of the contact; F of creeping friction], u = q -
// q(0) of the free nodes. Along n the tip receives T and the shaft F_f. Contact points are
// orthogonal in M^-1, so the lateral lock is independent of both.

enum class Tip { outside, stuck, cutting, in_track };
enum class Shaft { sticks, forward, backward };  ///< direction of slip through the tissue
enum class Support { hand, bone };               ///< determines the position of the tool

struct Mode {
  Tip tip = Tip::outside;
  Shaft shaft = Shaft::forward;
  Support support = Support::hand;
  std::size_t segment = 0;   ///< segment of the tip, between contact points segment and segment + 1
  std::size_t interval = 0;  ///< interval of the tip; for a stuck tip, the one to be cut next
  std::size_t stretch = 0;   ///< stretch of c_s in which the tip cuts
  double cut = 0.0;          ///< d [m] unless the tip cuts
  HandPiece hand{};
  double gate = 0.0;                         ///< activation time that selects the active loads [s]
  std::vector<Eigen::Vector3d> locked_at{};  ///< displacement across n of contact points 0, 1, ...
};

/// Contact quantities of a mode at one instant.
struct Contact {
  double depth = 0.0;                      ///< xi of the tip [m]
  double slip = 0.0;                       ///< s' - V(xi) [m/s]
  double shaft_slip = 0.0;                 ///< W [m/s]
  double capacity = 0.0;                   ///< L [N]
  double give = 0.0;                       ///< c_s at d of a stuck or cutting tip [m/N]
  double pressed_energy = 0.0;             ///< of the tissue between tip and contact point [J]
  double tip_force = 0.0;                  ///< T [N]
  double elastic_force = 0.0;              ///< T of a stuck tip before its relaxation [N]
  double shaft_force = 0.0;                ///< F_f of Coulomb [N]
  double creeping_force = 0.0;             ///< creeping friction [N]
  double bone_force = 0.0;                 ///< force on a tool that the hand presses on bone [N]
  double tool_acceleration = 0.0;          ///< s'' [m/s^2]
  double slip_rate = 0.0;                  ///< d/dt slip at a fixed depth [m/s^2]
  double shaft_slip_rate = 0.0;            ///< W' [m/s^2]
  double tip_mobility = 0.0;               ///< A_tt, including the tool [1/kg]
  double shaft_mobility = 0.0;             ///< A_ss [1/kg]
  double mixed_mobility = 0.0;             ///< A_ts [1/kg]
  Eigen::VectorXd tip_weights{};           ///< h_k at the tip [1]
  Eigen::VectorXd shaft_weights{};         ///< l_k / L [1]
  Eigen::Vector3d lateral{0.0, 0.0, 0.0};  ///< force on the needle [N]

  /// Returns true if the stuck tip and the shaft are one constraint: their
  /// common mobility matrix is numerically singular.
  [[nodiscard]] bool shaft_is_tip() const {
    return give == 0.0 && tip_mobility * shaft_mobility - mixed_mobility * mixed_mobility <
                              1e-6 * tip_mobility * shaft_mobility;
  }
};

/// Creeping friction in one interval at one instant (model/EQUATIONS.md, "Creeping friction").
struct CreepingShaft {
  double reached = 0.0;      ///< depth down to which the shaft counts [m]
  double limit = 0.0;        ///< L [N]
  double drag = 0.0;         ///< z [m]
  double lengthens = 0.0;    ///< dL over a change of `reached` [N/m]
  bool at_least = false;     ///< `reached` has its least value
  Eigen::VectorXd shares{};  ///< l_k / L
};

class Mechanics {
 public:
  Mechanics(const Scene& scene, const SpringNetwork& network, const Tolerance& tolerance,
            const InsertionOptions& options);

  [[nodiscard]] const NetworkProblem& problem() const { return problem_; }
  [[nodiscard]] const NeedleTrack& track() const { return track_; }
  [[nodiscard]] const Drive& drive() const { return drive_; }
  [[nodiscard]] bool pushes() const { return drive_.kind == Drive::Kind::force; }
  [[nodiscard]] Eigen::Index dof() const { return problem_.dof(); }
  [[nodiscard]] Eigen::Index size() const { return memory() + scales_.size(); }
  [[nodiscard]] Eigen::Index place() const { return 2 * dof(); }      ///< index of s
  [[nodiscard]] Eigen::Index speed() const { return 2 * dof() + 1; }  ///< index of s'
  [[nodiscard]] Eigen::Index work() const { return 2 * dof() + 2; }   ///< index of the hand's work
  /// Index of the first of the further states of relaxation and creeping friction.
  [[nodiscard]] Eigen::Index memory() const { return 2 * dof() + 6; }
  /// Typical values of the further states [N, Pa of cells].
  [[nodiscard]] const Eigen::VectorXd& memory_scales() const { return scales_; }
  /// Returns true if the energies are those of the insertion: relaxing tissue and creeping friction
  /// have no account.
  [[nodiscard]] bool has_energies() const { return scales_.size() == 0; }
  [[nodiscard]] double tool_mass() const { return tool_mass_; }  ///< [kg]; by force only
  /// Returns 1/m [1/kg], or 0 if the motion of the tool is prescribed.
  [[nodiscard]] double tool_mobility(const Mode& mode) const;
  [[nodiscard]] double mobility(std::size_t knot) const { return mobility_[knot]; }  ///< G_k
  /// Slip velocity below which a slip is an integration error [m/s].
  [[nodiscard]] double slip_error() const { return slip_error_; }
  [[nodiscard]] long evaluations() const { return evaluations_; }

  /// Returns the distance s - d - U(d) by which the tip is ahead of the contact point at the end of
  /// its cut [m].
  [[nodiscard]] double tip_lead(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Returns the distance by which a tip without force is ahead of its cut while the tissue
  /// recovers from its relaxation [m].
  [[nodiscard]] double residual_gap(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Returns how far a tip in its track is from the tissue at its end [m].
  [[nodiscard]] double track_left(const Mode& mode, const Eigen::VectorXd& y) const {
    return residual_gap(mode, y) - tip_lead(mode, y);
  }
  /// Forgets the relaxation of the contact.
  void forget_contact(Eigen::VectorXd& y) const;
  /// Returns by how much the shaft pulls the surface out along the needle [m], <= 0.
  [[nodiscard]] double pulled_surface(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Creeping friction at an instant.
  struct Dragged {
    double depth = 0.0;       ///< of the tip [m]
    Eigen::VectorXd force{};  ///< of each tissue [N]
  };
  [[nodiscard]] Dragged dragged(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Adapts creeping friction to the depth of a mode, which has changed at once since `before`.
  void reach(const Dragged& before, const Mode& mode, Eigen::VectorXd& y) const;
  /// Returns the slope of d + U(d) + gap(d, F_c) where the tip is in the track or cuts [1].
  [[nodiscard]] double pace(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Computes depth, slips and weights without forces, but T if the position gives it.
  [[nodiscard]] Contact kinematics(const Mode& mode, const Eigen::VectorXd& y) const;
  /// Computes the contact with forces, and dy if it is not null.
  Contact evaluate(double time, const Mode& mode, const Eigen::VectorXd& y, Eigen::VectorXd* dy);

  /// Returns the displacement or velocity of a contact point: `from` is the first index of u or v
  /// in y.
  [[nodiscard]] Eigen::Vector3d knot_mean(std::size_t knot, const Eigen::VectorXd& y,
                                          Eigen::Index from) const;
  /// Returns the displacement U_k of a contact point along n [m].
  [[nodiscard]] double knot_displacement(std::size_t knot, const Eigen::VectorXd& y) const;
  /// Adds an impulse or force on a contact point, times w_i / m_i, to the nodes at `from` of y.
  void push_knot(std::size_t knot, const Eigen::Vector3d& impulse, Eigen::VectorXd& y,
                 Eigen::Index from) const;
  [[nodiscard]] double stored_energy(double time, const Mode& mode, const Eigen::VectorXd& y) const;

 private:
  struct FreeNode {
    Eigen::Index coordinate = 0;
    double weight = 0.0;
    double per_mass = 0.0;  ///< w / m [1/kg]
  };
  [[nodiscard]] double depth_of(const Mode& mode, const Eigen::VectorXd& y) const;
  [[nodiscard]] double pace_at(const Mode& mode, double depth, const Eigen::VectorXd& y) const;
  [[nodiscard]] const std::vector<RelaxationBranch>& contact_branches(const Mode& mode) const;
  /// Returns what relaxation takes of the elastic force of the contact [N].
  [[nodiscard]] double relaxed_force(const Mode& mode, const Eigen::VectorXd& y) const;
  [[nodiscard]] CreepingShaft creeping_shaft(std::size_t interval, double depth,
                                             double force) const;
  /// Adds the forces of creeping friction to dy_, and their rates.
  void add_creeping(const Mode& mode, const Eigen::VectorXd& y, Contact& contact);
  void add_relaxation_of_contact(const Mode& mode, const Contact& contact,
                                 const Eigen::VectorXd& y);
  void add_shaft(const Mode& mode, Contact& contact) const;
  void free_acceleration(double time, const Mode& mode, const Eigen::VectorXd& y, Contact& contact);
  [[nodiscard]] double share_rate(const Mode& mode, const Contact& contact,
                                  const Eigen::VectorXd& y) const;
  void solve_forces(const Mode& mode, double slip_rate, double shaft_rate, Contact& contact) const;
  void add_powers(double time, const Mode& mode, const Contact& contact, const Eigen::VectorXd& y,
                  Eigen::VectorXd& dy);

  NetworkProblem problem_;
  NeedleTrack track_;
  Drive drive_{};
  InsertionOptions options_;
  double slip_error_ = 0.0;
  double tool_mass_ = 0.0;
  Eigen::VectorXd origin_;
  Eigen::VectorXd inverse_mass_;
  std::vector<std::vector<FreeNode>> supports_;  ///< free nodes of each contact point
  std::vector<Eigen::Vector3d> offset_;  ///< displacement of the contact points at t = 0 [m]
  std::vector<double> mobility_;
  std::unique_ptr<NetworkEquations<double>> relaxing_;  ///< null: the tissue does not relax
  std::size_t tissue_states_ = 0;
  std::size_t contact_states_ = 0;
  std::vector<std::size_t> creeping_;  ///< intervals with creeping friction
  Eigen::VectorXd scales_;
  State<double> state_, state_rate_;
  long evaluations_ = 0;
  Eigen::VectorXd position_, velocity_, force_, dy_, still_;
};

}  // namespace palpate::reference::insertion

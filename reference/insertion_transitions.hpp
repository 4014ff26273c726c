// SPDX-License-Identifier: MIT
#pragma once
/// Mode and impulse after an event. Private to reference/insertion*.cpp.

#include <set>
#include <vector>

#include "reference/insertion_mechanics.hpp"

namespace palpate::reference::insertion {

/// Tolerance of distances, slips (Mechanics::slip_error) and bounds of constraint forces. It
/// ensures that a root function that has just been zero starts positive in spite of rounding.
inline constexpr double band = 1e-12;        ///< [m]
inline constexpr double least_force = 1e-9;  ///< [N]

enum class Root {
  skin,             ///< outside: the gap closes
  puncture,         ///< stuck: T reaches F_c
  release,          ///< stuck: T reaches 0
  stop,             ///< cutting: the tip's slip ends
  track_end,        ///< in track: the tip reaches d
  skin_from_below,  ///< in track: the tip leaves
  knot_below,
  knot_above,
  interval_below,
  interval_above,
  shaft_stop,     ///< slipping: W reaches 0
  slip_forward,   ///< sticking: F_f reaches L
  slip_backward,  ///< sticking: F_f reaches -L
  bone,           ///< the tool reaches bone
  bone_left
};

/// Root function, which is positive while the mode lasts.
struct RootValue {
  Root root = Root::skin;
  double value = 0.0;
};

/// Returns the root functions of a mode, in a fixed order.
std::vector<RootValue> roots_of(double time, const Mode& mode, const Eigen::VectorXd& y,
                                Mechanics& mechanics);

/// Adds the effect of impulses at tip and shaft to tissue and tool: impulses on velocities (`from`
/// = dof()), or impulses times time on positions (`from` = 0).
void push_track(const Mechanics& mechanics, const Mode& mode, const Contact& now,
                const Eigen::Vector2d& push, Eigen::VectorXd& y, Eigen::Index from);

/// Returns the kind of event of the first cut of a layer.
InsertionEvent::Kind first_cut(TissueRole role);

/// Sequence of modes of one insertion, from contact to withdrawal.
class Transitions {
 public:
  Transitions(Mechanics& mechanics, const InsertionOptions& options);

  [[nodiscard]] const Mode& mode() const { return mode_; }
  [[nodiscard]] const std::vector<InsertionEvent>& events() const { return events_; }
  [[nodiscard]] double impact_loss() const { return impact_loss_; }
  [[nodiscard]] double largest_drift() const { return largest_drift_; }
  [[nodiscard]] double largest_slip() const { return largest_slip_; }

  /// Starts a new segment of the hand's motion, then calls settle().
  void begin_piece(double time, const HandPiece& hand, double gate, Eigen::VectorXd& y);
  /// Determines the mode and the velocities in y right after `fired`; repeats until no root
  /// function is negative.
  void settle(double time, std::set<Root> fired, Eigen::VectorXd& y);

 private:
  void change(double time, const std::set<Root>& fired, Eigen::VectorXd& y);
  void move_tool(double time, const std::set<Root>& fired, Eigen::VectorXd& y);
  void move_along(double time, const std::set<Root>& fired, Eigen::VectorXd& y);
  void arrive(double time, const std::set<Root>& fired, Eigen::VectorXd& y);
  void decide(double time, const std::set<Root>& fired, Eigen::VectorXd& y);
  void enter(double time, const Mode& next, Eigen::VectorXd& y);
  void lock_knots(double time, std::size_t count, Eigen::VectorXd& y);
  void strike(Eigen::VectorXd& y);
  void note_slip(const Eigen::VectorXd& y);
  void remove_drift(Eigen::VectorXd& y);
  void remove_slip(Eigen::VectorXd& y);
  [[nodiscard]] double tip_drift(const Contact& now, const Eigen::VectorXd& y) const;
  void log_cut(double time, Eigen::VectorXd& y);
  void log(InsertionEvent::Kind kind, double time, const Eigen::VectorXd& y);
  [[nodiscard]] std::vector<Tip> tips(const std::set<Root>& fired, const Contact& now) const;
  [[nodiscard]] std::vector<Shaft> shafts(const std::set<Root>& fired, const Mode& mode,
                                          const Contact& now) const;
  [[nodiscard]] Tip receding() const;

  Mechanics& mechanics_;
  InsertionOptions options_;
  double still_ = 0.0;  ///< speed below which the tool is at rest [m/s]
  Mode mode_{};
  std::vector<bool> punctured_;
  std::vector<InsertionEvent> events_{};
  double impact_loss_ = 0.0;
  double largest_drift_ = 0.0;
  double largest_slip_ = 0.0;
};

}  // namespace palpate::reference::insertion

// SPDX-License-Identifier: MIT
/// Sequence of modes of an insertion: CVODE over y of Mechanics, restarted at every event.

#include "reference/insertion.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "reference/insertion_mechanics.hpp"
#include "reference/sundials.hpp"

namespace palpate::reference {

namespace insertion {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Tolerance of distances, slips (Mechanics::slip_error) and bounds of constraint forces. It
/// ensures that a root function that has just been zero starts positive in spite of rounding.
inline constexpr double band = 1e-12;        ///< [m]
inline constexpr double least_force = 1e-9;  ///< [N]

enum class Root {
  skin,             ///< outside: the gap closes
  puncture,         ///< stuck: T reaches F_c
  release,          ///< stuck: T reaches 0
  stop,             ///< cutting: the tip's slip ends
  fold,             ///< cutting: the tip sinks on at the same s
  track_end,        ///< in track: the tip reaches d
  skin_from_below,  ///< in track: the tip leaves
  knot_below,
  knot_above,
  interval_below,
  interval_above,
  stretch_above,
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

/// Adds the roots of the tip; `strength` is the force at which a sticking tip begins to cut [N].
void add_tip_roots(const Mode& mode, const Contact& now, const Mechanics& mechanics,
                   const VectorXd& y, double strength, std::vector<RootValue>& roots) {
  const NeedleTrack& track = mechanics.track();
  const TrackInterval& part = track.intervals[mode.interval];
  const bool has_below = mode.segment + 1 < track.knots.size();
  const auto add_ahead = [&] {
    if (has_below) {
      roots.push_back({Root::knot_above, track.knots[mode.segment + 1].depth - now.depth + band});
    }
    if (std::isfinite(part.end)) {
      roots.push_back({Root::interval_above, part.end - now.depth + band});
    }
  };
  switch (mode.tip) {
    case Tip::outside: break;
    case Tip::stuck:
      if (std::isfinite(strength)) {
        const double excess = now.give > 0.0 ? least_force : 0.0;  // T is continuous with c_s
        roots.push_back({Root::puncture, strength + excess - now.tip_force});
      }
      roots.push_back({Root::release, now.tip_force + least_force});
      break;
    case Tip::cutting:
      roots.push_back({Root::stop, now.slip + mechanics.slip_error()});
      add_ahead();
      if (now.give > 0.0) {
        roots.push_back({Root::fold, mechanics.pace(mode, y)});
        const double end = track.stretch_end(mode.stretch);
        if (std::isfinite(end)) { roots.push_back({Root::stretch_above, end - now.depth + band}); }
      }
      break;
    case Tip::in_track:
      roots.push_back({Root::track_end, mechanics.track_left(mode, y) + band});
      add_ahead();
      if (mode.segment > 0) {
        roots.push_back({Root::knot_below, now.depth - track.knots[mode.segment].depth + band});
      } else {
        const double surface = track.entry() + mechanics.pulled_surface(mode, y);
        roots.push_back({Root::skin_from_below, now.depth - surface + band});
      }
      if (mode.interval > 0) {
        roots.push_back({Root::interval_below, now.depth - part.begin + band});
      }
  }
}

void add_shaft_roots(const Mode& mode, const Contact& now, double slip_band,
                     std::vector<RootValue>& roots) {
  if (mode.tip == Tip::outside || (mode.tip == Tip::stuck && now.shaft_is_tip())) { return; }
  if (mode.shaft == Shaft::sticks) {
    roots.push_back({Root::slip_forward, now.capacity + least_force - now.shaft_force});
    roots.push_back({Root::slip_backward, now.capacity + least_force + now.shaft_force});
  } else {
    const double along = mode.shaft == Shaft::forward ? now.shaft_slip : -now.shaft_slip;
    roots.push_back({Root::shaft_stop, along + slip_band});
  }
}

/// Returns the root functions of a mode, in a fixed order; `strength` as for add_tip_roots().
std::vector<RootValue> roots_of(double time, const Mode& mode, const Eigen::VectorXd& y,
                                Mechanics& mechanics, double strength) {
  const NeedleTrack& track = mechanics.track();
  const bool on_bone = mode.support == Support::bone;
  const bool rigid = mode.tip == Tip::stuck && track.give.empty();
  const bool needs_forces = rigid || (on_bone && mechanics.pushes()) ||
                            (mode.tip != Tip::outside && mode.shaft == Shaft::sticks);
  const Contact now =
      needs_forces ? mechanics.evaluate(time, mode, y, nullptr) : mechanics.kinematics(mode, y);
  std::vector<RootValue> roots;
  const double place = y(mechanics.place());
  if (mode.tip == Tip::outside) {
    const double gap = track.entry() + mechanics.knot_displacement(0, y) - place;
    roots.push_back({Root::skin, gap + mechanics.residual_gap(mode, y) + band});
  }
  add_tip_roots(mode, now, mechanics, y, strength, roots);
  add_shaft_roots(mode, now, mechanics.slip_error(), roots);
  if (on_bone) {
    const double left = mechanics.pushes() ? now.bone_force + least_force
                                           : mode.hand.at(time) - track.bone + 2.0 * band;
    roots.push_back({Root::bone_left, left});
  } else if (std::isfinite(track.bone)) {
    roots.push_back({Root::bone, track.bone - place + band});
  }
  return roots;
}

/// Returns the kind of event of the first cut of a layer.
const char* first_cut(TissueRole role) {
  if (role == TissueRole::epidural_space) { return "loss-of-resistance"; }
  return role == TissueRole::dura ? "dural-puncture" : "puncture";
}

/// Adds the effect of impulses at tip and shaft to tissue and tool: impulses on velocities (`from`
/// = dof()), or impulses times time on positions (`from` = 0).
void push_track(const Mechanics& mechanics, const Mode& mode, const Contact& now,
                const Eigen::Vector2d& push, VectorXd& y, Eigen::Index from) {
  for (std::size_t k = 0; k < mechanics.track().knots.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double share = push(0) * now.tip_weights(i) + push(1) * now.shaft_weights(i);
    if (share != 0.0) { mechanics.push_knot(k, share * mechanics.track().direction, y, from); }
  }
  const Eigen::Index tool = from == 0 ? mechanics.place() : mechanics.speed();
  y(tool) -= mechanics.tool_mobility(mode) * push.sum();
}

/// Returns the impulses at tip and shaft [N s] that stop their slips.
Eigen::Vector2d impulses(const Contact& now, bool tip, bool shaft) {
  if (tip && shaft) {
    const double gram =
        now.tip_mobility * now.shaft_mobility - now.mixed_mobility * now.mixed_mobility;
    return {(now.shaft_mobility * now.slip - now.mixed_mobility * now.shaft_slip) / gram,
            (now.tip_mobility * now.shaft_slip - now.mixed_mobility * now.slip) / gram};
  }
  return {tip ? now.slip / now.tip_mobility : 0.0,
          shaft ? now.shaft_slip / now.shaft_mobility : 0.0};
}

/// Returns the violation of the condition of a tip mode [m/s^2].
double tip_violation(Tip tip, const Contact& now, double strength) {
  switch (tip) {
    case Tip::stuck:
      return now.tip_mobility *
             std::max({0.0, -now.tip_force - least_force, now.tip_force - strength});
    case Tip::cutting: return std::max(0.0, -now.slip_rate);
    case Tip::outside:
    case Tip::in_track: return std::max(0.0, now.slip_rate);
  }
  return 0.0;
}

double shaft_violation(Shaft shaft, const Contact& now) {
  switch (shaft) {
    case Shaft::sticks:
      return now.shaft_mobility *
             std::max(0.0, std::abs(now.shaft_force) - now.capacity - least_force);
    case Shaft::forward: return std::max(0.0, -now.shaft_slip_rate);
    case Shaft::backward: return std::max(0.0, now.shaft_slip_rate);
  }
  return 0.0;
}

/// Sequence of modes of one insertion, from contact to withdrawal.
class Transitions {
 public:
  Transitions(Mechanics& mechanics, const InsertionOptions& options)
      : mechanics_(mechanics),
        options_(options),
        still_(std::min(1e3 * mechanics.slip_error(), 1e-6)),
        punctured_(mechanics.track().intervals.size(), false) {
    mode_.cut = mechanics.track().entry();
  }

  [[nodiscard]] const Mode& mode() const { return mode_; }
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  [[nodiscard]] double impact_loss() const { return impact_loss_; }
  [[nodiscard]] const InsertionChecks& checks() const { return checks_; }

  /// Starts a new segment of the hand's motion, then calls settle().
  void begin_piece(double time, const HandPiece& hand, double gate, VectorXd& y) {
    if (time > 0.0) { note_slip(y); }
    mode_.hand = hand;
    mode_.gate = gate;
    if (!mechanics_.pushes() && mode_.support == Support::hand) {
      y(mechanics_.place()) = hand.at(time);
      y(mechanics_.speed()) = hand.rate;
    }
    std::set<Root> fired;
    if (time == 0.0) {
      const double gap =
          mechanics_.track().entry() + mechanics_.knot_displacement(0, y) - y(mechanics_.place());
      if (gap < -1e-9) { throw SolverError("insertion: the tool begins inside the tissue"); }
      if (gap <= band && mechanics_.kinematics(mode_, y).slip >= 0.0) { fired.insert(Root::skin); }
    }
    settle(time, fired, y);
  }

  /// Determines the mode and the velocities in y right after `fired`; repeats until no root
  /// function is negative.
  void settle(double time, std::set<Root> fired, VectorXd& y) {
    constexpr int most_changes = 50;
    if (time > 0.0 && !fired.empty()) { note_slip(y); }
    remove_drift(y);
    const Mechanics::Dragged before = mechanics_.dragged(mode_, y);
    for (int n = 0; n < most_changes; ++n) {
      change(time, fired, y);
      mechanics_.reach(before, mode_, y);  // modes that are only tried rub on nothing
      remove_drift(y);
      remove_slip(y);
      fired.clear();
      for (const RootValue& root : roots_of(time, mode_, y, mechanics_, strength())) {
        if (root.value < 0.0) { fired.insert(root.root); }
      }
      if (fired.empty()) { return; }
    }
    throw SolverError("insertion: the modes do not settle at t = " + std::to_string(time) + " s");
  }

  /// Returns the force at which a sticking tip begins to cut, or an advancing one enters the
  /// interval of the mode [N].
  [[nodiscard]] double strength() const {
    const TrackInterval& part = mechanics_.track().intervals[mode_.interval];
    return punctured_[mode_.interval] ? part.cutting_force : part.puncture_force;
  }

 private:
  void log(const char* kind, double time, const VectorXd& y) {
    if (static_cast<long>(events_.size()) >= options_.event_limit) {
      throw SolverError("insertion: more than " + std::to_string(options_.event_limit) +
                        " events before t = " + std::to_string(time) + " s");
    }
    events_.push_back({time, kind, mechanics_.track().intervals[mode_.interval].label});
    checks_.event_depth.push_back(mechanics_.kinematics(mode_, y).depth);
  }

  void change(double time, const std::set<Root>& fired, VectorXd& y) {
    remove_drift(y);
    move_tool(time, fired, y);
    move_along(time, fired, y);
    arrive(time, fired, y);
    decide(time, fired, y);
  }

  void move_tool(double time, const std::set<Root>& fired, VectorXd& y) {
    if (fired.contains(Root::bone)) {
      const double speed = y(mechanics_.speed());
      if (mechanics_.pushes()) { impact_loss_ += 0.5 * mechanics_.tool_mass() * speed * speed; }
      mode_.support = Support::bone;
      y(mechanics_.place()) = mechanics_.track().bone;
      y(mechanics_.speed()) = 0.0;
      log("bone-contact", time, y);
    }
    if (fired.contains(Root::bone_left)) {
      mode_.support = Support::hand;
      if (!mechanics_.pushes()) {
        y(mechanics_.place()) = mode_.hand.at(time);
        y(mechanics_.speed()) = mode_.hand.rate;
      }
      log("bone-left", time, y);
    }
  }

  void move_along(double time, const std::set<Root>& fired, VectorXd& y) {
    const auto& intervals = mechanics_.track().intervals;
    if (mode_.tip == Tip::cutting && !mechanics_.track().give.empty()) {
      sink(time, y);
      return;
    }
    if (fired.contains(Root::knot_above)) {
      ++mode_.segment;
      lock_knots(time, mode_.segment + 1, y);
    }
    if (fired.contains(Root::knot_below)) {
      lock_knots(time, mode_.segment, y);
      --mode_.segment;
    }
    if (fired.contains(Root::interval_below)) { --mode_.interval; }
    if (fired.contains(Root::interval_above)) {
      const double before = intervals[mode_.interval].cutting_force;
      const double depth = mechanics_.kinematics(mode_, y).depth;
      ++mode_.interval;
      const bool resists = strength() > before;
      if (mode_.tip == Tip::cutting && resists) {
        mode_.tip = Tip::stuck;
        mode_.cut = depth;
        log("stopped", time, y);
      } else if (mode_.tip == Tip::cutting) {
        log_cut(time, y);
      }
    }
    if (fired.contains(Root::skin_from_below)) {
      log("withdrawn", time, y);
      mode_.tip = Tip::outside;
      lock_knots(time, 0, y);
      mode_.segment = 0;
      mode_.interval = 0;
    }
  }

  /// Moves a tip that cuts to the first depth at or beyond its own at which
  /// d + U(d) + c_s(d) F_c = s, or to the beginning of a layer that resists more.
  void sink(double time, VectorXd& y) {
    const NeedleTrack& track = mechanics_.track();
    for (;;) {
      const double knot = mode_.segment + 1 < track.knots.size()
                              ? track.knots[mode_.segment + 1].depth
                              : std::numeric_limits<double>::infinity();
      const double stretch = track.stretch_end(mode_.stretch);
      const double border = track.intervals[mode_.interval].end;
      const double end = std::min({knot, stretch, border});
      const bool rises = mechanics_.pace(mode_, y) > 0.0;
      if (rises && mechanics_.kinematics(mode_, y).depth < end) { return; }
      if (!std::isfinite(end)) { throw SolverError("insertion: the tip sinks without end"); }
      if (knot == end) {
        ++mode_.segment;
        lock_knots(time, mode_.segment + 1, y);
      }
      if (stretch == end) { ++mode_.stretch; }
      if (border != end) { continue; }
      const double before = track.intervals[mode_.interval].cutting_force;
      ++mode_.interval;
      if (strength() > before) {
        mode_.tip = Tip::stuck;
        mode_.cut = end;
        log("stopped", time, y);
        return;
      }
      log_cut(time, y);
    }
  }

  void arrive(double time, const std::set<Root>& fired, VectorXd& y) {
    const NeedleTrack& track = mechanics_.track();
    if (fired.contains(Root::skin)) {
      const bool cut_before = mode_.cut > track.entry() + 2.0 * band;
      mode_.tip = cut_before ? Tip::in_track : Tip::stuck;
      log("contact", time, y);
      if (cut_before) { lock_knots(time, 1, y); }
    }
    if (fired.contains(Root::track_end)) {
      mode_.cut = std::max(mode_.cut, mechanics_.kinematics(mode_, y).depth);
      mode_.tip = Tip::stuck;
      if (track.intervals[mode_.interval].end - mode_.cut <= 2.0 * band) { ++mode_.interval; }
      log("returned", time, y);
    }
    strike(y);
  }

  /// Applies the smallest impulse that makes the stuck tip, and the shaft if it sticks, move with
  /// the tissue.
  void strike(VectorXd& y) {
    const Contact now = mechanics_.kinematics(mode_, y);
    const bool tip = is_rigid(now) && now.slip > still_;
    const bool shaft = options_.shaft_impact == InsertionOptions::ShaftImpact::plastic &&
                       mode_.tip != Tip::outside && mode_.shaft == Shaft::sticks &&
                       std::abs(now.shaft_slip) > still_ && !now.shaft_is_tip();
    if (!tip && !shaft) { return; }
    const Eigen::Vector2d given = impulses(now, tip, shaft);
    impact_loss_ += 0.5 * given.dot(Eigen::Vector2d(now.slip, now.shaft_slip));
    if (!mechanics_.pushes()) { y(mechanics_.work()) += given.sum() * y(mechanics_.speed()); }
    push_track(mechanics_, mode_, now, given, y, mechanics_.dof());
  }

  void lock_knots(double time, std::size_t count, VectorXd& y) {
    const Vector3d& n = mechanics_.track().direction;
    count = std::min(count, mechanics_.track().knots.size());
    while (mode_.locked_at.size() > count) {
      mode_.locked_at.pop_back();
      log("knot-let-go", time, y);
    }
    while (mode_.locked_at.size() < count) {
      const std::size_t k = mode_.locked_at.size();
      const Vector3d at = mechanics_.knot_mean(k, y, 0);
      mode_.locked_at.push_back(at - n.dot(at) * n);
      if (mechanics_.mobility(k) > 0.0) {
        const Vector3d velocity = mechanics_.knot_mean(k, y, mechanics_.dof());
        const Vector3d across = velocity - n.dot(velocity) * n;
        mechanics_.push_knot(k, -across / mechanics_.mobility(k), y, mechanics_.dof());
        impact_loss_ += 0.5 * across.squaredNorm() / mechanics_.mobility(k);
      }
      log("knot-passed", time, y);
    }
  }

  /// Returns true if the tip sticks to the contact point itself, which moves.
  [[nodiscard]] bool is_rigid(const Contact& now) const {
    return mode_.tip == Tip::stuck && now.give == 0.0 && now.tip_mobility > 0.0;
  }

  /// Records the velocity error of the constraints, which are enforced at the level of
  /// accelerations.
  void note_slip(const VectorXd& y) {
    const Contact now = mechanics_.kinematics(mode_, y);
    const bool tip = mode_.tip == Tip::stuck && now.give == 0.0;
    const bool shaft = mode_.tip != Tip::outside && mode_.shaft == Shaft::sticks;
    if (tip) { checks_.largest_slip = std::max(checks_.largest_slip, std::abs(now.slip)); }
    if (shaft) { checks_.largest_slip = std::max(checks_.largest_slip, std::abs(now.shaft_slip)); }
  }

  void remove_drift(VectorXd& y) {
    const Contact now = mechanics_.kinematics(mode_, y);
    if (is_rigid(now)) {
      const double drift = mechanics_.tip_lead(mode_, y);
      checks_.largest_drift = std::max(checks_.largest_drift, std::abs(drift));
      push_track(mechanics_, mode_, now, {drift / now.tip_mobility, 0.0}, y, 0);
    }
    const Vector3d& n = mechanics_.track().direction;
    for (std::size_t k = 0; k < mode_.locked_at.size(); ++k) {
      if (mechanics_.mobility(k) == 0.0) { continue; }
      Vector3d off = mechanics_.knot_mean(k, y, 0) - mode_.locked_at[k];
      off -= n.dot(off) * n;
      checks_.largest_drift = std::max(checks_.largest_drift, off.norm());
      mechanics_.push_knot(k, -off / mechanics_.mobility(k), y, 0);
    }
  }

  void remove_slip(VectorXd& y) {
    const Contact now = mechanics_.kinematics(mode_, y);
    const Eigen::Index speeds = mechanics_.dof();
    const bool tip = is_rigid(now);
    const bool shaft = mode_.tip != Tip::outside && mode_.shaft == Shaft::sticks &&
                       now.shaft_mobility > 0.0 && !(tip && now.shaft_is_tip());
    push_track(mechanics_, mode_, now, impulses(now, tip, shaft), y, speeds);
    const Vector3d& n = mechanics_.track().direction;
    for (std::size_t k = 0; k < mode_.locked_at.size(); ++k) {
      if (mechanics_.mobility(k) == 0.0) { continue; }
      Vector3d velocity = mechanics_.knot_mean(k, y, speeds);
      velocity -= n.dot(velocity) * n;
      mechanics_.push_knot(k, -velocity / mechanics_.mobility(k), y, speeds);
    }
  }

  [[nodiscard]] Tip receding() const {
    return mode_.cut > mechanics_.track().entry() + 2.0 * band ? Tip::in_track : Tip::outside;
  }

  /// Returns the modes of the tip that its velocity permits; among equal ones the first is
  /// preferred.
  [[nodiscard]] std::vector<Tip> tips(const std::set<Root>& fired, const Contact& now) const {
    const double strength = this->strength();
    const bool cutting = mode_.tip == Tip::cutting;
    if (!cutting && mode_.tip != Tip::stuck) { return {mode_.tip}; }
    if (now.give > 0.0) { return {pressing_tip(fired, now)}; }
    if (now.slip < -still_) { return {receding()}; }
    if (cutting && now.slip > 0.0 && !fired.contains(Root::stop)) { return {Tip::cutting}; }
    std::vector<Tip> open;
    const bool leaves = fired.contains(Root::puncture) || fired.contains(Root::release);
    const bool can_stick = now.tip_mobility > 0.0 && (!cutting || strength > 0.0);
    if (can_stick && !leaves) { open.push_back(Tip::stuck); }
    if (std::isfinite(strength) && !fired.contains(Root::release) && !fired.contains(Root::stop)) {
      open.push_back(Tip::cutting);
    }
    if (!fired.contains(Root::puncture)) { open.push_back(receding()); }
    return open;
  }

  /// Returns the mode of a tip that presses on the tissue between it and the contact point: T is
  /// continuous, so positions and velocities determine it.
  [[nodiscard]] Tip pressing_tip(const std::set<Root>& fired, const Contact& now) const {
    if (mode_.tip == Tip::cutting) {
      const bool stops = fired.contains(Root::stop) || now.slip < 0.0;
      return !stops ? Tip::cutting : strength() > 0.0 ? Tip::stuck : receding();
    }
    if (fired.contains(Root::release)) { return receding(); }
    return fired.contains(Root::puncture) ? Tip::cutting : Tip::stuck;
  }

  [[nodiscard]] std::vector<Shaft> shafts(const std::set<Root>& fired, const Mode& mode,
                                          const Contact& now) const {
    const Shaft by_sign = now.shaft_slip < 0.0 ? Shaft::backward : Shaft::forward;
    if (std::abs(now.shaft_slip) > still_ || mode.tip == Tip::outside) { return {by_sign}; }
    if (now.capacity == 0.0) { return {mode.tip == Tip::cutting ? Shaft::forward : by_sign}; }
    if (now.shaft_mobility == 0.0 || (mode.tip == Tip::stuck && now.shaft_is_tip())) {
      return {mode_.shaft == Shaft::backward ? Shaft::backward : Shaft::forward};
    }
    const bool stopped = fired.contains(Root::shaft_stop);
    if (mode_.shaft != Shaft::sticks && mode_.shaft == by_sign && !stopped) { return {by_sign}; }
    if (fired.contains(Root::slip_forward)) { return {Shaft::forward}; }
    if (fired.contains(Root::slip_backward)) { return {Shaft::backward}; }
    if (!stopped) { return {Shaft::sticks, Shaft::forward, Shaft::backward}; }
    return {Shaft::sticks, mode_.shaft == Shaft::forward ? Shaft::backward : Shaft::forward};
  }

  /// Selects, among the modes that velocities permit, the one whose forces and accelerations
  /// satisfy its own conditions. It is unique up to ties, because the Gram matrix is positive
  /// definite.
  void decide(double time, const std::set<Root>& fired, VectorXd& y) {
    if (mode_.tip == Tip::outside) {
      mode_.shaft = Shaft::forward;
      return;
    }
    const Contact now = mechanics_.kinematics(mode_, y);
    const std::vector<Tip> open = tips(fired, now);
    if (open.empty()) {
      throw SolverError("insertion: the tip meets fixed nodes that it cannot cut");
    }
    Mode best;
    double least = std::numeric_limits<double>::infinity();
    const double enough = least_force * std::max(now.tip_mobility, now.shaft_mobility);
    for (const Tip tip : open) {
      Mode trial = mode_;
      trial.tip = tip;
      trial.cut = mode_.tip == Tip::cutting ? now.depth : mode_.cut;
      if (mode_.tip != Tip::cutting) { trial.stretch = mechanics_.track().stretch_at(mode_.cut); }
      const std::vector<Shaft> ways = shafts(fired, trial, now);
      for (const Shaft shaft : ways) {
        trial.shaft = shaft;
        const Contact then = mechanics_.evaluate(time, trial, y, nullptr);
        double violation = open.size() > 1 ? tip_violation(tip, then, strength()) : 0.0;
        if (ways.size() > 1) { violation = std::max(violation, shaft_violation(shaft, then)); }
        if (least > enough && violation < least) {
          least = violation;
          best = trial;
        }
      }
    }
    if (!std::isfinite(least)) { throw SolverError("insertion: the forces are not finite"); }
    enter(time, best, y);
  }

  void enter(double time, const Mode& next, VectorXd& y) {
    const Tip before = mode_.tip;
    const Shaft shaft_before = mode_.shaft;
    mode_ = next;
    if (mode_.tip != before) {
      switch (mode_.tip) {
        case Tip::stuck: log("stopped", time, y); break;
        case Tip::in_track: log("released", time, y); break;
        case Tip::outside: log("withdrawn", time, y); break;
        case Tip::cutting: log_cut(time, y); break;
      }
    }
    const double capacity = mechanics_.kinematics(mode_, y).capacity;
    if (mode_.tip == Tip::outside || capacity <= least_force) { return; }
    const bool sticks = mode_.shaft == Shaft::sticks;
    if (sticks != (shaft_before == Shaft::sticks)) {
      log(sticks ? "shaft-sticks" : "shaft-slips", time, y);
    }
  }

  void log_cut(double time, VectorXd& y) {
    mechanics_.forget_contact(y);
    const TissueRole role = mechanics_.track().intervals[mode_.interval].role;
    const char* kind = punctured_[mode_.interval] ? "cut-resumed" : first_cut(role);
    punctured_[mode_.interval] = true;
    log(kind, time, y);
    lock_knots(time, mode_.segment + 1, y);
  }

  Mechanics& mechanics_;
  InsertionOptions options_;
  double still_ = 0.0;  ///< speed below which the tool is at rest [m/s]
  Mode mode_{};
  std::vector<bool> punctured_;
  std::vector<Event> events_{};
  double impact_loss_ = 0.0;
  InsertionChecks checks_{};
};

/// Returns the instants at which the hand's motion or a load has a kink, from 0 to `end` inclusive.
std::vector<double> stops_until(double end, const std::vector<HandPiece>& hand,
                                const std::vector<double>& loads) {
  std::vector<double> stops{0.0, end};
  for (const HandPiece& piece : hand) { stops.push_back(piece.start); }
  stops.insert(stops.end(), loads.begin(), loads.end());
  std::ranges::sort(stops);
  std::erase_if(stops, [end](double t) { return t > end; });
  // A solver cannot distinguish stops that are closer than this.
  const auto same = [end](double a, double b) { return b - a <= 1e-13 * end; };
  stops.erase(std::unique(stops.begin(), stops.end(), same), stops.end());
  return stops;
}

const HandPiece& piece_at(const std::vector<HandPiece>& hand, double time) {
  const auto after = std::ranges::upper_bound(hand, time, {}, &HandPiece::start);
  return after == hand.begin() ? hand.front() : *(after - 1);
}

void check_times(const std::vector<double>& times) {
  const bool ascend = std::ranges::adjacent_find(times, std::greater_equal<>()) == times.end();
  if (times.empty() || times.front() != 0.0 || !ascend) {
    throw SolverError("insertion: the requested times must ascend from 0 s");
  }
}

VectorXd absolute_tolerances(const Mechanics& mechanics, const Tolerance& tolerance) {
  constexpr double energy_scale = 1e-2;  // work of some newtons over some millimetres [J]
  const Index n = mechanics.dof();
  VectorXd scales(mechanics.size());
  scales << VectorXd::Constant(n, tolerance.position_scale),
      VectorXd::Constant(n, tolerance.velocity_scale), tolerance.position_scale,
      tolerance.velocity_scale, VectorXd::Constant(4, energy_scale), mechanics.memory_scales();
  return tolerance.relative * scales;
}

/// Solution of one insertion from 0 to the last requested time: CVODE over y of Mechanics,
/// restarted at every event.
class Run {
 public:
  Run(const Scene& scene, const SpringNetwork& network, const std::vector<double>& times,
      const Tolerance& tolerance, const InsertionOptions& options)
      : times_(times),
        apart_(1e-13 * times.back()),
        mechanics_(scene, network, tolerance, options),
        transitions_(mechanics_, options),
        longest_step_(options.longest_step),
        y_(VectorXd::Zero(mechanics_.size())),
        cvode_("insertion", CV_ADAMS, y_, tolerance.relative,
               absolute_tolerances(mechanics_, tolerance),
               [this](double t, const double* y, double* dy) {
                 trial_ = VectorXd::Map(y, y_.size());
                 mechanics_.evaluate(t, transitions_.mode(), trial_, &rate_);
                 VectorXd::Map(dy, rate_.size()) = rate_;
                 return rate_.allFinite();
               }) {
    y_.segment(mechanics_.dof(), mechanics_.dof()) = mechanics_.problem().initial_velocity();
    y_(mechanics_.place()) = mechanics_.drive().from;
    trace_ = {.method = "insertion", .version = sundials::version()};
    trace_.relative_tolerance = tolerance.relative;
    trace_.position.resize(mechanics_.dof(), static_cast<Index>(times.size()));
    trace_.velocity.resizeLike(trace_.position);
  }

  Trace solve(InsertionChecks* checks) {
    const std::vector<HandPiece> hand = hand_motion(mechanics_.drive(), times_.back());
    const auto stops = stops_until(times_.back(), hand, mechanics_.problem().breaks());
    for (std::size_t n = 0; n + 1 < stops.size(); ++n) {
      const double middle = 0.5 * (stops[n] + stops[n + 1]);
      transitions_.begin_piece(stops[n], piece_at(hand, middle), middle, y_);
      if (n == 0) { record(); }
      integrate_piece(stops[n], stops[n + 1]);
    }
    if (trace_.time.empty()) {  // only 0 s was requested
      transitions_.begin_piece(0.0, piece_at(hand, 0.0), 0.0, y_);
      record();
    }
    trace_.events = transitions_.events();
    trace_.steps = steps_ + cvode_.steps();
    trace_.evaluations = mechanics_.evaluations();
    if (checks != nullptr) { *checks = transitions_.checks(); }
    return std::move(trace_);
  }

 private:
  [[nodiscard]] bool due(double time) const {
    return trace_.rows() < times_.size() && times_[trace_.rows()] <= time + apart_;
  }

  void record() {
    const double time = times_[trace_.rows()];
    const Mode& mode = transitions_.mode();
    const Contact now = mechanics_.evaluate(time, mode, y_, nullptr);
    const Index n = mechanics_.dof();
    const double place = y_(mechanics_.place());
    const double speed = y_(mechanics_.speed());
    const bool cuts = mode.tip == Tip::cutting;
    const double hand = mode.hand.at(time);
    const double cutting = cuts ? now.tip_force : 0.0;
    double stiffness = cuts ? 0.0 : now.tip_force;
    stiffness += now.bone_force;
    if (mode.support == Support::bone && !mechanics_.pushes()) {
      stiffness += mechanics_.drive().grip_stiffness * (hand - place);
    }
    const double friction = now.shaft_force + now.creeping_force;
    const double total = cutting + friction + stiffness;
    const double applied =
        mechanics_.pushes() ? hand - mechanics_.drive().hand_viscosity * speed : total;
    const auto work = y_.segment<4>(mechanics_.work());
    const bool first = trace_.columns.empty();
    std::size_t next = 0;
    const auto add = [&](const char* name, const char* unit, double value) {
      if (first) { trace_.columns.push_back({name, unit, {}}); }
      trace_.columns[next++].values.push_back(value);
    };
    add("tool.insertion_m", "m", place);
    add("tool.velocity_m_per_s", "m/s", speed);
    add("tool.deepest_cut_m", "m", cuts ? now.depth : mode.cut);
    add("tool.tip_depth_m", "m", now.depth);
    add("tool.force_n", "N", total);
    add("tool.cutting_n", "N", cutting);
    add("tool.friction_n", "N", friction);
    add("tool.stiffness_n", "N", stiffness);
    add("tool.applied_n", "N", applied);
    add("tool.lateral_x_n", "N", now.lateral.x());
    add("tool.lateral_y_n", "N", now.lateral.y());
    add("tool.lateral_z_n", "N", now.lateral.z());
    if (mechanics_.has_energies()) {
      add("energy_j", "J", mechanics_.stored_energy(time, mode, y_));
      add("loss.hand_j", "J", work(0));
      add("loss.damping_j", "J", work(1));
      add("loss.friction_j", "J", work(2));
      add("loss.cutting_j", "J", work(3) - now.pressed_energy);
      add("loss.impact_j", "J", transitions_.impact_loss());
    }
    const auto column = static_cast<Index>(trace_.rows());
    trace_.position.col(column) = mechanics_.problem().initial_position() + y_.head(n);
    trace_.velocity.col(column) = y_.segment(n, n);
    trace_.time.push_back(time);
  }

  /// Restarts from y_ in the present mode; never integrates beyond `stop` [s].
  void restart(double time, double stop) {
    steps_ += cvode_.steps();
    cvode_.restart(time, stop, longest_step_, y_);
    roots_.clear();
    for (const RootValue& root :
         roots_of(time, transitions_.mode(), y_, mechanics_, transitions_.strength())) {
      roots_.push_back(root.root);
    }
    // Root functions are positive while the mode lasts, so only a downward crossing is an event.
    cvode_.set_falling_roots(roots_.size(), [this](double t, const double* y, double* values) {
      trial_ = VectorXd::Map(y, y_.size());
      for (const RootValue& root :
           roots_of(t, transitions_.mode(), trial_, mechanics_, transitions_.strength())) {
        *values++ = root.value;
      }
    });
  }

  /// Integrates to `goal` [s] or to the first event before it; returns the events.
  std::set<Root> advance(double goal) {
    std::set<Root> fired;
    const bool at_root = cvode_.evolve(goal);
    y_ = VectorXd::Map(cvode_.values(), y_.size());
    if (!at_root) { return fired; }
    for (const std::size_t n : cvode_.found_roots()) { fired.insert(roots_[n]); }
    return fired;
  }

  void integrate_piece(double start, double stop) {
    restart(start, stop);
    while (stop - cvode_.time() > apart_) {
      const double goal =
          trace_.rows() < times_.size() ? std::min(times_[trace_.rows()], stop) : stop;
      // An event may be too near to an instant for a step between them.
      const bool there = goal - cvode_.time() <= apart_;
      const std::set<Root> fired = there ? std::set<Root>{} : advance(goal);
      if (!fired.empty()) {
        transitions_.settle(cvode_.time(), fired, y_);
        if (stop - cvode_.time() > apart_) { restart(cvode_.time(), stop); }
      } else if (due(goal)) {
        record();
      }
    }
    while (due(stop)) { record(); }
  }

  const std::vector<double>& times_;
  double apart_ = 0.0;  ///< instants closer than this are merged [s]
  Mechanics mechanics_;
  Transitions transitions_;
  double longest_step_;
  VectorXd y_, trial_, rate_;
  std::vector<Root> roots_;
  sundials::Cvode cvode_;
  long steps_ = 0;
  Trace trace_{};
};

}  // namespace

}  // namespace insertion

Trace solve_insertion(const Scene& scene, const SpringNetwork& network,
                      const std::vector<double>& times, const Tolerance& tolerance,
                      const InsertionOptions& options, InsertionChecks* checks) {
  const auto begun = std::chrono::steady_clock::now();
  insertion::check_times(times);
  Trace trace = insertion::Run(scene, network, times, tolerance, options).solve(checks);
  trace.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return trace;
}

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT

#include "reference/insertion_transitions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace palpate::reference::insertion {

using Eigen::Vector3d;
using Eigen::VectorXd;
using Kind = InsertionEvent::Kind;

Kind first_cut(TissueRole role) {
  if (role == TissueRole::epidural_space) { return Kind::loss_of_resistance; }
  return role == TissueRole::dura ? Kind::dural_puncture : Kind::puncture;
}

namespace {

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

}  // namespace

Transitions::Transitions(Mechanics& mechanics, const InsertionOptions& options)
    : mechanics_(mechanics),
      options_(options),
      still_(std::min(1e3 * mechanics.slip_error(), 1e-6)),
      punctured_(mechanics.track().intervals.size(), false) {
  mode_.cut = mechanics.track().entry();
}

void Transitions::log(Kind kind, double time, const VectorXd& y) {
  if (static_cast<long>(events_.size()) >= options_.event_limit) {
    throw SolverError("insertion: more than " + std::to_string(options_.event_limit) +
                      " events before t = " + std::to_string(time) + " s");
  }
  events_.push_back({kind, time, y(mechanics_.place()), mechanics_.kinematics(mode_, y).depth,
                     mechanics_.track().intervals[mode_.interval].label});
}

void Transitions::begin_piece(double time, const HandPiece& hand, double gate, VectorXd& y) {
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

void Transitions::settle(double time, std::set<Root> fired, VectorXd& y) {
  constexpr int most_changes = 50;
  if (time > 0.0 && !fired.empty()) { note_slip(y); }
  for (int n = 0; n < most_changes; ++n) {
    change(time, fired, y);
    fired.clear();
    for (const RootValue& root : roots_of(time, mode_, y, mechanics_)) {
      if (root.value < 0.0) { fired.insert(root.root); }
    }
    if (fired.empty()) { return; }
  }
  throw SolverError("insertion: the modes do not settle at t = " + std::to_string(time) + " s");
}

void Transitions::change(double time, const std::set<Root>& fired, VectorXd& y) {
  remove_drift(y);
  move_tool(time, fired, y);
  move_along(time, fired, y);
  arrive(time, fired, y);
  decide(time, fired, y);
  remove_drift(y);
  remove_slip(y);
}

void Transitions::move_tool(double time, const std::set<Root>& fired, VectorXd& y) {
  if (fired.contains(Root::bone)) {
    const double speed = y(mechanics_.speed());
    if (mechanics_.pushes()) { impact_loss_ += 0.5 * mechanics_.tool_mass() * speed * speed; }
    mode_.support = Support::bone;
    y(mechanics_.place()) = mechanics_.track().bone;
    y(mechanics_.speed()) = 0.0;
    log(Kind::bone_contact, time, y);
  }
  if (fired.contains(Root::bone_left)) {
    mode_.support = Support::hand;
    if (!mechanics_.pushes()) {
      y(mechanics_.place()) = mode_.hand.at(time);
      y(mechanics_.speed()) = mode_.hand.rate;
    }
    log(Kind::bone_left, time, y);
  }
}

void Transitions::move_along(double time, const std::set<Root>& fired, VectorXd& y) {
  const auto& intervals = mechanics_.track().intervals;
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
    const bool resists = intervals[++mode_.interval].cutting_force > before;
    if (mode_.tip == Tip::cutting && resists) {
      mode_.tip = Tip::stuck;
      mode_.cut = depth;
      log(Kind::stopped, time, y);
    } else if (mode_.tip == Tip::cutting) {
      log_cut(time, y);
    }
  }
  if (fired.contains(Root::skin_from_below)) {
    log(Kind::withdrawn, time, y);
    mode_.tip = Tip::outside;
    lock_knots(time, 0, y);
    mode_.segment = 0;
    mode_.interval = 0;
  }
}

void Transitions::arrive(double time, const std::set<Root>& fired, VectorXd& y) {
  const NeedleTrack& track = mechanics_.track();
  if (fired.contains(Root::skin)) {
    const bool cut_before = mode_.cut > track.entry() + 2.0 * band;
    mode_.tip = cut_before ? Tip::in_track : Tip::stuck;
    log(Kind::contact, time, y);
    if (cut_before) { lock_knots(time, 1, y); }
  }
  if (fired.contains(Root::track_end)) {
    mode_.cut = std::max(mode_.cut, mechanics_.kinematics(mode_, y).depth);
    mode_.tip = Tip::stuck;
    if (track.intervals[mode_.interval].end - mode_.cut <= 2.0 * band) { ++mode_.interval; }
    log(Kind::returned, time, y);
  }
  strike(y);
}

/// Applies the smallest impulse that makes the stuck tip, and the shaft if it sticks, move with the
/// tissue.
void Transitions::strike(VectorXd& y) {
  const Contact now = mechanics_.kinematics(mode_, y);
  const bool tip = mode_.tip == Tip::stuck && now.slip > still_ && now.tip_mobility > 0.0;
  const bool shaft = options_.shaft_impact == InsertionOptions::ShaftImpact::plastic &&
                     mode_.tip != Tip::outside && mode_.shaft == Shaft::sticks &&
                     std::abs(now.shaft_slip) > still_ && !now.shaft_is_tip();
  if (!tip && !shaft) { return; }
  const Eigen::Vector2d given = impulses(now, tip, shaft);
  impact_loss_ += 0.5 * given.dot(Eigen::Vector2d(now.slip, now.shaft_slip));
  if (!mechanics_.pushes()) { y(mechanics_.work()) += given.sum() * y(mechanics_.speed()); }
  push_track(mechanics_, mode_, now, given, y, mechanics_.dof());
}

void Transitions::lock_knots(double time, std::size_t count, VectorXd& y) {
  const Vector3d& n = mechanics_.track().direction;
  count = std::min(count, mechanics_.track().knots.size());
  while (mode_.locked_at.size() > count) {
    mode_.locked_at.pop_back();
    log(Kind::knot_let_go, time, y);
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
    log(Kind::knot_passed, time, y);
  }
}

double Transitions::tip_drift(const Contact& now, const VectorXd& y) const {
  double place = mode_.cut;
  for (std::size_t k = mode_.segment; k < mechanics_.track().knots.size(); ++k) {
    const double h = now.tip_weights(static_cast<Eigen::Index>(k));
    if (h != 0.0) { place += h * mechanics_.knot_displacement(k, y); }
  }
  return y(mechanics_.place()) - place;
}

/// Records the velocity error of the constraints, which are enforced at the level of accelerations.
void Transitions::note_slip(const VectorXd& y) {
  const Contact now = mechanics_.kinematics(mode_, y);
  const bool tip = mode_.tip == Tip::stuck;
  const bool shaft = mode_.tip != Tip::outside && mode_.shaft == Shaft::sticks;
  if (tip) { largest_slip_ = std::max(largest_slip_, std::abs(now.slip)); }
  if (shaft) { largest_slip_ = std::max(largest_slip_, std::abs(now.shaft_slip)); }
}

void Transitions::remove_drift(VectorXd& y) {
  const Contact now = mechanics_.kinematics(mode_, y);
  if (mode_.tip == Tip::stuck && now.tip_mobility > 0.0) {
    const double drift = tip_drift(now, y);
    largest_drift_ = std::max(largest_drift_, std::abs(drift));
    push_track(mechanics_, mode_, now, {drift / now.tip_mobility, 0.0}, y, 0);
  }
  const Vector3d& n = mechanics_.track().direction;
  for (std::size_t k = 0; k < mode_.locked_at.size(); ++k) {
    if (mechanics_.mobility(k) == 0.0) { continue; }
    Vector3d off = mechanics_.knot_mean(k, y, 0) - mode_.locked_at[k];
    off -= n.dot(off) * n;
    largest_drift_ = std::max(largest_drift_, off.norm());
    mechanics_.push_knot(k, -off / mechanics_.mobility(k), y, 0);
  }
}

void Transitions::remove_slip(VectorXd& y) {
  const Contact now = mechanics_.kinematics(mode_, y);
  const Eigen::Index speeds = mechanics_.dof();
  const bool tip = mode_.tip == Tip::stuck && now.tip_mobility > 0.0;
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

using Eigen::VectorXd;
using Kind = InsertionEvent::Kind;

Tip Transitions::receding() const {
  return mode_.cut > mechanics_.track().entry() + 2.0 * band ? Tip::in_track : Tip::outside;
}

/// Returns the modes of the tip that its velocity permits; among equal ones the first is preferred.
std::vector<Tip> Transitions::tips(const std::set<Root>& fired, const Contact& now) const {
  const double strength = mechanics_.track().intervals[mode_.interval].cutting_force;
  const bool cutting = mode_.tip == Tip::cutting;
  if (!cutting && mode_.tip != Tip::stuck) { return {mode_.tip}; }
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

std::vector<Shaft> Transitions::shafts(const std::set<Root>& fired, const Mode& mode,
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

namespace {

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

}  // namespace

/// Selects, among the modes that velocities permit, the one whose forces and accelerations satisfy
/// its own conditions. It is unique up to ties, because the Gram matrix is positive definite.
void Transitions::decide(double time, const std::set<Root>& fired, VectorXd& y) {
  if (mode_.tip == Tip::outside) {
    mode_.shaft = Shaft::forward;
    return;
  }
  const Contact now = mechanics_.kinematics(mode_, y);
  const double strength = mechanics_.track().intervals[mode_.interval].cutting_force;
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
    const std::vector<Shaft> ways = shafts(fired, trial, now);
    for (const Shaft shaft : ways) {
      trial.shaft = shaft;
      const Contact then = mechanics_.evaluate(time, trial, y, nullptr);
      double violation = open.size() > 1 ? tip_violation(tip, then, strength) : 0.0;
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

void Transitions::enter(double time, const Mode& next, VectorXd& y) {
  const Tip before = mode_.tip;
  const Shaft shaft_before = mode_.shaft;
  mode_ = next;
  if (mode_.tip != before) {
    switch (mode_.tip) {
      case Tip::stuck: log(Kind::stopped, time, y); break;
      case Tip::in_track: log(Kind::released, time, y); break;
      case Tip::outside: log(Kind::withdrawn, time, y); break;
      case Tip::cutting: log_cut(time, y); break;
    }
  }
  const double capacity = mechanics_.kinematics(mode_, y).capacity;
  if (mode_.tip == Tip::outside || capacity <= least_force) { return; }
  const bool sticks = mode_.shaft == Shaft::sticks;
  if (sticks != (shaft_before == Shaft::sticks)) {
    log(sticks ? Kind::shaft_sticks : Kind::shaft_slips, time, y);
  }
}

void Transitions::log_cut(double time, VectorXd& y) {
  const TissueRole role = mechanics_.track().intervals[mode_.interval].role;
  const Kind kind = punctured_[mode_.interval] ? Kind::cut_resumed : first_cut(role);
  punctured_[mode_.interval] = true;
  log(kind, time, y);
  lock_knots(time, mode_.segment + 1, y);
}

namespace {

void add_tip_roots(const Mode& mode, const Contact& now, const NeedleTrack& track, double slip_band,
                   std::vector<RootValue>& roots) {
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
      if (std::isfinite(part.cutting_force)) {
        roots.push_back({Root::puncture, part.cutting_force - now.tip_force});
      }
      roots.push_back({Root::release, now.tip_force + least_force});
      break;
    case Tip::cutting:
      roots.push_back({Root::stop, now.slip + slip_band});
      add_ahead();
      break;
    case Tip::in_track:
      roots.push_back({Root::track_end, mode.cut - now.depth + band});
      add_ahead();
      if (mode.segment > 0) {
        roots.push_back({Root::knot_below, now.depth - track.knots[mode.segment].depth + band});
      } else {
        roots.push_back({Root::skin_from_below, now.depth - track.entry() + band});
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

}  // namespace

std::vector<RootValue> roots_of(double time, const Mode& mode, const Eigen::VectorXd& y,
                                Mechanics& mechanics) {
  const NeedleTrack& track = mechanics.track();
  const bool on_bone = mode.support == Support::bone;
  const bool needs_forces = mode.tip == Tip::stuck || (on_bone && mechanics.pushes()) ||
                            (mode.tip != Tip::outside && mode.shaft == Shaft::sticks);
  const Contact now =
      needs_forces ? mechanics.evaluate(time, mode, y, nullptr) : mechanics.kinematics(mode, y);
  std::vector<RootValue> roots;
  const double place = y(mechanics.place());
  if (mode.tip == Tip::outside) {
    const double gap = track.entry() + mechanics.knot_displacement(0, y) - place;
    roots.push_back({Root::skin, gap + band});
  }
  add_tip_roots(mode, now, track, mechanics.slip_error(), roots);
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

}  // namespace palpate::reference::insertion

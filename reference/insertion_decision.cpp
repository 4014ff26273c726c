// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "reference/insertion_transitions.hpp"

namespace palpate::reference::insertion {

using Eigen::VectorXd;
using Kind = InsertionEvent::Kind;

Tip Transitions::receding() const {
  return mode_.cut > mechanics_.track().entry() + 2.0 * band ? Tip::in_track : Tip::outside;
}

/// Modes of the tip that its velocity leaves open, the first of equals first.
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

/// How much a mode of the tip breaks its own condition [m/s^2].
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

/// Where velocities leave it open, the mode whose forces and accelerations keep its own conditions:
/// there is exactly one up to equals, because the Gram matrix is positive definite.
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

}  // namespace palpate::reference::insertion

// SPDX-License-Identifier: MIT
#include <cmath>

#include "reference/insertion_transitions.hpp"

namespace palpate::reference::insertion {

namespace {

void add_tip_roots(const Mode& mode, const Contact& now, const NeedleTrack& track,
                   double slip_band, std::vector<RootValue>& roots) {
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
  const Contact now = needs_forces ? mechanics.evaluate(time, mode, y, nullptr)
                                   : mechanics.kinematics(mode, y);
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

// SPDX-License-Identifier: MIT
#include "reference/needle_track.hpp"

#include <algorithm>
#include <cmath>

#include "reference/solution.hpp"
#include "reference/track_intervals.hpp"
#include "reference/track_knots.hpp"

namespace palpate::reference {

namespace {

/// Integral over [from, to] of the hat functions of knots k and k + 1 (linear there).
std::array<double, 2> hat_integrals(const NeedleTrack& track, std::size_t k, double from,
                                    double to) {
  const auto middle = track.hats(k, 0.5 * (from + to));  // the midpoint rule is exact
  return {middle[0] * (to - from), middle[1] * (to - from)};
}

}  // namespace

std::size_t NeedleTrack::segment_at(double depth) const {
  const auto above = std::ranges::upper_bound(knots, depth, {}, &TrackKnot::depth);
  return above == knots.begin() ? 0 : static_cast<std::size_t>(above - knots.begin()) - 1;
}

std::size_t NeedleTrack::interval_at(double depth) const {
  const auto above = std::ranges::upper_bound(intervals, depth, {}, &TrackInterval::begin);
  return above == intervals.begin() ? 0 : static_cast<std::size_t>(above - intervals.begin()) - 1;
}

std::array<double, 2> NeedleTrack::hats(std::size_t segment, double depth) const {
  if (segment + 1 == knots.size()) { return {1.0, 0.0}; }
  const double begin = knots[segment].depth;
  const double share = (depth - begin) / (knots[segment + 1].depth - begin);
  return {1.0 - share, share};
}

Eigen::VectorXd NeedleTrack::friction_shares(std::size_t segment, std::size_t interval,
                                             double depth) const {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()));
  const auto add = [&](std::size_t k, double friction, double from, double to) {
    const auto parts = hat_integrals(*this, k, from, to);
    const auto i = static_cast<Eigen::Index>(k);
    shares(i) += friction * parts[0];
    if (k + 1 < knots.size()) { shares(i + 1) += friction * parts[1]; }
  };
  for (std::size_t k = 0; k <= segment; ++k) {
    for (std::size_t n = 0; n <= interval; ++n) {
      const TrackInterval& part = intervals[n];
      const double from = std::max(knots[k].depth, part.begin);
      // Where the tip is, its depth ends the integral, even a rounding outside of the segment.
      const bool at_tip = k == segment && n == interval;
      const double lower = k == segment ? part.end : std::min(knots[k + 1].depth, part.end);
      if (at_tip || lower > from) { add(k, part.friction, from, at_tip ? depth : lower); }
    }
  }
  return shares;
}

NeedleTrack needle_track(const Scene& scene, const SpringNetwork& network) {
  NeedleTrack track;
  if (scene.probe) {
    track.knots = {probe_knot(scene, network)};
    track.intervals = {{.begin = track.entry(),
                        .cutting_force = std::numeric_limits<double>::infinity(),
                        .label = "skin"}};
    return track;
  }
  if (!scene.needle) { throw SolverError("insertion: the scene has neither needle nor probe"); }
  track.direction = scene.needle->direction.normalized();
  track.knots = needle_knots(scene, network);
  if (track.knots.empty()) { throw SolverError("insertion: no node lies on the needle's line"); }
  track.intervals = track_intervals(scene, track.entry());
  for (const TrackInterval& part : track.intervals) {
    if (part.role == TissueRole::bone) { track.bone = std::min(track.bone, part.begin); }
  }
  return track;
}

}  // namespace palpate::reference

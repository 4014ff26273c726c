// SPDX-License-Identifier: MIT

#include "reference/quasi_static_insertion.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "reference/exact_problems.hpp"
#include "reference/needle_track.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

class StaticTissue {
 public:
  StaticTissue(const Scene& scene, const SpringNetwork& network)
      : track_(needle_track(scene, network)), problem_(network) {
    const bool linear =
        track_.dents.empty() && std::ranges::all_of(track_.intervals, [](const auto& part) {
          return part.toe == 0.0 && part.travel == 0.0 && part.branches.empty();
        });
    if (!linear || relaxes(network)) {
      throw SolverError(
          "quasi-static insertion: a large dent, a toe, relaxation and creeping friction are not "
          "linear");
    }
    const Sparse stiffness = LinearProblem(problem_).stiffness();
    // Springs in a chain act along it only; coordinates without stiffness and force have no
    // equation.
    const double least = 1e-14 * stiffness.diagonal().maxCoeff();
    std::vector<Eigen::Triplet<double>> picks;
    for (Index i = 0; i < problem_.dof(); ++i) {
      if (stiffness.coeff(i, i) > least) {
        picks.emplace_back(static_cast<int>(i), static_cast<int>(picks.size()), 1.0);
      }
    }
    pick_.resize(problem_.dof(), static_cast<Index>(picks.size()));
    pick_.setFromTriplets(picks.begin(), picks.end());
    factors_.compute(pick_.transpose() * stiffness * pick_);
    const bool usable = factors_.info() == Eigen::Success &&
                        factors_.vectorD().minCoeff() > 1e-13 * factors_.vectorD().maxCoeff();
    if (!usable) {
      throw SolverError("quasi-static insertion: the stiffness is not positive definite");
    }
  }

  [[nodiscard]] const NeedleTrack& track() const { return track_; }

  [[nodiscard]] double compliance(double depth) const {
    const std::size_t segment = track_.segment_at(depth);
    const auto hats = track_.hats(segment, depth);
    VectorXd load = VectorXd::Zero(problem_.dof());
    for (std::size_t n = 0; n < 2 && hats[n] != 0.0; ++n) {
      for (const TrackSupport& support : track_.knots[segment + n].supports) {
        const Index first = problem_.coordinate(support.node);
        if (first >= 0) { load.segment<3>(first) += hats[n] * support.weight * track_.direction; }
      }
    }
    const VectorXd kept = pick_.transpose() * load;
    if (pick_ * kept != load) {
      throw SolverError("quasi-static insertion: the tissue can move freely");
    }
    return kept.dot(factors_.solve(kept));
  }
  /// Returns the compliance of the tissue and of the contact at a depth together, c + c_s [m/N].
  [[nodiscard]] double compliance_to_tip(double depth) const {
    return compliance(depth) + track_.give_at(0, track_.stretch_at(depth), depth)[0];
  }
  /// Returns the furthest position of a tip that cuts from one depth to another with `force` [m]:
  /// it passes at once what lies behind a position that it has reached.
  [[nodiscard]] double furthest(double from, double to, double force) const {
    double place = to + force * compliance_to_tip(to);
    for (const TrackGive& give : track_.give) {
      if (give.depth <= from || give.depth >= to) { continue; }
      place = std::max(place, give.depth + force * compliance_to_tip(give.depth));
    }
    return place;
  }

 private:
  NeedleTrack track_;
  NetworkProblem problem_;
  Sparse pick_;  ///< coordinates with stiffness, one column each
  Eigen::SimplicialLDLT<Sparse> factors_;
};

}  // namespace

double static_compliance(const Scene& scene, const SpringNetwork& network, double depth) {
  return StaticTissue(scene, network).compliance(depth);
}

std::vector<ForceDepthVertex> force_depth_curve(const Scene& scene, const SpringNetwork& network,
                                                double end) {
  const StaticTissue tissue(scene, network);
  const NeedleTrack& track = tissue.track();
  double depth = track.entry();
  double place = depth;
  double force = 0.0;
  std::vector<ForceDepthVertex> curve{{place, force}};
  for (const TrackInterval& part : track.intervals) {
    if (part.puncture_force > force) {
      const double compliance = tissue.compliance_to_tip(depth);
      place = std::max(place, depth + (compliance > 0.0 ? compliance * part.puncture_force : 0.0));
      if (place > end) {
        curve.push_back({end, (end - depth) / compliance});
        return curve;
      }
      if (part.puncture_force > part.cutting_force) {
        curve.push_back({place, part.puncture_force});
      }
    }
    if (!std::isfinite(part.cutting_force)) { return curve; }  // a wall
    curve.push_back({place, part.cutting_force});
    force = part.cutting_force;
    if (!std::isfinite(part.end)) { break; }
    depth = part.end;
    const double compliance = tissue.compliance_to_tip(depth);
    place = std::max(place, tissue.furthest(part.begin, depth, force));
    if (place >= end) { break; }
    if (depth + compliance * force < place) {  // the tip passes the end of the layer at once
      force = (place - depth) / compliance;
    }
    curve.push_back({place, force});
  }
  curve.push_back({end, force});
  return curve;
}

double force_at(const std::vector<ForceDepthVertex>& curve, double place) {
  if (place < curve.front().place) { return curve.front().force; }
  for (std::size_t n = curve.size() - 1; n > 0; --n) {
    const ForceDepthVertex& a = curve[n - 1];
    const ForceDepthVertex& b = curve[n];
    if (place >= b.place) { return b.force; }
    if (place >= a.place) {
      return a.force + (b.force - a.force) * (place - a.place) / (b.place - a.place);
    }
  }
  return curve.front().force;
}

}  // namespace palpate::reference

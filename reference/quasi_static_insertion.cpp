// SPDX-License-Identifier: MIT

#include "reference/quasi_static_insertion.hpp"

#include <Eigen/SparseCholesky>
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
    const Sparse stiffness = LinearProblem(problem_).stiffness();
    index_.assign(static_cast<std::size_t>(problem_.dof()), -1);
    // Springs in a chain act along it only; coordinates without stiffness and force have no
    // equation.
    const double least = 1e-14 * stiffness.diagonal().maxCoeff();
    for (Index i = 0; i < problem_.dof(); ++i) {
      if (stiffness.coeff(i, i) > least) { index_[static_cast<std::size_t>(i)] = count_++; }
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (Index j = 0; j < problem_.dof(); ++j) {
      for (Sparse::InnerIterator k(stiffness, j); k; ++k) {
        const Index row = reduced(k.row());
        const Index column = reduced(j);
        if (row >= 0 && column >= 0) {
          entries.emplace_back(static_cast<int>(row), static_cast<int>(column), k.value());
        }
      }
    }
    Sparse kept(count_, count_);
    kept.setFromTriplets(entries.begin(), entries.end());
    factors_.compute(kept);
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
    VectorXd load = VectorXd::Zero(count_);
    for (std::size_t n = 0; n < 2 && hats[n] != 0.0; ++n) {
      for (const TrackSupport& support : track_.knots[segment + n].supports) {
        const Index first = problem_.coordinate(support.node);
        if (first >= 0) { add(hats[n] * support.weight, first, load); }
      }
    }
    return load.dot(factors_.solve(load));
  }

 private:
  [[nodiscard]] Index reduced(Index coordinate) const {
    return index_[static_cast<std::size_t>(coordinate)];
  }

  void add(double weight, Index first, VectorXd& load) const {
    for (int axis = 0; axis < 3; ++axis) {
      const double component = weight * track_.direction(axis);
      const Index row = reduced(first + axis);
      if (component == 0.0) { continue; }
      if (row < 0) { throw SolverError("quasi-static insertion: the tissue can move freely"); }
      load(row) += component;
    }
  }

  NeedleTrack track_;
  NetworkProblem problem_;
  std::vector<Index> index_;
  Index count_ = 0;
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
    if (part.cutting_force > force) {
      const double compliance = tissue.compliance(depth);
      place = depth + (compliance > 0.0 ? compliance * part.cutting_force : 0.0);
      if (place > end) {
        curve.push_back({end, (end - depth) / compliance});
        return curve;
      }
    }
    if (!std::isfinite(part.cutting_force)) { return curve; }  // a wall
    curve.push_back({place, part.cutting_force});
    force = part.cutting_force;
    if (!std::isfinite(part.end)) { break; }
    depth = part.end;
    const double compliance = tissue.compliance(depth);
    const double there = depth + compliance * force;
    if (there >= end) { break; }
    if (there < place) {  // the tip passes the whole layer at once
      force = (place - depth) / compliance;
    }
    place = std::max(place, there);
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

// SPDX-License-Identifier: MIT

#include "validation/palpation_map.hpp"

#include "model/problem/needle_path.hpp"

namespace palpate {

namespace {

/// Returns the stiffness 1 / (w.K^-1 w + c_s) [N/m] of a tissue at rest under the face w of the
/// scene's probe at a skin position [m], with the compliance c_s that the grid lacks; infinity on
/// bone alone. `response` factorises K once for all positions.
double stiffness_felt(const Scene& scene, const NetworkProblem& problem,
                      const reference::StaticResponse& response, const Eigen::Vector2d& place) {
  Scene there = scene;
  there.probe->entry = place;
  there.probe->tip_radius.reset();  // the whole face is in contact
  const NeedlePath path(there, problem.network());
  Eigen::VectorXd w = Eigen::VectorXd::Zero(problem.dof());
  for (const NeedlePath::Support& support : path.supports(path.knots().front())) {
    const Eigen::Index at = problem.coordinate(support.node);
    if (at >= 0) { w.segment<3>(at) += support.weight * path.direction(); }
  }
  if (w.isZero(0.0)) { return std::numeric_limits<double>::infinity(); }
  const TipCompliance tip = path.tip_compliance(there, problem.network());
  return 1.0 / (response.compliance(w) + tip.at(path.knots().front().depth));
}

}  // namespace

HeatMap palpation_map(const Scene& scene, const NetworkProblem& problem, const PalpationGrid& grid,
                      const std::atomic<bool>* stop) {
  constexpr double mm = 1e3;
  const Eigen::Vector2d corner = scene.probe->entry - grid.half_span();
  HeatMap map{.label = "stiffness (N/mm)"};
  for (int i = 0; i < grid.sites[0]; ++i) { map.x.push_back(mm * (corner.x() + i * grid.spacing)); }
  for (int j = 0; j < grid.sites[1]; ++j) { map.y.push_back(mm * (corner.y() + j * grid.spacing)); }
  const reference::StaticResponse response(problem);
  for (const double y : map.y) {
    for (const double x : map.x) {
      if (stop != nullptr && stop->load()) { return map; }
      map.z.push_back(stiffness_felt(scene, problem, response, {x / mm, y / mm}) / mm);
    }
  }
  return map;
}

}  // namespace palpate

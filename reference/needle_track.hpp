// SPDX-License-Identifier: MIT
#pragma once
/// The line of a needle (or the footprint of a probe) in a network, for the references alone
/// (model/EQUATIONS.md, "Needle line"). Written from the equations, not from the model's code.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate::reference {

struct TrackSupport {
  int node = 0;
  double weight = 0.0;  ///< [1]; those of one knot sum to 1
};

struct TrackKnot {
  double depth = 0.0;  ///< xi_k [m] on the undeformed line
  std::vector<TrackSupport> supports{};
};

struct TrackInterval {
  double begin = 0.0;  ///< xi [m]
  double end = std::numeric_limits<double>::infinity();
  double cutting_force = 0.0;  ///< [N]; infinite for bone and beneath a probe
  double friction = 0.0;       ///< [N/m]
  TissueRole role = TissueRole::tissue;
  std::string label{};  ///< of the layer, else of the material
};

struct NeedleTrack {
  Eigen::Vector3d direction{0.0, 0.0, 1.0};  ///< n
  std::vector<TrackKnot> knots{};            ///< ascending in depth, no node in two of them
  std::vector<TrackInterval> intervals{};    ///< without gaps from the first knot on
  double bone = std::numeric_limits<double>::infinity();  ///< xi where bone begins [m]

  [[nodiscard]] double entry() const { return knots.front().depth; }  ///< xi_0 [m]
  /// Last knot of which depth >= its own, or 0.
  [[nodiscard]] std::size_t segment_at(double depth) const;
  [[nodiscard]] std::size_t interval_at(double depth) const;
  /// Hat functions of knots `segment` and `segment + 1` at a depth [1]; the second is 0 beyond the
  /// last knot.
  [[nodiscard]] std::array<double, 2> hats(std::size_t segment, double depth) const;
  /// l_k [N] of the knots down to a depth in this segment and interval (both go on smoothly beyond
  /// their ends, as trial steps of a solver need it).
  [[nodiscard]] Eigen::VectorXd friction_shares(std::size_t segment, std::size_t interval,
                                                double depth) const;
};

/// Track of the scene's needle or probe. SolverError when there is neither, or no node beneath it.
NeedleTrack needle_track(const Scene& scene, const SpringNetwork& network);

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#pragma once
/// Difference between a run and a run of the same scene at a finer setting (docs/formats.md,
/// "Error estimate").

#include <optional>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"

namespace palpate {

/// Event of a run, and where the refined run has it.
struct MovedEvent {
  std::string kind{};
  std::string detail{};
  double place = 0.0;                     ///< insertion of the tool [m]
  std::optional<double> refined_place{};  ///< [m]; empty: the refined run lacks this event
};

struct RunDifference {
  double reference = 0.0;  ///< peak force on the tool [N], or largest displacement of a record [m]
  double peak = 0.0;       ///< change of that peak, as a share of it
  /// Root mean square of the difference of both curves, with their events aligned, as a share of
  /// the peak.
  double curve = 0.0;
  std::vector<MovedEvent> events{};
  long extra_events = 0;  ///< events of the refined run without counterpart

  [[nodiscard]] double share() const { return peak > curve ? peak : curve; }
};

/// Returns the difference of the force on the tool over time, or without a tool of the
/// displacements of records. Empty if the run has neither, or if its peak is zero.
std::optional<RunDifference> difference_of(const Trace& run, const Trace& refined);

/// Moves the loads and records of a scene from the nodes of `coarse` to those of `fine`, which has
/// half the spacing [m]. Records follow their point. The force on a node is spread over the nodes
/// half a spacing beside it by the weights 1/4, 1/2, 1/4 along each axis with nodes on both sides:
/// a force on one point of a continuum has no finite displacement.
void move_to_finer_nodes(Scene& scene, const SpringNetwork& coarse, const SpringNetwork& fine,
                         const Eigen::Vector3d& spacing);

}  // namespace palpate

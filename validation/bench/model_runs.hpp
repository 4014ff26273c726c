// SPDX-License-Identifier: MIT
#pragma once
/// A scene computed by the model, and by solvers of other libraries.

#include <memory>
#include <string>
#include <vector>

#include "model/dynamics/problem.hpp"
#include "reference/solution.hpp"
#include "validation/bench/work_precision.hpp"

namespace palpate::bench {

/// Instants of the ticks, the first 0 [s].
std::vector<double> instants_of(const Scene& scene);

/// A scene without a tool: the place of one point stands for it.
class PointScene {
 public:
  /// `node` of a network; an oscillator has one coordinate.
  PointScene(const CaseContext& context, const Scene& scene, int node);
  ~PointScene();
  [[nodiscard]] Run here(const Scene& scene) const;
  /// Networks with forces from the model's list kernel, so that nobody pays for a plain right-hand side. The
  /// time is that of the march by the wall clock, or less where others had the processor. A solver that gives
  /// up is a run that failed.
  [[nodiscard]] Run there(const std::string& solver, const reference::Tolerance& tolerance) const;

 private:
  const CaseContext& context_;
  std::unique_ptr<Problem> plain_;
  std::unique_ptr<Problem> quick_;  ///< empty: the plain one is quick enough
  std::vector<double> instants_;
  Eigen::Index first_ = 0;  ///< coordinate of the point
  Eigen::Index count_ = 1;
};

/// A scene with a needle: the force on the hand stands for it.
Run needle_here(const CaseContext& context, const Scene& scene);

/// CVODE with events as roots.
struct NeedleReference {
  Run run{};
  std::vector<bool> jumps{};  ///< ticks within two of an event
};
NeedleReference needle_there(const Scene& scene, double tolerance);

}  // namespace palpate::bench

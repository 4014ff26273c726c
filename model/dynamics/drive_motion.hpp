// SPDX-License-Identifier: MIT
#pragma once
/// What the hand prescribes over time: the tool's place, or a force on it (model/EQUATIONS.md,
/// "Tool forces"). Everything is laid out on construction; asking allocates nothing.

#include <span>
#include <vector>

#include "model/dynamics/tool.hpp"

namespace palpate {

/// Piecewise linear place s(t) of a prescribed trajectory. Before `start` and after the last vertex
/// it rests.
class Trajectory {
 public:
  struct Vertex {
    double time = 0.0;   ///< [s]
    double place = 0.0;  ///< s [m]
  };
  /// Vertices up to `duration`.
  Trajectory(const Drive& drive, double duration);
  [[nodiscard]] double place(double t) const noexcept;
  [[nodiscard]] std::span<const Vertex> vertices() const { return vertices_; }

 private:
  std::vector<Vertex> vertices_;
};

/// Force of the hand along the needle [N], positive into the tissue, without its viscosity.
double hand_force(const Drive& drive, double t) noexcept;

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Motion or force that the hand prescribes over time (model/EQUATIONS.md, "Tool forces"), and the
/// pressure of a syringe. Only the constructors allocate.

#include <span>
#include <vector>

#include "model/problem/scene.hpp"

namespace palpate {

/// Piecewise linear position s(t) of a prescribed trajectory, constant before `start` and after the
/// last vertex.
class Trajectory {
 public:
  struct Vertex {
    double time = 0.0;   ///< [s]
    double place = 0.0;  ///< s [m]
  };
  /// Computes the vertices up to `duration` [s].
  Trajectory(const Drive& drive, double duration);
  [[nodiscard]] double place(double t) const noexcept;
  [[nodiscard]] std::span<const Vertex> vertices() const { return vertices_; }

 private:
  std::vector<Vertex> vertices_;
};

/// Returns the force of the hand along the needle [N] without its viscous part.
double hand_force(const Drive& drive, double t) noexcept;

/// Pressure of the fluid behind the needle tip (model/EQUATIONS.md, "Syringe").
class SyringePressure {
 public:
  explicit SyringePressure(const Syringe& syringe) : syringe_(syringe) {}

  /// Advances by h seconds in which the thumb presses with at most `thumb` [N] against an outflow
  /// resistance [Pa s/m^3]. Exact for constant outflow.
  void advance(double h, double resistance, double thumb) noexcept;
  [[nodiscard]] double pressure() const noexcept { return pressure_; }  ///< gauge [Pa]
  /// Returns the force of the thumb, P A and the friction of the plunger, at most that of
  /// advance() [N].
  [[nodiscard]] double thumb() const noexcept;
  /// Returns the force with which the thumb may press, under a reaction of the tissue [N] on a
  /// needle at rest or not.
  [[nodiscard]] double thumb_limit(double reaction, bool at_rest) const noexcept;
  /// Returns the outflow resistance in air or in tissue [Pa s/m^3]; `own` is that of the material.
  [[nodiscard]] double resistance(bool in_tissue, TissueRole role,
                                  const std::optional<double>& own) const noexcept;

 private:
  Syringe syringe_;
  double pressure_ = 0.0;
  double limit_ = 0.0;  ///< `thumb` of the last advance() [N]
};

}  // namespace palpate

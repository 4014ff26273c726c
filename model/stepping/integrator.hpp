// SPDX-License-Identifier: MIT
#pragma once
/// Integrators. A scheme is one class and one line of the list in integrator.cpp; everything else
/// (orders, stability limits, help, reports) follows from its IntegratorInfo.

#include <memory>
#include <optional>

#include "model/kernels/system.hpp"
#include "model/stepping/integrator_info.hpp"

namespace palpate {

template <class Real> class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Allocates workspace for steps of about h [s]; called once, before the loop.
  virtual void prepare(System<Real>& system, const State<Real>& state, double h) = 0;
  /// Relative error that a scheme which iterates may leave in a step's change of velocity; 0, and
  /// without this call: rounding.
  virtual void set_tolerance(double /*relative*/) noexcept {}
  /// From initial values to what the scheme carries, e.g. the velocity of half a step on.
  virtual void start(System<Real>& /*system*/, State<Real>& /*state*/, double /*t*/,
                     double /*h*/) noexcept {}
  /// One step from t to t + h. Failure shows as values that are not finite.
  virtual void step(System<Real>& system, State<Real>& state, double t, double h) noexcept = 0;
  /// A way [m] that no coordinate has gone further than since prepare(), not finite once anything
  /// is not; empty where the scheme does not keep it.
  [[nodiscard]] virtual std::optional<double> most_travelled() const noexcept {
    return std::nullopt;
  }
  /// Of the workspace that prepare() makes.
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept = 0;
  /// Velocity at the instant of the position; holds until the next step.
  virtual const Vector<Real>& velocity_at(const State<Real>& state) noexcept {
    return state.velocity;
  }
};

/// Of numbers in vectors.
template <class... Vectors> std::size_t bytes_of(const Vectors&... vectors) noexcept {
  return (std::size_t{0} + ... +
          (static_cast<std::size_t>(vectors.size()) * sizeof(vectors.data()[0])));
}

/// Instant that decides which loads act in a step that begins at t: a millionth of the step on, so
/// that rounding of t never moves a load by a whole step.
inline double load_gate(double t, double h) noexcept { return t + 1e-6 * h; }

}  // namespace palpate

namespace palpate::schemes {

// The schemes that integrators() lists.

extern const IntegratorInfo euler;
extern const IntegratorInfo euler_cromer;
extern const IntegratorInfo feynman_newton;
extern const IntegratorInfo feynman_newton_printed;
extern const IntegratorInfo leapfrog;
extern const IntegratorInfo velocity_verlet;
extern const IntegratorInfo rk4;
extern const IntegratorInfo implicit_euler;
extern const IntegratorInfo implicit_midpoint;

}  // namespace palpate::schemes

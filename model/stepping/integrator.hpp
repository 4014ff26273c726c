// SPDX-License-Identifier: MIT
#pragma once
/// Time integrators. A scheme is one class and one entry of the registry in integrator.cpp. Orders,
/// stability limits, help and reports are derived from its IntegratorInfo.

#include <memory>
#include <optional>

#include "model/kernels/system.hpp"
#include "model/stepping/integrator_info.hpp"

namespace palpate {

template <class Real> class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Allocates the workspace for steps of about h [s]; called once, before the first step.
  virtual void prepare(System<Real>& system, const State<Real>& state, double h) = 0;
  /// Sets the relative error at which an iterative scheme stops; 0, the default: rounding error.
  /// `most_corrections` ends a step whose corrections decrease; 0, the default: no limit.
  virtual void set_tolerance(double /*relative*/, int /*most_corrections*/) noexcept {}
  [[nodiscard]] virtual LimitedSteps limited_steps() const noexcept { return {}; }
  /// Converts initial values to the state of the scheme, e.g. to the velocity at the half step.
  virtual void start(System<Real>& /*system*/, State<Real>& /*state*/, double /*t*/,
                     double /*h*/) noexcept {}
  /// Advances the state from t to t + h. Divergence gives NaN or infinite values.
  virtual void step(System<Real>& system, State<Real>& state, double t, double h) noexcept = 0;
  /// Upper bound on the displacement of any coordinate since prepare() [m]. NaN or infinite if the
  /// state is not finite; empty if the scheme does not compute it.
  [[nodiscard]] virtual std::optional<double> most_travelled() const noexcept {
    return std::nullopt;
  }
  /// Returns the size of the workspace.
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept = 0;
  /// Returns the velocity at the time of the position; valid until the next step.
  virtual const Vector<Real>& velocity_at(const State<Real>& state) noexcept {
    return state.velocity;
  }
};

template <class... Vectors> std::size_t bytes_of(const Vectors&... vectors) noexcept {
  return (std::size_t{0} + ... +
          (static_cast<std::size_t>(vectors.size()) * sizeof(vectors.data()[0])));
}

/// Returns the activation time of a step that begins at t. The offset prevents rounding of t from
/// shifting a load by a whole step.
inline double load_gate(double t, double h) noexcept { return t + 1e-6 * h; }

}  // namespace palpate

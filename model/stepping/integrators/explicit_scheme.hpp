// SPDX-License-Identifier: MIT
#pragma once
/// What the explicit schemes share: an acceleration vector made before the loop.

#include "model/stepping/integrator.hpp"

namespace palpate {

template <class Real>
class ExplicitScheme : public Integrator<Real> {
 public:
  void prepare(System<Real>& system, const State<Real>& /*state*/, double /*h*/) override {
    a_.setZero(system.dof());
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return bytes_of(a_); }

 protected:
  Vector<Real> a_;  ///< [m/s^2]
};

/// The two templates of a scheme for the registry.
template <template <class> class Scheme, class Real>
std::unique_ptr<Integrator<Real>> make_scheme() {
  return std::make_unique<Scheme<Real>>();
}

}  // namespace palpate

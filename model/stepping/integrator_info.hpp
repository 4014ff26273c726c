// SPDX-License-Identifier: MIT
#pragma once
/// Properties of the integrators, independent of their implementation.

#include <memory>
#include <span>
#include <string_view>
#include <type_traits>

namespace palpate {

/// Steps of an iterative scheme that its limit of corrections ended. A step that contacts repeat
/// counts each time.
struct LimitedSteps {
  long count = 0;
  double largest_correction = 0.0;  ///< the last one of a step, over the largest velocity
};

template <class Real> class Integrator;

/// Properties of a scheme. Orders refer to the error at a fixed time against the exact solution.
struct IntegratorInfo {
  std::string_view name;
  std::string_view summary;
  int order_undamped = 1;
  int order_damped = 1;
  int evaluations = 1;          ///< force evaluations per step; per iteration for implicit schemes
  bool implicit = false;        ///< A-stable: no limit on the step
  double theta = 0.0;           ///< of an implicit scheme: forces at t + theta h; 0: explicit
  bool one_evaluation = false;  ///< supports the lagged spring velocity of the printed Eq. 9
  std::unique_ptr<Integrator<double>> (*make_double)() = nullptr;
  std::unique_ptr<Integrator<float>> (*make_float)() = nullptr;

  template <class Real> [[nodiscard]] std::unique_ptr<Integrator<Real>> make() const {
    if constexpr (std::is_same_v<Real, float>) {
      return make_float();
    } else {
      return make_double();
    }
  }
};

std::span<const IntegratorInfo* const> integrators();
/// Returns nullptr if no integrator has this name.
const IntegratorInfo* find_integrator(std::string_view name);

}  // namespace palpate

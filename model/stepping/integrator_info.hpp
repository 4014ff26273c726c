// SPDX-License-Identifier: MIT
#pragma once
/// Facts about the integrators, without their code.

#include <memory>
#include <span>
#include <string_view>
#include <type_traits>

namespace palpate {

template <class Real> class Integrator;

/// Facts of a scheme. Orders are of the error at fixed time against the exact motion.
struct IntegratorInfo {
  std::string_view name;
  std::string_view summary;
  int order_undamped = 1;
  int order_damped = 1;
  int evaluations = 1;          ///< of the force per step; implicit schemes: per iteration
  bool implicit = false;        ///< A-stable: no limit on the step
  bool one_evaluation = false;  ///< can carry the lagged spring velocity of the printed Eq. 9
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
/// nullptr when there is none of that name.
const IntegratorInfo* find_integrator(std::string_view name);

}  // namespace palpate

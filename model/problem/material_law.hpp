// SPDX-License-Identifier: MIT
#pragma once
/// Stiffening and relaxation of a tissue (model/EQUATIONS.md, "Stiffening", "Relaxation"). The
/// kernels of each instruction set include this file, so its functions are templates: none is
/// compiled twice under one name.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace palpate {

/// Tension k L0 g(e) of a spring with the strain e = (L - L0) / L0, in tension and compression: g
/// is odd, and its slope is 1 at rest and grows up to `largest`; from there on g is linear.
struct Stiffening {
  enum class Law { exponential, polynomial };
  Law law = Law::exponential;
  double rate = 0.0;       ///< a of g = (exp(a e) - 1) / a, e > 0 [1]
  double quadratic = 0.0;  ///< b of g = e + b e^2 + c e^3, e > 0 [1]
  double cubic = 0.0;      ///< c [1]
  double largest = 10.0;   ///< largest slope, at least 1
  bool operator==(const Stiffening&) const = default;
};

/// Branch of a Prony series: this share of the tension at once decays with this time.
struct RelaxationBranch {
  double share = 0.0;  ///< g_i of the instantaneous stiffness [1]
  double time = 0.0;   ///< tau_i [s]
  bool operator==(const RelaxationBranch&) const = default;
};
inline constexpr std::size_t most_branches = 3;

/// Law of a tissue whose springs are not linear and elastic alone.
struct MaterialLaw {
  Stiffening stiffening{};  ///< linear: rate, quadratic and cubic are 0
  std::vector<RelaxationBranch> branches{};
  bool operator==(const MaterialLaw&) const = default;
  [[nodiscard]] bool stiffens() const {
    return stiffening.law == Stiffening::Law::exponential
               ? stiffening.rate > 0.0
               : stiffening.quadratic > 0.0 || stiffening.cubic > 0.0;
  }
  [[nodiscard]] bool is_linear_elastic() const { return !stiffens() && branches.empty(); }
  /// Returns the largest stiffness relative to that at rest.
  [[nodiscard]] double largest_slope() const { return stiffens() ? stiffening.largest : 1.0; }
  /// Returns the share of a constant strain's tension that is left after a long time.
  [[nodiscard]] double lasting_share() const {
    double share = 1.0;
    for (const RelaxationBranch& branch : branches) { share -= branch.share; }
    return share;
  }
};

/// Constants of g for one precision, computed once.
template <class Real> struct StiffeningNumbers {
  bool linear = true;
  bool exponential = false;
  Real first = Real(0);     ///< a, or b
  Real second = Real(0);    ///< c
  Real straight = Real(0);  ///< strain at which the slope is the largest
  Real inverse = Real(0);   ///< 1 / a
};

template <class Real> StiffeningNumbers<Real> stiffening_numbers(const MaterialLaw& law) {
  if (!law.stiffens()) { return {}; }
  const Stiffening& s = law.stiffening;
  const double more = s.largest - 1.0;
  if (s.law == Stiffening::Law::exponential) {
    return {false,
            true,
            static_cast<Real>(s.rate),
            Real(0),
            static_cast<Real>(std::log1p(more) / s.rate),
            static_cast<Real>(1.0 / s.rate)};
  }
  // 3 c e^2 + 2 b e = largest - 1, in the form without cancellation.
  const double root = std::sqrt(s.quadratic * s.quadratic + 3.0 * s.cubic * more);
  return {false,
          false,
          static_cast<Real>(s.quadratic),
          static_cast<Real>(s.cubic),
          static_cast<Real>(more / (s.quadratic + root)),
          Real(0)};
}

/// g and its slope.
template <class Number> struct Stretched {
  Number value;
  Number slope;
};

/// Computes g(e) of a law that is not linear, for a scalar or a SIMD vector of strains.
template <class Number, class Real>
Stretched<Number> stretched(const StiffeningNumbers<Real>& numbers, const Number& strain) noexcept {
  using std::abs;
  using std::copysign;
  using std::exp;
  using std::min;
  const Number size = abs(strain);
  const Number bent = min(size, Number(numbers.straight));
  const Number first = Number(numbers.first);
  Stretched<Number> g;
  if (numbers.exponential) {
    // The rounding of exp(a e) - 1 is that of e itself over a.
    const Number grown = exp(Number(first * bent));
    g = {Number((grown - Number(Real(1))) * Number(numbers.inverse)), grown};
  } else {
    const Number cubic = Number(numbers.second) * bent;
    g = {bent + bent * bent * (first + cubic),
         Number(Real(1)) + bent * (Number(Real(2)) * first + Number(Real(3)) * cubic)};
  }
  return {copysign(Number(g.value + g.slope * (size - bent)), strain), g.slope};
}

/// Returns the integral of g from 0 to e, in double precision.
template <class Real> double stretched_work(const StiffeningNumbers<Real>& numbers, double strain) {
  const double size = std::abs(strain);
  const double bent = std::min(size, static_cast<double>(numbers.straight));
  const double a = static_cast<double>(numbers.first);
  const double c = static_cast<double>(numbers.second);
  double work = bent * bent * (0.5 + bent * (a / 3.0 + bent * c / 4.0));
  if (numbers.exponential) {
    const double x = a * bent;  // (exp(x) - 1 - x) / a^2
    work = x > 1e-3 ? (std::expm1(x) - x) / (a * a)
                    : bent * bent * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x / 120.0)));
  }
  const auto at =
      stretched<double>(StiffeningNumbers<double>{numbers.linear, numbers.exponential, a, c,
                                                  static_cast<double>(numbers.straight),
                                                  static_cast<double>(numbers.inverse)},
                        bent);
  return work + (size - bent) * (at.value + 0.5 * at.slope * (size - bent));
}

/// Elastic part of a spring: tension [N], its derivative by the length [N/m], and the energy [J].
struct ElasticPull {
  double tension = 0.0;
  double stiffness = 0.0;
  double energy = 0.0;
};

/// Computes the elastic part of a spring at once, without relaxation.
template <class Spring>
ElasticPull elastic_pull(const MaterialLaw& law, const Spring& spring, double length) {
  const auto k = static_cast<double>(spring.stiffness);
  const auto rest = static_cast<double>(spring.rest_length);
  const double extension = length - rest;
  if (!law.stiffens()) { return {k * extension, k, 0.5 * k * extension * extension}; }
  const auto numbers = stiffening_numbers<double>(law);
  const auto g = stretched<double>(numbers, extension / rest);
  return {k * rest * g.value, k * g.slope,
          k * rest * rest * stretched_work(numbers, extension / rest)};
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Force law of one spring-damper (model/EQUATIONS.md, "Spring force"). Every kernel instantiates
/// it, for scalars or SIMD vectors. The kernels of each instruction set include this file, so it
/// defines templates only: no function is compiled twice under one name.

namespace palpate {

struct PrintedForm;

/// Length [m] below which a spring has no direction; it then exerts no force and is reported.
inline constexpr double zero_length = 1e-12;

/// Constants of a spring-damper, or of several in one vector.
template <class Number> struct SpringNumbers {
  Number stiffness;  ///< k [N/m]
  Number rest;       ///< L0 [m]
  Number viscosity;  ///< c [N s/m]; unused without dampers
};

template <class Number, class Element> SpringNumbers<Number> numbers_of(const Element& spring) {
  return {static_cast<Number>(spring.stiffness), static_cast<Number>(spring.rest_length),
          static_cast<Number>(spring.viscosity)};
}

/// Computes a b + c. SIMD vectors specialise it if the instruction set has a fused operation.
template <class Number> struct MultiplyAdd {
  static Number of(const Number& a, const Number& b, const Number& c) noexcept { return a * b + c; }
};

/// Terms of the law that a kernel computes.
struct SpringTerms {
  bool elastic = true;
  bool viscous = true;
};

template <SpringTerms terms = SpringTerms{}> struct SpringTension {
  /// T = k (L - L0) + c L' [N], positive where the spring pulls. `rate` is L' [m/s].
  template <class Number>
  static Number of(const SpringNumbers<Number>& spring, const Number& length,
                   const Number& rate) noexcept {
    if constexpr (!terms.elastic) {
      return spring.viscosity * rate;
    } else {
      const Number elastic = spring.stiffness * (length - spring.rest);
      if constexpr (!terms.viscous) {
        return elastic;
      } else {
        return MultiplyAdd<Number>::of(spring.viscosity, rate, elastic);
      }
    }
  }
};

/// Returns `sum` plus twice the elastic energy of a spring, k (L - L0)^2 [J].
template <class Number>
Number add_twice_energy(const SpringNumbers<Number>& spring, const Number& length,
                        const Number& sum) noexcept {
  const Number extension = length - spring.rest;
  return MultiplyAdd<Number>::of(spring.stiffness * extension, extension, sum);
}

/// Errata of the printed force law: f_a = scale (elastic k (L - L0) + viscous c L') e, with e = u,
/// or e = d for the printed Eq. 12. The defaults give the corrected law.
struct SpringLaw {
  double scale = 1.0;               ///< 1 or 1/2
  double elastic = 1.0;             ///< 1 or -1
  double viscous = 1.0;             ///< 1 or -1
  bool along_displacement = false;  ///< e = d instead of u

  /// Returns true if a scene selects any printed form of the force.
  static bool is_printed(const PrintedForm& printed);
  static SpringLaw from(const PrintedForm& printed);

  template <class Number>
  [[nodiscard]] SpringNumbers<Number> with_signs(const SpringNumbers<Number>& spring) const {
    return {static_cast<Number>(elastic) * spring.stiffness, spring.rest,
            static_cast<Number>(viscous) * spring.viscosity};
  }
};

/// Returns the force [N] on end a; the force on end b is opposite. d = x_b - x_a [m],
/// extension_rate = L' [m/s].
template <class Real, class Vector>
Vector spring_force(const SpringLaw& law, const SpringNumbers<Real>& spring, const Vector& d,
                    Real length, Real extension_rate) noexcept {
  const Real tension = static_cast<Real>(law.scale) *
                       SpringTension<>::of(law.with_signs(spring), length, extension_rate);
  return (law.along_displacement ? tension : tension / length) * d;
}

}  // namespace palpate

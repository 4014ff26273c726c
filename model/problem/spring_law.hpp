// SPDX-License-Identifier: MIT
#pragma once
/// The law of one spring-damper (model/EQUATIONS.md, "Spring force"). Every kernel instantiates it,
/// for single numbers or for vectors of them. Kernels of each instruction set include this file: it
/// defines templates only, so that no code is compiled twice under one name.

namespace palpate {

struct PrintedForm;

/// Below this length [m] a spring has no direction: it exerts no force and is reported.
inline constexpr double zero_length = 1e-12;

/// Constants of a spring-damper, or of several in one vector.
template <class Number> struct SpringNumbers {
  Number stiffness;  ///< k [N/m]
  Number rest;       ///< L0 [m]
  Number viscosity;  ///< c [N s/m]; not read where there are no dampers
};

template <class Number, class Element> SpringNumbers<Number> numbers_of(const Element& spring) {
  return {static_cast<Number>(spring.stiffness), static_cast<Number>(spring.rest_length),
          static_cast<Number>(spring.viscosity)};
}

/// a b + c. Vectors specialise it where the instruction set has an operation with one rounding.
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

/// `sum` plus twice the elastic energy of a spring, k (L - L0)^2 [J].
template <class Number>
Number add_twice_energy(const SpringNumbers<Number>& spring, const Number& length,
                        const Number& sum) noexcept {
  const Number extension = length - spring.rest;
  return MultiplyAdd<Number>::of(spring.stiffness * extension, extension, sum);
}

/// Errata of the printed force law: f_a = scale (elastic k (L - L0) + viscous c L') e, with e = u,
/// or d for the printed Eq. 12. The corrected law has the defaults.
struct SpringLaw {
  double scale = 1.0;               ///< 1 or 1/2
  double elastic = 1.0;             ///< 1 or -1
  double viscous = 1.0;             ///< 1 or -1
  bool along_displacement = false;  ///< e = d instead of u

  /// Whether a scene selects any printed form of the force.
  static bool is_printed(const PrintedForm& printed);
  static SpringLaw from(const PrintedForm& printed);

  template <class Number>
  [[nodiscard]] SpringNumbers<Number> with_signs(const SpringNumbers<Number>& spring) const {
    return {static_cast<Number>(elastic) * spring.stiffness, spring.rest,
            static_cast<Number>(viscous) * spring.viscosity};
  }
};

/// Force [N] on end a; end b receives the opposite. d = x_b - x_a [m], extension_rate = L' [m/s].
template <class Real, class Vector>
Vector spring_force(const SpringLaw& law, Real stiffness, Real viscosity, Real rest_length,
                    const Vector& d, Real length, Real extension_rate) noexcept {
  const SpringNumbers<Real> spring =
      law.with_signs(SpringNumbers<Real>{stiffness, rest_length, viscosity});
  const Real tension =
      static_cast<Real>(law.scale) * SpringTension<>::of(spring, length, extension_rate);
  return (law.along_displacement ? tension : tension / length) * d;
}

}  // namespace palpate

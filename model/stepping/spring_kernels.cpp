// SPDX-License-Identifier: MIT
#include "model/stepping/spring_kernels.hpp"

#include <cmath>

namespace palpate {

namespace {

template <class Real>
struct Three {
  Real x, y, z;
};

template <class Real>
Three<Real> between(const Real* from, const Real* to) noexcept {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

template <class Real>
Real dot(const Three<Real>& a, const Three<Real>& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// 1 / L, or 0 for a spring without direction, so that it exerts no force and makes no NaN.
template <class Real>
Real inverse_or_zero(Real length) noexcept {
  return length > static_cast<Real>(zero_length) ? Real(1) / length : Real(0);
}

template <class Real>
void add(Real* f, Real factor, const Three<Real>& d) noexcept {
  f[0] += factor * d.x;
  f[1] += factor * d.y;
  f[2] += factor * d.z;
}

/// The corrected physics. Returns tension / L.
template <bool damped, class Real, class Element>
Real pull(const Element& spring, const Three<Real>& d, const Three<Real>& w) noexcept {
  const Real length = std::sqrt(dot(d, d));
  const Real inverse = inverse_or_zero(length);
  Real tension = spring.stiffness * (length - spring.rest_length);
  if constexpr (damped) { tension += spring.viscosity * (dot(w, d) * inverse); }
  return tension * inverse;
}

template <bool damped, class Real>
void physical_kernel(SpringSet<Real>& springs, const Real* q, const Real* v, Real* f) noexcept {
  for (const Link<Real>& s : springs.links) {
    const Three<Real> d = between(q + s.a, q + s.b);
    Three<Real> w{};
    if constexpr (damped) { w = between(v + s.a, v + s.b); }
    const Real factor = pull<damped>(s, d, w);
    add(f + s.a, factor, d);
    add(f + s.b, -factor, d);
  }
  for (const Anchor<Real>& s : springs.anchors) {
    const Three<Real> d = between(q + s.a, s.place);
    Three<Real> w{};
    if constexpr (damped) { w = {-v[s.a], -v[s.a + 1], -v[s.a + 2]}; }
    add(f + s.a, pull<damped>(s, d, w), d);
  }
}

/// Any erratum of the force law. Returns the factor of d.
template <class Real, class Element>
Real printed_pull(SpringSet<Real>& springs, std::size_t index, const Element& spring,
                  const Three<Real>& d, const Three<Real>& w) noexcept {
  const Real length = std::sqrt(dot(d, d));
  if (!(length > static_cast<Real>(zero_length))) { return length == length ? Real(0) : length; }
  Real rate = dot(w, d) / length;
  if (springs.lagged) {
    rate = (length - springs.previous_length[index]) / springs.lag;
    springs.previous_length[index] = length;
  }
  const Eigen::Matrix<Real, 3, 1> unit(Real(1), Real(0), Real(0));
  return spring_force<Real>(springs.law, spring.stiffness, spring.viscosity, spring.rest_length,
                            unit, length, rate)
      .x();
}

template <class Real>
void printed_kernel(SpringSet<Real>& springs, const Real* q, const Real* v, Real* f) noexcept {
  std::size_t index = 0;
  for (const Link<Real>& s : springs.links) {
    const Three<Real> d = between(q + s.a, q + s.b);
    const Real factor = printed_pull(springs, index++, s, d, between(v + s.a, v + s.b));
    add(f + s.a, factor, d);
    add(f + s.b, -factor, d);
  }
  for (const Anchor<Real>& s : springs.anchors) {
    const Three<Real> d = between(q + s.a, s.place);
    const Three<Real> w{-v[s.a], -v[s.a + 1], -v[s.a + 2]};
    add(f + s.a, printed_pull(springs, index++, s, d, w), d);
  }
}

}  // namespace

template <class Real>
SpringKernel<Real> spring_kernel_for(KernelTraits traits) noexcept {
  if (traits.printed) { return &printed_kernel<Real>; }
  return traits.damped ? &physical_kernel<true, Real> : &physical_kernel<false, Real>;
}

template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept {
  const auto factor = [&](const auto& s, const Three<Real>& d, const Three<Real>& relative) {
    const Real inverse = inverse_or_zero(std::sqrt(dot(d, d)));
    const Real c = static_cast<Real>(springs.law.scale * springs.law.viscous) * s.viscosity;
    return c * (dot(relative, d) * inverse) * (springs.law.along_displacement ? Real(1) : inverse);
  };
  for (const Link<Real>& s : springs.links) {
    const Three<Real> d = between(q + s.a, q + s.b);
    const Real g = factor(s, d, between(w + s.a, w + s.b));
    add(f + s.a, g, d);
    add(f + s.b, -g, d);
  }
  for (const Anchor<Real>& s : springs.anchors) {
    const Three<Real> d = between(q + s.a, s.place);
    add(f + s.a, factor(s, d, Three<Real>{-w[s.a], -w[s.a + 1], -w[s.a + 2]}), d);
  }
}

template SpringKernel<double> spring_kernel_for<double>(KernelTraits) noexcept;
template SpringKernel<float> spring_kernel_for<float>(KernelTraits) noexcept;
template void add_damping(const SpringSet<double>&, const double*, const double*, double*) noexcept;
template void add_damping(const SpringSet<float>&, const float*, const float*, float*) noexcept;

}  // namespace palpate

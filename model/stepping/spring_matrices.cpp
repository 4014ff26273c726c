// SPDX-License-Identifier: MIT
#include "model/stepping/spring_matrices.hpp"

#include <algorithm>
#include <utility>

namespace palpate {

namespace {

/// Derivative of the force on end a by d and by the relative velocity (cf. NetworkProblem).
template <class Real>
struct Gradient {
  Eigen::Matrix<Real, 3, 3> position = Eigen::Matrix<Real, 3, 3>::Zero();
  Eigen::Matrix<Real, 3, 3> velocity = Eigen::Matrix<Real, 3, 3>::Zero();
};

template <class Real, class Element>
Gradient<Real> gradient_of(const SpringLaw& law, const Element& spring,
                           const Eigen::Matrix<Real, 3, 1>& d,
                           const Eigen::Matrix<Real, 3, 1>& w) noexcept {
  using Matrix = Eigen::Matrix<Real, 3, 3>;
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  const Real length = d.norm();
  if (!(length > static_cast<Real>(zero_length))) { return {}; }
  const Vector3 u = d / length;
  const Real k = static_cast<Real>(law.scale * law.elastic) * spring.stiffness;
  const Real c = static_cast<Real>(law.scale * law.viscous) * spring.viscosity;
  const Real rate = w.dot(u);
  const Real tension = k * (length - spring.rest_length) + c * rate;
  const Vector3 slope = k * u + (c / length) * (w - rate * u);
  const Vector3 e = law.along_displacement ? d : u;
  const Matrix turn = law.along_displacement
                          ? Matrix(Matrix::Identity())
                          : Matrix((Matrix::Identity() - u * u.transpose()) / length);
  return {e * slope.transpose() + tension * turn, c * e * u.transpose()};
}

template <class Real>
void add_block(Real* values, const std::int64_t* columns, Real factor,
               const Eigen::Matrix<Real, 3, 3>& block) noexcept {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) { values[columns[c] + r] += factor * block(r, c); }
  }
}

}  // namespace

template <class Real>
void SpringMatrices<Real>::pattern(const SpringSet<Real>& springs, Eigen::Index of_nodes, Eigen::Index size,
                                   std::vector<Eigen::Triplet<Real>> further, Eigen::SparseMatrix<Real>& a) {
  std::vector<Eigen::Triplet<Real>> triplets = std::move(further);
  triplets.reserve(triplets.size() + 18 * springs.links.size() + static_cast<std::size_t>(9 * of_nodes));
  const auto block = [&](Eigen::Index row, Eigen::Index column) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        triplets.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), Real(0));
      }
    }
  };
  for (Eigen::Index i = 0; i < of_nodes; i += 3) { block(i, i); }
  for (const auto& s : springs.links) {
    block(s.a, s.b);
    block(s.b, s.a);
  }
  a.resize(size, size);
  a.setFromTriplets(triplets.begin(), triplets.end());
  a.makeCompressed();
  const auto slot = [&a](int row, int column) -> std::int64_t {
    const int* begin = a.innerIndexPtr() + a.outerIndexPtr()[column];
    const int* end = a.innerIndexPtr() + a.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, row) - a.innerIndexPtr();
  };
  link_slots_.clear();
  anchor_slots_.clear();
  diagonal_slots_.clear();
  for (const auto& s : springs.links) {
    std::array<std::int64_t, 12> slots{};
    for (int c = 0; c < 3; ++c) {
      const auto n = static_cast<std::size_t>(c);
      slots[n] = slot(s.a, s.a + c);
      slots[3 + n] = slot(s.b, s.b + c);
      slots[6 + n] = slot(s.a, s.b + c);
      slots[9 + n] = slot(s.b, s.a + c);
    }
    link_slots_.push_back(slots);
  }
  for (const auto& s : springs.anchors) {
    anchor_slots_.push_back({slot(s.a, s.a), slot(s.a, s.a + 1), slot(s.a, s.a + 2)});
  }
  for (int i = 0; i < static_cast<int>(size); ++i) { diagonal_slots_.push_back(slot(i, i)); }
}

template <class Real>
void SpringMatrices<Real>::jacobian(const SpringSet<Real>& springs, const At& at, const Vector<Real>& mass,
                                    Eigen::SparseMatrix<Real>& a) const noexcept {
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  Real* values = a.valuePtr();
  std::fill(values, values + a.nonZeros(), Real(0));
  for (Eigen::Index i = 0; i < mass.size(); ++i) {
    values[diagonal_slots_[static_cast<std::size_t>(i)]] = mass(i);
  }
  for (std::size_t n = 0; n < springs.links.size(); ++n) {
    const auto& s = springs.links[n];
    const Vector3 d = at.q.template segment<3>(s.b) - at.q.template segment<3>(s.a);
    const Vector3 w = at.v.template segment<3>(s.b) - at.v.template segment<3>(s.a);
    const auto g = gradient_of<Real>(springs.law, s, d, w);
    const Eigen::Matrix<Real, 3, 3> block = at.on_stiffness * g.position + at.on_damping * g.velocity;
    const auto& slots = link_slots_[n];
    add_block(values, slots.data(), Real(1), block);
    add_block(values, slots.data() + 3, Real(1), block);
    add_block(values, slots.data() + 6, Real(-1), block);
    add_block(values, slots.data() + 9, Real(-1), block);
  }
  for (std::size_t n = 0; n < springs.anchors.size(); ++n) {
    const auto& s = springs.anchors[n];
    const Vector3 d = Eigen::Map<const Vector3>(s.place) - at.q.template segment<3>(s.a);
    const Vector3 w = -at.v.template segment<3>(s.a);
    const auto g = gradient_of<Real>(springs.law, s, d, w);
    const Eigen::Matrix<Real, 3, 3> block = at.on_stiffness * g.position + at.on_damping * g.velocity;
    add_block(values, anchor_slots_[n].data(), Real(1), block);
  }
}

template class SpringMatrices<double>;
template class SpringMatrices<float>;

}  // namespace palpate

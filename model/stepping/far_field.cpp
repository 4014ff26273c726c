// SPDX-License-Identifier: MIT
#include "model/stepping/far_field.hpp"

#include <algorithm>
#include <map>

#include "model/stepping/far_springs.hpp"

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

}  // namespace

template <class Real>
FarField<Real>::FarField(const NetworkProblem& problem, const NetworkProblem& near, const FarShapes& shapes)
    : first_(near.dof()) {
  const SpringNetwork& network = problem.network();
  const Index modes = shapes.modes();
  struct Sum {
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
    MatrixXd coupling;
    double stiff = 0.0;
    double viscous = 0.0;
  };
  std::map<int, Sum> sums;
  VectorXd stiffness = VectorXd::Zero(modes);
  GramSum damping(modes);
  const auto near_end = [&](const Spring& spring) {
    const int end = shapes.holds(spring.a) ? spring.b : spring.a;
    return near.coordinate(end) >= 0 ? end : -1;
  };
  visit_far_springs(network, shapes, [&](const Spring& spring, const Vector3d& u, const VectorXd& grows) {
    stiffness += spring.stiffness * grows.cwiseAbs2();  // shapes are modes: no others
    const int end = near_end(spring);
    if (end < 0) {
      damping.add(grows, spring.viscosity);
      return;
    }
    Sum& sum = sums[end];
    if (sum.coupling.size() == 0) { sum.coupling = MatrixXd::Zero(modes, 3); }
    sum.stiffness += spring.stiffness * u * u.transpose();
    sum.coupling -= spring.stiffness * grows * u.transpose();
    sum.stiff += spring.stiffness;
    sum.viscous += spring.viscosity;
  });
  // Between near and far viscosity is shared out by stiffness.
  visit_far_springs(network, shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
    const int end = near_end(spring);
    if (end < 0) { return; }
    const Sum& sum = sums.at(end);
    damping.add(grows, spring.stiffness * (sum.stiff > 0.0 ? sum.viscous / sum.stiff : 0.0));
  });
  coupling_.resize(modes, 3 * static_cast<Index>(sums.size()));
  for (const auto& [node, sum] : sums) {
    coupling_.template middleCols<3>(3 * static_cast<Index>(edges_.size())) = sum.coupling.template cast<Real>();
    edges_.push_back({.coordinate = near.coordinate(node),
                      .rest = network.rest_position.col(node).template cast<Real>(),
                      .stiffness = sum.stiffness.template cast<Real>(),
                      .lag = static_cast<Real>(sum.stiff > 0.0 ? sum.viscous / sum.stiff : 0.0)});
  }
  stiffness_ = stiffness.template cast<Real>();
  damping_ = damping.take().template cast<Real>();
  mass_ = VectorXd::Constant(modes, shapes.mass);
  moved_.setZero(coupling_.cols());
  pulled_.setZero(coupling_.cols());
}

template <class Real>
void FarField<Real>::add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept {
  const auto z = q.segment(first_, modes());
  const auto rate = v.segment(first_, modes());
  // K u + C v of a spring between near and far is K (u + lag v).
  Index at = 0;
  pulled_.noalias() = coupling_.transpose() * z;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = q.template segment<3>(edge.coordinate) - edge.rest +
                                     edge.lag * v.template segment<3>(edge.coordinate);
    f.template segment<3>(edge.coordinate) -=
        edge.stiffness * moved_.template segment<3>(at) + pulled_.template segment<3>(at);
    at += 3;
  }
  pulled_.noalias() = coupling_.transpose() * rate;
  at = 0;
  for (const Edge& edge : edges_) {
    f.template segment<3>(edge.coordinate) -= edge.lag * pulled_.template segment<3>(at);
    at += 3;
  }
  auto on_shapes = f.segment(first_, modes());
  on_shapes.noalias() -= coupling_ * moved_;
  on_shapes -= stiffness_.cwiseProduct(z);
  on_shapes.noalias() -= damping_ * rate;
}

template <class Real>
void FarField<Real>::add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept {
  const auto rate = w.segment(first_, modes());
  pulled_.noalias() = coupling_.transpose() * rate;
  Index at = 0;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = edge.lag * w.template segment<3>(edge.coordinate);
    f.template segment<3>(edge.coordinate) +=
        edge.stiffness * moved_.template segment<3>(at) + edge.lag * pulled_.template segment<3>(at);
    at += 3;
  }
  auto on_shapes = f.segment(first_, modes());
  on_shapes.noalias() += coupling_ * moved_;
  on_shapes.noalias() += damping_ * rate;
}

template <class Real>
double FarField<Real>::energy(const Vector<Real>& q) noexcept {
  const auto z = q.segment(first_, modes());
  double energy = 0.5 * static_cast<double>(z.cwiseAbs2().dot(stiffness_));
  pulled_.noalias() = coupling_.transpose() * z;
  Index at = 0;
  for (const Edge& edge : edges_) {
    const Eigen::Matrix<Real, 3, 1> u = q.template segment<3>(edge.coordinate) - edge.rest;
    energy += static_cast<double>(u.dot(Real(0.5) * (edge.stiffness * u) + pulled_.template segment<3>(at)));
    at += 3;
  }
  return energy;
}

template <class Real>
void FarField<Real>::add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const {
  const auto add = [&](Index row, Index column) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), Real(0));
  };
  for (Index n = 0; n < modes(); ++n) {
    for (const Edge& edge : edges_) {
      for (Index c = 0; c < 3; ++c) {
        add(first_ + n, edge.coordinate + c);
        add(edge.coordinate + c, first_ + n);
      }
    }
    for (Index m = 0; m < modes(); ++m) { add(first_ + m, first_ + n); }
  }
}

template <class Real>
void FarField<Real>::find_slots(const Eigen::SparseMatrix<Real>& a) {
  const auto slot = [&a](Index row, Index column) -> std::ptrdiff_t {
    const int* begin = a.innerIndexPtr() + a.outerIndexPtr()[column];
    const int* end = a.innerIndexPtr() + a.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, static_cast<int>(row)) - a.innerIndexPtr();
  };
  shape_slots_.clear();
  for (Edge& edge : edges_) {
    for (Index c = 0; c < 3; ++c) {
      edge.slots[c] = slot(first_, edge.coordinate + c);
      edge.diagonal_slots[c] = slot(edge.coordinate, edge.coordinate + c);
    }
  }
  for (Index n = 0; n < modes(); ++n) {
    for (const Edge& edge : edges_) { shape_slots_.push_back(slot(edge.coordinate, first_ + n)); }
    shape_slots_.push_back(slot(first_, first_ + n));
  }
}

template <class Real>
void FarField<Real>::add_jacobian(Real on_damping, Real on_stiffness, Eigen::SparseMatrix<Real>& a) const noexcept {
  Real* values = a.valuePtr();
  Index at = 0;
  for (const Edge& edge : edges_) {
    const Real factor = on_stiffness + on_damping * edge.lag;
    for (Index c = 0; c < 3; ++c) {
      for (Index r = 0; r < 3; ++r) { values[edge.diagonal_slots[c] + r] += factor * edge.stiffness(r, c); }
      for (Index n = 0; n < modes(); ++n) { values[edge.slots[c] + n] += factor * coupling_(n, at + c); }
    }
    at += 3;
  }
  auto next = shape_slots_.begin();
  for (Index n = 0; n < modes(); ++n) {
    at = 0;
    for (const Edge& edge : edges_) {
      const Real factor = on_stiffness + on_damping * edge.lag;
      for (Index c = 0; c < 3; ++c) { values[*next + c] += factor * coupling_(n, at + c); }
      ++next;
      at += 3;
    }
    for (Index m = 0; m < modes(); ++m) { values[*next + m] += on_damping * damping_(m, n); }
    values[*next + n] += on_stiffness * stiffness_(n);
    ++next;
  }
}

template <class Real>
std::size_t FarField<Real>::memory_bytes() const noexcept {
  const auto numbers = static_cast<std::size_t>(coupling_.size() + damping_.size() + stiffness_.size() +
                                                moved_.size() + pulled_.size());
  return numbers * sizeof(Real) + edges_.size() * sizeof(Edge) + shape_slots_.size() * sizeof(std::ptrdiff_t);
}

template class FarField<double>;
template class FarField<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/reduction/reduced_network.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "model/reduction/mode_basis.hpp"

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

}  // namespace

template <class Real>
ReducedModel<Real>::ReducedModel(const NetworkProblem& problem, const NetworkProblem& near,
                                 const ModeBasis& shapes)
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
  visit_far_springs(
      network, shapes, [&](const Spring& spring, const Vector3d& u, const VectorXd& grows) {
        stiffness += spring.stiffness * grows.cwiseAbs2();  // modes are orthogonal: diagonal only
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
  // Viscosity between near and far nodes is distributed in proportion to stiffness.
  visit_far_springs(
      network, shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
        const int end = near_end(spring);
        if (end < 0) { return; }
        const Sum& sum = sums.at(end);
        damping.add(grows, spring.stiffness * (sum.stiff > 0.0 ? sum.viscous / sum.stiff : 0.0));
      });
  coupling_.resize(modes, 3 * static_cast<Index>(sums.size()));
  for (const auto& [node, sum] : sums) {
    coupling_.template middleCols<3>(3 * static_cast<Index>(edges_.size())) =
        sum.coupling.template cast<Real>();
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
void ReducedModel<Real>::add(const Vector<Real>& q, const Vector<Real>& v,
                             Vector<Real>& f) noexcept {
  const auto z = q.segment(first_, modes());
  const auto rate = v.segment(first_, modes());
  // K u + C v of a spring between a near and a far node is K (u + lag v).
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
void ReducedModel<Real>::add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept {
  const auto rate = w.segment(first_, modes());
  pulled_.noalias() = coupling_.transpose() * rate;
  Index at = 0;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = edge.lag * w.template segment<3>(edge.coordinate);
    f.template segment<3>(edge.coordinate) += edge.stiffness * moved_.template segment<3>(at) +
                                              edge.lag * pulled_.template segment<3>(at);
    at += 3;
  }
  auto on_shapes = f.segment(first_, modes());
  on_shapes.noalias() += coupling_ * moved_;
  on_shapes.noalias() += damping_ * rate;
}

template <class Real> double ReducedModel<Real>::energy(const Vector<Real>& q) noexcept {
  const auto z = q.segment(first_, modes());
  double energy = 0.5 * static_cast<double>(z.cwiseAbs2().dot(stiffness_));
  pulled_.noalias() = coupling_.transpose() * z;
  Index at = 0;
  for (const Edge& edge : edges_) {
    const Eigen::Matrix<Real, 3, 1> u = q.template segment<3>(edge.coordinate) - edge.rest;
    energy += static_cast<double>(
        u.dot(Real(0.5) * (edge.stiffness * u) + pulled_.template segment<3>(at)));
    at += 3;
  }
  return energy;
}

template <class Real>
void ReducedModel<Real>::add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const {
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

template <class Real> void ReducedModel<Real>::find_slots(const Eigen::SparseMatrix<Real>& a) {
  shape_slots_.clear();
  for (Edge& edge : edges_) {
    for (Index c = 0; c < 3; ++c) {
      edge.slots[c] = slot_of(a, first_, edge.coordinate + c);
      edge.diagonal_slots[c] = slot_of(a, edge.coordinate, edge.coordinate + c);
    }
  }
  for (Index n = 0; n < modes(); ++n) {
    for (const Edge& edge : edges_) {
      shape_slots_.push_back(slot_of(a, edge.coordinate, first_ + n));
    }
    shape_slots_.push_back(slot_of(a, first_, first_ + n));
  }
}

template <class Real>
void ReducedModel<Real>::add_jacobian(Real on_damping, Real on_stiffness,
                                      Eigen::SparseMatrix<Real>& a) const noexcept {
  Real* values = a.valuePtr();
  Index at = 0;
  for (const Edge& edge : edges_) {
    const Real factor = on_stiffness + on_damping * edge.lag;
    for (Index c = 0; c < 3; ++c) {
      for (Index r = 0; r < 3; ++r) {
        values[edge.diagonal_slots[c] + r] += factor * edge.stiffness(r, c);
      }
      for (Index n = 0; n < modes(); ++n) {
        values[edge.slots[c] + n] += factor * coupling_(n, at + c);
      }
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

template <class Real> std::size_t ReducedModel<Real>::memory_bytes() const noexcept {
  const auto numbers = static_cast<std::size_t>(coupling_.size() + damping_.size() +
                                                stiffness_.size() + moved_.size() + pulled_.size());
  return numbers * sizeof(Real) + edges_.size() * sizeof(Edge) +
         shape_slots_.size() * sizeof(std::ptrdiff_t);
}

template class ReducedModel<double>;
template class ReducedModel<float>;

NearAndFar NearAndFar::of(const NetworkProblem& problem, const ReductionSetting& setting) {
  const LatticeShape shape = problem.network().springs.lattice().value();
  SpringNetwork near = problem.network();
  const auto is_far = [&](int node) { return !near.is_fixed(node) && !setting.near.holds(node); };
  near.springs.edit([&](std::vector<Spring>& springs) {
    std::erase_if(springs,
                  [&](const Spring& spring) { return is_far(spring.a) || is_far(spring.b); });
  });
  for (int node = 0; node < shape.node_count(); ++node) {
    if (!setting.near.holds(node)) { near.fixed[static_cast<std::size_t>(node)] = 1; }
  }
  return {NetworkProblem(std::move(near), problem.loads()), mode_basis(problem, shape, setting)};
}

template <class Real>
ReducedNetwork<Real>::ReducedNetwork(const NetworkProblem& problem, const ReductionSetting& setting)
    : ReducedNetwork(problem, NearAndFar::of(problem, setting)) {}

template <class Real>
ReducedNetwork<Real>::ReducedNetwork(const NetworkProblem& problem, NearAndFar parts)
    : NearAndFar(std::move(parts)),
      ListNetwork<Real>(NearAndFar::near, {}, 0.0, true, {.further = shapes.modes()}),
      far_(problem, NearAndFar::near, shapes) {
  Eigen::VectorXd mass(this->problem().dof() + far_.modes());
  mass << this->problem().mass(), far_.mass();
  this->set_mass(mass);
}

template <class Real>
Eigen::Vector3d ReducedNetwork<Real>::moved(const Vector<Real>& all, int node) const noexcept {
  if (!shapes.holds(node)) { return Eigen::Vector3d::Zero(); }
  return shapes.of(node).transpose() *
         all.segment(this->problem().dof(), far_.modes()).template cast<double>();
}

template <class Real>
void ReducedNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v,
                                       Vector<Real>& f) noexcept {
  ListNetwork<Real>::add_springs(q, v, f);
  far_.add(q, v, f);
}

template <class Real>
double ReducedNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                             Vector<Real>& f) noexcept {
  const double of_near = ListNetwork<Real>::measure_springs(q, v, f);
  far_.add(q, v, f);
  return of_near + far_.energy(q);
}

template <class Real>
double ReducedNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  return ListNetwork<Real>::elastic_energy(q) + far_.energy(q);
}

template <class Real>
void ReducedNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                   Vector<Real>& f) noexcept {
  ListNetwork<Real>::damping(q, w, f);
  far_.add_damping(w, f);
}

template <class Real> void ReducedNetwork<Real>::pattern(Eigen::SparseMatrix<Real>& a) {
  ListNetwork<Real>::pattern(a);
  far_.find_slots(a);
}

template <class Real>
void ReducedNetwork<Real>::jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping,
                                    Real on_stiffness, Eigen::SparseMatrix<Real>& a) noexcept {
  ListNetwork<Real>::jacobian(q, v, on_damping, on_stiffness, a);
  far_.add_jacobian(on_damping, on_stiffness, a);
}

template <class Real> std::size_t ReducedNetwork<Real>::spring_bytes() const noexcept {
  return ListNetwork<Real>::spring_bytes() + far_.memory_bytes() + near.memory_bytes() +
         static_cast<std::size_t>(shapes.phi.size()) * sizeof(double) +
         shapes.column.capacity() * sizeof(shapes.column[0]);
}

template class ReducedNetwork<double>;
template class ReducedNetwork<float>;

}  // namespace palpate

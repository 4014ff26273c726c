// SPDX-License-Identifier: MIT
#include "model/stepping/far_field_network.hpp"

#include <utility>

namespace palpate {

NearAndFar NearAndFar::of(const NetworkProblem& problem, const FarFieldSetting& setting) {
  const LatticeShape shape = lattice_of(problem.network()).value();
  SpringNetwork near = problem.network();
  const auto is_far = [&](int node) { return !near.is_fixed(node) && !setting.near.holds(node); };
  near.springs.edit([&](std::vector<Spring>& springs) {
    std::erase_if(springs, [&](const Spring& spring) { return is_far(spring.a) || is_far(spring.b); });
  });
  for (int node = 0; node < shape.node_count(); ++node) {
    if (!setting.near.holds(node)) { near.fixed[static_cast<std::size_t>(node)] = 1; }
  }
  return {NetworkProblem(std::move(near), problem.loads()), far_shapes(problem, shape, setting)};
}

template <class Real>
FarFieldNetwork<Real>::FarFieldNetwork(const NetworkProblem& problem, const FarFieldSetting& setting)
    : FarFieldNetwork(problem, NearAndFar::of(problem, setting)) {}

template <class Real>
FarFieldNetwork<Real>::FarFieldNetwork(const NetworkProblem& problem, NearAndFar parts)
    : NearAndFar(std::move(parts)),
      ListNetwork<Real>(NearAndFar::near, {}, 0.0, true, {.further = shapes.modes()}),
      far_(problem, NearAndFar::near, shapes) {
  Eigen::VectorXd mass(this->problem().dof() + far_.modes());
  mass << this->problem().mass(), far_.mass();
  this->set_mass(mass);
}

template <class Real>
Eigen::Vector3d FarFieldNetwork<Real>::moved(const Vector<Real>& all, int node) const noexcept {
  if (!shapes.holds(node)) { return Eigen::Vector3d::Zero(); }
  return shapes.of(node).transpose() *
         all.segment(this->problem().dof(), far_.modes()).template cast<double>();
}

template <class Real>
void FarFieldNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept {
  ListNetwork<Real>::add_springs(q, v, f);
  far_.add(q, v, f);
}

template <class Real>
double FarFieldNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                              Vector<Real>& f) noexcept {
  const double of_near = ListNetwork<Real>::measure_springs(q, v, f);
  far_.add(q, v, f);
  return of_near + far_.energy(q);
}

template <class Real>
double FarFieldNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  return ListNetwork<Real>::elastic_energy(q) + far_.energy(q);
}

template <class Real>
void FarFieldNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept {
  ListNetwork<Real>::damping(q, w, f);
  far_.add_damping(w, f);
}

template <class Real>
void FarFieldNetwork<Real>::pattern(Eigen::SparseMatrix<Real>& a) {
  ListNetwork<Real>::pattern(a);
  far_.find_slots(a);
}

template <class Real>
void FarFieldNetwork<Real>::jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                                     Eigen::SparseMatrix<Real>& a) noexcept {
  ListNetwork<Real>::jacobian(q, v, on_damping, on_stiffness, a);
  far_.add_jacobian(on_damping, on_stiffness, a);
}

template <class Real>
std::size_t FarFieldNetwork<Real>::spring_bytes() const noexcept {
  return ListNetwork<Real>::spring_bytes() + far_.memory_bytes() + near.memory_bytes() +
         static_cast<std::size_t>(shapes.phi.size()) * sizeof(double) +
         shapes.column.capacity() * sizeof(shapes.column[0]);
}

template class FarFieldNetwork<double>;
template class FarFieldNetwork<float>;

}  // namespace palpate

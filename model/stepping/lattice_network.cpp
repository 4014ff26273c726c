// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_network.hpp"

#include <stdexcept>
#include <utility>

namespace palpate {

namespace {

template <class Real>
LatticeSprings<Real> springs_of(const NetworkProblem& problem, int lanes, bool skip) {
  const auto shape = lattice_of(problem.network());
  if (!shape) { throw std::invalid_argument("the network is no regular lattice"); }
  return LatticeSprings<Real>(problem, *shape, lanes, skip);
}

}  // namespace

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, bool skip,
                                     const lattice::Kernels<Real>& kernels)
    : LatticeNetwork(problem, springs_of<Real>(problem, kernels.lanes, skip), kernels, skip) {}

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                                     const lattice::Kernels<Real>& kernels, bool skip)
    : NetworkSystem<Real>(problem, springs.layout(), skip),
      springs_(std::move(springs)),
      view_(springs_.view()),
      kernels_(kernels),
      force_(view_.numbers > 1 ? kernels.force : kernels.undamped_force),
      measure_(view_.numbers > 1 ? kernels.measured_force : kernels.measured_undamped_force) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
  scatter(problem.mass(), this->layout(), mass);
  this->set_mass(mass);
  this->spread_weight();
}

template <class Real>
void LatticeNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v,
                                       Vector<Real>& f) noexcept {
  force_(view_, q.data(), v.data(), f.data());
}

template <class Real>
double LatticeNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                             Vector<Real>& f) noexcept {
  return measure_(view_, q.data(), v.data(), f.data());
}

template <class Real>
void LatticeNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                   Vector<Real>& f) noexcept {
  f.setZero();
  if (view_.numbers == 1) { return; }
  kernels_.damping(view_, q.data(), w.data(), f.data());
  f = -f;
}

template <class Real>
double LatticeNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  return kernels_.energy(view_, q.data(), nullptr, nullptr);
}

template class LatticeNetwork<double>;
template class LatticeNetwork<float>;

}  // namespace palpate

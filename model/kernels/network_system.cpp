// SPDX-License-Identifier: MIT

#include "model/kernels/network_system.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

#include "model/problem/spring_law.hpp"

namespace palpate {

template <class Real>
NetworkSystem<Real>::NetworkSystem(const NetworkProblem& problem, NodeLayout layout, bool skip)
    : problem_(problem), layout_(std::move(layout)), skip_(skip) {
  for (std::size_t n = 0; n < problem.loads().size(); ++n) {
    for (const int node : problem.loads()[n].nodes) {
      const Eigen::Index c = layout_.first[static_cast<std::size_t>(node)];
      if (c >= 0) { loaded_.push_back({static_cast<int>(n), c}); }
    }
  }
  const SpringNetwork& network = problem.network();
  spring_count_ =
      static_cast<std::size_t>(std::ranges::count_if(network.springs, [&](const Spring& s) {
        return !skip || !network.is_fixed(s.a) || !network.is_fixed(s.b);
      }));
}

template <class Real> void NetworkSystem<Real>::spread_weight() {
  if (problem_.gravity().isZero() && skip_) { return; }
  weight_.setZero(layout_.size);
  Eigen::VectorXd weight = problem_.mass();
  for (Eigen::Index i = 0; i < weight.size(); ++i) { weight(i) *= problem_.gravity()(i % 3); }
  scatter(weight, layout_, weight_);
}

template <class Real> Vector<Real> NetworkSystem<Real>::initial_velocity() const {
  Vector<Real> v = Vector<Real>::Zero(layout_.size);
  if (problem_.network().initial_velocity.cols() == 0) { return v; }
  scatter(problem_.initial_velocity(), layout_, v);
  return v;
}

template <class Real> NodeVectors NetworkSystem<Real>::places() const {
  assert(layout_.stride == 1);  // only lists have matrices
  NodeVectors places(3, static_cast<Eigen::Index>(problem_.free_nodes().size()));
  for (const int node : problem_.free_nodes()) {
    const Eigen::Index first = layout_.first[static_cast<std::size_t>(node)];
    places.col(first / 3) = problem_.network().rest_position.col(node);
  }
  return places;
}

template <class Real>
void NetworkSystem<Real>::force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                                Vector<Real>& f) noexcept {
  put_weight(f);
  add_loads(t, gate, Real(1), f);
  reach(t);
  add_springs(q, v, f);
}

template <class Real>
double NetworkSystem<Real>::measure(double t, double gate, const Vector<Real>& q,
                                    const Vector<Real>& v, Vector<Real>& f) noexcept {
  put_weight(f);
  add_loads(t, gate, Real(1), f);
  reach(t);
  return measure_springs(q, v, f);
}

/// Writes the weight. f may be longer than this network: a tool's coordinate follows.
template <class Real> void NetworkSystem<Real>::put_weight(Vector<Real>& f) const noexcept {
  f.head(weight_.size()) = weight_;
  f.tail(f.size() - weight_.size()).setZero();
}

template <class Real>
void NetworkSystem<Real>::add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept {
  for (const LoadOnCoordinate& on : loaded_) {
    const Load& load = problem_.loads()[static_cast<std::size_t>(on.load)];
    const Eigen::Vector3d force = load_factor(load, t, gate) * load.force;
    at_node(f, on.coordinate, layout_.stride) += weight * force.template cast<Real>();
  }
}

template <class Real>
double NetworkSystem<Real>::energy(const Vector<Real>& q, const Vector<Real>& v,
                                   double elastic) const noexcept {
  const Eigen::Index n = layout_.size;
  double energy = 0.5 * v.head(n).template cast<double>().cwiseAbs2().dot(
                            this->mass().template cast<double>()) +
                  elastic;
  if (weight_.size() > 0) {
    energy -= weight_.template cast<double>().dot(q.head(n).template cast<double>());
  }
  return energy;
}

template <class Real>
int NetworkSystem<Real>::zero_length_springs(const Vector<Real>& q) const noexcept {
  const auto place = [&](int node) -> Eigen::Matrix<Real, 3, 1> {
    const Eigen::Index c = layout_.first[static_cast<std::size_t>(node)];
    if (c < 0) { return problem_.network().initial_place(node).template cast<Real>(); }
    return at_node(q, c, layout_.stride);
  };
  int count = 0;
  for (const Spring& s : problem_.network().springs) {
    if (problem_.network().is_fixed(s.a) && problem_.network().is_fixed(s.b)) { continue; }
    count += (place(s.b) - place(s.a)).norm() > static_cast<Real>(zero_length) ? 0 : 1;
  }
  return count;
}

template <class Real> std::size_t NetworkSystem<Real>::memory_bytes() const noexcept {
  const auto numbers =
      static_cast<std::size_t>(weight_.size() + this->mass().size() + this->inverse_mass().size());
  return spring_bytes() + numbers * sizeof(Real) + layout_.first.capacity() * sizeof(int) +
         loaded_.capacity() * sizeof(LoadOnCoordinate);
}

template class NetworkSystem<double>;
template class NetworkSystem<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "model/stepping/network_system.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace

template <class Real>
NetworkSystem<Real>::NetworkSystem(const NetworkProblem& problem, const PrintedForm& printed,
                                   double h, bool skip)
    : loads_(problem.loads()), gravity_(problem.gravity()) {
  this->set_mass(problem.mass());
  sort_springs(problem, skip);
  const auto& all = problem.network().springs;
  damped_ = std::ranges::any_of(all, [](const Spring& s) { return s.viscosity != 0.0; });
  PrintedForm law_only = printed;
  law_only.no_time_step = false;
  springs_.law = SpringLaw::from(printed);
  springs_.lagged = printed.lagged_velocity;
  springs_.lag = static_cast<Real>(h);
  kernel_ = spring_kernel_for<Real>({.damped = damped_ || !skip, .printed = law_only.any()});
  if (springs_.lagged) {
    const Vector<Real> q = problem.initial_position().template cast<Real>();
    for (const auto& s : springs_.links) {
      springs_.previous_length.push_back(
          (q.template segment<3>(s.b) - q.template segment<3>(s.a)).norm());
    }
    for (const auto& s : springs_.anchors) {
      springs_.previous_length.push_back(
          (Eigen::Map<const Eigen::Matrix<Real, 3, 1>>(s.place) - q.template segment<3>(s.a)).norm());
    }
  }
  for (std::size_t n = 0; n < loads_.size(); ++n) {
    for (const int node : loads_[n].nodes) {
      const Eigen::Index c = problem.coordinate(node);
      if (c >= 0) { loaded_.push_back({static_cast<int>(n), static_cast<int>(c)}); }
    }
  }
  weighs_ = !gravity_.isZero() || !skip;
  if (weighs_) {
    weight_.resize(this->dof());
    for (Eigen::Index i = 0; i < this->dof(); i += 3) {
      weight_.template segment<3>(i) = (problem.mass()(i) * gravity_).template cast<Real>();
    }
  }
}

template <class Real>
void NetworkSystem<Real>::sort_springs(const NetworkProblem& problem, bool skip) {
  const NodeVectors places = problem.network().initial_position();
  for (const Spring& s : problem.network().springs) {
    int a = static_cast<int>(problem.coordinate(s.a));
    int b = static_cast<int>(problem.coordinate(s.b));
    int fixed_node = s.b;
    if (a < 0 && b < 0) {
      if (!skip) { between_fixed_.push_back(s); }
      continue;
    }
    if (a < 0) {
      std::swap(a, b);
      fixed_node = s.a;
    }
    const Real k = static_cast<Real>(s.stiffness);
    const Real c = static_cast<Real>(s.viscosity);
    const Real rest = static_cast<Real>(s.rest_length);
    if (b >= 0) {
      springs_.links.push_back({a, b, k, c, rest});
    } else {
      Anchor<Real> anchor{a, k, c, rest, {}};
      for (int n = 0; n < 3; ++n) { anchor.place[n] = static_cast<Real>(places(n, fixed_node)); }
      springs_.anchors.push_back(anchor);
    }
  }
  // Neighbours in memory are neighbours in space; a stable order keeps sums reproducible.
  std::ranges::stable_sort(springs_.links, [](const auto& l, const auto& r) {
    return std::min(l.a, l.b) < std::min(r.a, r.b);
  });
  std::ranges::stable_sort(springs_.anchors, {}, &Anchor<Real>::a);
  if (between_fixed_.empty()) { return; }
  const auto nodes = places.cols();
  fixed_q_ = Eigen::Map<const Eigen::VectorXd>(places.data(), 3 * nodes).template cast<Real>();
  fixed_v_.setZero(3 * nodes);
  fixed_f_.setZero(3 * nodes);
  for (const Spring& s : between_fixed_) {
    fixed_pairs_.links.push_back({3 * s.a, 3 * s.b, static_cast<Real>(s.stiffness),
                                  static_cast<Real>(s.viscosity), static_cast<Real>(s.rest_length)});
  }
}

template <class Real>
void NetworkSystem<Real>::force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                                Vector<Real>& f) noexcept {
  f.setZero();  // may be longer than this network: a tool's coordinate comes after it
  if (weighs_) { f.head(weight_.size()) = weight_; }
  kernel_(springs_, q.data(), v.data(), f.data());
  if (!fixed_pairs_.links.empty()) {
    kernel_(fixed_pairs_, fixed_q_.data(), fixed_v_.data(), fixed_f_.data());
  }
  add_loads(t, gate, Real(1), f);
}

template <class Real>
void NetworkSystem<Real>::add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept {
  for (const LoadOnCoordinate& on : loaded_) {
    const Load& load = loads_[static_cast<std::size_t>(on.load)];
    const double factor = load_factor(load, t, gate);
    if (factor == 0.0) { continue; }
    f.template segment<3>(on.coordinate) += weight * (factor * load.force).template cast<Real>();
  }
}

template <class Real>
void NetworkSystem<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                  Vector<Real>& f) noexcept {
  f.setZero();
  if (!damped_) { return; }
  add_damping(springs_, q.data(), w.data(), f.data());
  f = -f;
}

template <class Real>
void NetworkSystem<Real>::pattern(Eigen::SparseMatrix<Real>& a) {
  std::vector<Eigen::Triplet<Real>> triplets;
  triplets.reserve(18 * springs_.links.size() + static_cast<std::size_t>(9 * this->dof()));
  const auto block = [&](Eigen::Index row, Eigen::Index column) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        triplets.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), Real(0));
      }
    }
  };
  for (Eigen::Index i = 0; i < this->dof(); i += 3) { block(i, i); }
  for (const auto& s : springs_.links) {
    block(s.a, s.b);
    block(s.b, s.a);
  }
  a.resize(this->dof(), this->dof());
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
  for (const auto& s : springs_.links) {
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
  for (const auto& s : springs_.anchors) {
    anchor_slots_.push_back({slot(s.a, s.a), slot(s.a, s.a + 1), slot(s.a, s.a + 2)});
  }
  for (int i = 0; i < this->dof(); ++i) { diagonal_slots_.push_back(slot(i, i)); }
}

template <class Real>
void NetworkSystem<Real>::add_block(Real* values, const std::int64_t* columns, Real factor,
                                    const Eigen::Matrix<Real, 3, 3>& block) const noexcept {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) { values[columns[c] + r] += factor * block(r, c); }
  }
}

template <class Real>
void NetworkSystem<Real>::jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping,
                                   Real on_stiffness, Eigen::SparseMatrix<Real>& a) noexcept {
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  Real* values = a.valuePtr();
  std::fill(values, values + a.nonZeros(), Real(0));
  for (Eigen::Index i = 0; i < this->dof(); ++i) {
    values[diagonal_slots_[static_cast<std::size_t>(i)]] = this->mass()(i);
  }
  for (std::size_t n = 0; n < springs_.links.size(); ++n) {
    const auto& s = springs_.links[n];
    const Vector3 d = q.template segment<3>(s.b) - q.template segment<3>(s.a);
    const Vector3 w = v.template segment<3>(s.b) - v.template segment<3>(s.a);
    const auto g = gradient_of<Real>(springs_.law, s, d, w);
    const Eigen::Matrix<Real, 3, 3> block = on_stiffness * g.position + on_damping * g.velocity;
    const auto& slots = link_slots_[n];
    add_block(values, slots.data(), Real(1), block);
    add_block(values, slots.data() + 3, Real(1), block);
    add_block(values, slots.data() + 6, Real(-1), block);
    add_block(values, slots.data() + 9, Real(-1), block);
  }
  for (std::size_t n = 0; n < springs_.anchors.size(); ++n) {
    const auto& s = springs_.anchors[n];
    const Vector3 d = Eigen::Map<const Vector3>(s.place) - q.template segment<3>(s.a);
    const Vector3 w = -v.template segment<3>(s.a);
    const auto g = gradient_of<Real>(springs_.law, s, d, w);
    const Eigen::Matrix<Real, 3, 3> block = on_stiffness * g.position + on_damping * g.velocity;
    add_block(values, anchor_slots_[n].data(), Real(1), block);
  }
}

template <class Real>
double NetworkSystem<Real>::energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept {
  double energy = 0.0;
  for (Eigen::Index i = 0; i < this->dof(); ++i) {
    const double speed = static_cast<double>(v(i));
    const double height = gravity_(i % 3) * static_cast<double>(q(i));
    energy += static_cast<double>(this->mass()(i)) * (0.5 * speed * speed - height);
  }
  const auto elastic = [](const auto& s, double length) {
    const double extension = length - static_cast<double>(s.rest_length);
    return 0.5 * static_cast<double>(s.stiffness) * extension * extension;
  };
  for (const auto& s : springs_.links) {
    energy += elastic(s, static_cast<double>(
                             (q.template segment<3>(s.b) - q.template segment<3>(s.a)).norm()));
  }
  for (const auto& s : springs_.anchors) {
    const Eigen::Map<const Eigen::Matrix<Real, 3, 1>> place(s.place);
    energy += elastic(s, static_cast<double>((place - q.template segment<3>(s.a)).norm()));
  }
  return energy;
}

template <class Real>
int NetworkSystem<Real>::zero_length_springs(const Vector<Real>& q) const noexcept {
  int count = 0;
  for (const auto& s : springs_.links) {
    const auto length = (q.template segment<3>(s.b) - q.template segment<3>(s.a)).norm();
    count += length > static_cast<Real>(zero_length) ? 0 : 1;
  }
  for (const auto& s : springs_.anchors) {
    const Eigen::Map<const Eigen::Matrix<Real, 3, 1>> place(s.place);
    count += (place - q.template segment<3>(s.a)).norm() > static_cast<Real>(zero_length) ? 0 : 1;
  }
  return count;
}

template <class Real>
std::size_t NetworkSystem<Real>::memory_bytes() const noexcept {
  const auto coordinates = static_cast<std::size_t>(this->dof());
  return springs_.links.size() * sizeof(Link<Real>) + springs_.anchors.size() * sizeof(Anchor<Real>) +
         springs_.previous_length.size() * sizeof(Real) +
         coordinates * sizeof(Real) * (weighs_ ? 3 : 2) + loaded_.size() * sizeof(LoadOnCoordinate) +
         link_slots_.size() * sizeof(link_slots_[0]);
}

template class NetworkSystem<double>;
template class NetworkSystem<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/kernels/list_network.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace palpate {

namespace {

template <class Real>
void add_block(Real* values, const std::int64_t* columns, Real factor,
               const Eigen::Matrix<Real, 3, 3>& block) noexcept {
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) { values[columns[c] + r] += factor * block(r, c); }
  }
}

}  // namespace

template <class Real>
void SpringMatrices<Real>::pattern(const SpringSet<Real>& springs, Eigen::Index of_nodes,
                                   Eigen::Index size, std::vector<Eigen::Triplet<Real>> further,
                                   Eigen::SparseMatrix<Real>& a) {
  std::vector<Eigen::Triplet<Real>> triplets = std::move(further);
  triplets.reserve(triplets.size() + 18 * springs.links.size() +
                   static_cast<std::size_t>(9 * of_nodes));
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
void SpringMatrices<Real>::jacobian(const SpringSet<Real>& springs, const At& at,
                                    const Vector<Real>& mass,
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
    const auto g = spring_gradient<Real>(springs.law, numbers_of<Real>(s), d, w);
    const Eigen::Matrix<Real, 3, 3> block =
        at.on_stiffness * g.position + at.on_damping * g.velocity;
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
    const auto g = spring_gradient<Real>(springs.law, numbers_of<Real>(s), d, w);
    const Eigen::Matrix<Real, 3, 3> block =
        at.on_stiffness * g.position + at.on_damping * g.velocity;
    add_block(values, anchor_slots_[n].data(), Real(1), block);
  }
}

template class SpringMatrices<double>;
template class SpringMatrices<float>;

namespace {

int spacing_of(const ListVectors& vectors) { return vectors.padded ? adjacency::node_stride : 3; }

/// Returns an index for each fixed node with a spring to a free node, in node order; -1 for all
/// other nodes.
std::vector<int> places_of(const SpringNetwork& network) {
  std::vector<int> places(static_cast<std::size_t>(network.node_count()), -1);
  const auto find = [&](int node, int other) {
    if (network.is_fixed(node) && !network.is_fixed(other)) {
      places[static_cast<std::size_t>(node)] = 0;
    }
  };
  for (const Spring& s : network.springs) {
    find(s.a, s.b);
    find(s.b, s.a);
  }
  int count = 0;
  for (int& place : places) {
    if (place == 0) { place = count++; }
  }
  return places;
}

}  // namespace

template <class Real>
ListNetwork<Real>::ListNetwork(const NetworkProblem& problem, const PrintedForm& printed, double h,
                               bool skip, const ListVectors& vectors)
    : NetworkSystem<Real>(problem, layout_of(problem, vectors), skip),
      spacing_(spacing_of(vectors)) {
  if (vectors.further == 0) {
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
    scatter(problem.mass(), this->layout(), mass);
    this->set_mass(mass);
  }
  sort_springs(problem, skip);
  damped_ = is_damped(problem.network().springs);
  springs_.law = SpringLaw::from(printed);
  springs_.lagged = printed.lagged_velocity;
  springs_.lag = static_cast<Real>(h);
  kernel_ = spring_kernel_for<Real>(
      {.damped = damped_ || !skip, .printed = SpringLaw::is_printed(printed)});
  if (springs_.lagged) { remember_lengths(); }
  if (!SpringLaw::is_printed(printed)) { groups_.take(springs_, damped_ || !skip, spacing_); }
  this->spread_weight();
}

template <class Real>
NodeLayout ListNetwork<Real>::layout_of(const NetworkProblem& problem, const ListVectors& vectors) {
  const int spacing = spacing_of(vectors);
  const auto at = [&](Eigen::Index coordinate) {
    return coordinate < 0 ? coordinate : coordinate / 3 * spacing;
  };
  NodeLayout layout{.size = at(problem.dof()) + vectors.further, .stride = 1};
  for (int node = 0; node < problem.network().node_count(); ++node) {
    layout.first.push_back(at(problem.coordinate(node)));
  }
  if (vectors.padded) {
    const auto held =
        std::ranges::count_if(places_of(problem.network()), [](int place) { return place >= 0; });
    layout.size += adjacency::node_stride * held;
  }
  return layout;
}

template <class Real> void ListNetwork<Real>::remember_lengths() {
  const Vector<Real> q = ListNetwork::initial_position();
  for (const auto& s : springs_.links) {
    springs_.previous_length.push_back(
        (q.template segment<3>(s.b) - q.template segment<3>(s.a)).norm());
  }
  for (const auto& s : springs_.anchors) {
    springs_.previous_length.push_back(
        (Eigen::Map<const Eigen::Matrix<Real, 3, 1>>(s.place) - q.template segment<3>(s.a)).norm());
  }
}

template <class Real>
void ListNetwork<Real>::sort_springs(const NetworkProblem& problem, bool skip) {
  const NodeVectors& places = problem.held_position();
  const std::vector<int> places_behind = places_of(problem.network());
  const int free_end = static_cast<int>(problem.dof()) / 3 * spacing_;
  const auto first = [&](int node) {
    return static_cast<int>(this->layout().first[static_cast<std::size_t>(node)]);
  };
  std::vector<Spring> between_fixed;
  for (const Spring& s : problem.network().springs) {
    int a = first(s.a);
    int b = first(s.b);
    int fixed_node = s.b;
    if (a < 0 && b < 0) {
      if (!skip) { between_fixed.push_back(s); }
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
      const int place = places_behind[static_cast<std::size_t>(fixed_node)];
      Anchor<Real> anchor{a, free_end + spacing_ * place, k, c, rest, {}};
      for (int n = 0; n < 3; ++n) { anchor.place[n] = static_cast<Real>(places(n, fixed_node)); }
      springs_.anchors.push_back(anchor);
    }
  }
  // Nodes close in memory are close in space. A stable order makes sums reproducible.
  std::ranges::stable_sort(springs_.links, [](const auto& l, const auto& r) {
    return std::min(l.a, l.b) < std::min(r.a, r.b);
  });
  std::ranges::stable_sort(springs_.anchors, {}, &Anchor<Real>::a);
  if (between_fixed.empty()) { return; }
  const auto nodes = places.cols();
  fixed_q_ = Eigen::Map<const Eigen::VectorXd>(places.data(), 3 * nodes).template cast<Real>();
  fixed_v_.setZero(3 * nodes);
  fixed_f_.setZero(3 * nodes);
  for (const Spring& s : between_fixed) {
    fixed_pairs_.links.push_back({3 * s.a, 3 * s.b, static_cast<Real>(s.stiffness),
                                  static_cast<Real>(s.viscosity),
                                  static_cast<Real>(s.rest_length)});
  }
}

template <class Real> Vector<Real> ListNetwork<Real>::initial_position() const {
  Vector<Real> q = Vector<Real>::Zero(this->layout().size);
  scatter(this->problem().initial_position(), this->layout(), q);
  if (spacing_ == adjacency::node_stride) {
    for (const auto& s : springs_.anchors) {
      q.template segment<3>(s.b) = Eigen::Map<const Eigen::Matrix<Real, 3, 1>>(s.place);
    }
  }
  return q;
}

template <class Real>
void ListNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v,
                                    Vector<Real>& f) noexcept {
  if (groups_.empty()) {
    kernel_(springs_, q.data(), v.data(), f.data());
  } else {
    groups_.add(q.data(), v.data(), f.data());
  }
  add_fixed_pairs();
}

template <class Real>
double ListNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                          Vector<Real>& f) noexcept {
  if (groups_.empty()) { return NetworkSystem<Real>::measure_springs(q, v, f); }
  const double energy = groups_.measure(q.data(), v.data(), f.data());
  add_fixed_pairs();
  return energy;
}

template <class Real> void ListNetwork<Real>::add_fixed_pairs() noexcept {
  if (!fixed_pairs_.links.empty()) {
    kernel_(fixed_pairs_, fixed_q_.data(), fixed_v_.data(), fixed_f_.data());
  }
}

template <class Real> void ListNetwork<Real>::prepare_one_pass() {
  next_force_.setZero(this->layout().size);
  this->put_weight(next_force_);
}

template <class Real>
double ListNetwork<Real>::one_pass(double t, double gate, Real h, State<Real>& state) noexcept {
  this->add_loads(t, gate, Real(1), next_force_);
  add_springs(state.position, state.velocity, next_force_);
  return groups_.advance({.q = state.position.data(),
                          .v = state.velocity.data(),
                          .f = next_force_.data(),
                          .inverse_mass = this->inverse_mass().data(),
                          .weight = this->weight().size() > 0 ? this->weight().data() : nullptr,
                          .h = h},
                         this->layout().size / adjacency::node_stride);
}

template <class Real>
void ListNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                Vector<Real>& f) noexcept {
  f.setZero();
  if (!damped_) { return; }
  add_damping(springs_, q.data(), w.data(), f.data());
  f = -f;
}

template <class Real> void ListNetwork<Real>::pattern(Eigen::SparseMatrix<Real>& a) {
  assert(spacing_ == 3);
  std::vector<Eigen::Triplet<Real>> further;
  add_entries(further);
  matrices_.pattern(springs_, this->problem().dof(), this->dof(), std::move(further), a);
}

template <class Real>
void ListNetwork<Real>::jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping,
                                 Real on_stiffness, Eigen::SparseMatrix<Real>& a) noexcept {
  matrices_.jacobian(springs_,
                     {.q = q, .v = v, .on_damping = on_damping, .on_stiffness = on_stiffness},
                     this->mass(), a);
}

template <class Real>
double ListNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  double energy = 0.0;
  const auto elastic = [](const auto& s, double length) {
    return 0.5 * add_twice_energy(numbers_of<double>(s), length, 0.0);
  };
  for (const auto& s : springs_.links) {
    energy += elastic(
        s, static_cast<double>((q.template segment<3>(s.b) - q.template segment<3>(s.a)).norm()));
  }
  for (const auto& s : springs_.anchors) {
    const Eigen::Map<const Eigen::Matrix<Real, 3, 1>> place(s.place);
    energy += elastic(s, static_cast<double>((place - q.template segment<3>(s.a)).norm()));
  }
  return energy;
}

template <class Real> std::size_t ListNetwork<Real>::spring_bytes() const noexcept {
  return springs_.links.size() * sizeof(Link<Real>) +
         springs_.anchors.size() * sizeof(Anchor<Real>) +
         springs_.previous_length.size() * sizeof(Real) + matrices_.memory_bytes() +
         static_cast<std::size_t>(next_force_.size()) * sizeof(Real) + groups_.memory_bytes();
}

template class ListNetwork<double>;
template class ListNetwork<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/kernels/spring_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "model/kernels/instruction_set.hpp"

namespace palpate {

namespace {

template <class Real> using Vector3 = Eigen::Matrix<Real, 3, 1>;

template <class Real> Real dot(const Vector3<Real>& a, const Vector3<Real>& b) noexcept {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

/// Adds factor d to the force on node a and subtracts it at a free node b.
template <class Real>
void add(Real* f, int a, int b, Real factor, const Vector3<Real>& d) noexcept {
  Eigen::Map<Vector3<Real>>(f + a) += factor * d;
  if (b >= 0) { Eigen::Map<Vector3<Real>>(f + b) -= factor * d; }
}

}  // namespace

template <class Real>
void add_forces(SpringSet<Real>& springs, const Real* q, const Real* v, Real* f) noexcept {
  for_each_spring(
      springs, q, v, [&](std::size_t index, const auto& s, int b, const auto& d, const auto& w) {
        const Real length = std::sqrt(dot<Real>(d, d));
        if (!(length > static_cast<Real>(zero_length))) {
          if (length != length) { add(f, s.a, b, length, d); }  // NaN must reach the state
          return;
        }
        Real rate = dot<Real>(w, d) / length;
        if (springs.lagged) {
          rate = (length - springs.previous_length[index]) / springs.lag;
          springs.previous_length[index] = length;
        }
        add(f, s.a, b, spring_force(springs.law, numbers_of<Real>(s), Real(1), length, rate), d);
      });
}

template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept {
  constexpr SpringTerms damper{.elastic = false};
  for_each_spring(
      springs, q, w, [&](std::size_t, const auto& s, int b, const auto& d, const auto& relative) {
        const Real length = std::sqrt(dot<Real>(d, d));
        const Real inverse = length > static_cast<Real>(zero_length) ? Real(1) / length : Real(0);
        const Real tension =
            static_cast<Real>(springs.law.scale) *
            SpringTension<damper>::of(springs.law.with_signs(numbers_of<Real>(s)), length,
                                      Real(dot<Real>(relative, d) * inverse));
        add(f, s.a, b, Real(tension * (springs.law.along_displacement ? Real(1) : inverse)), d);
      });
}

template void add_forces(SpringSet<double>&, const double*, const double*, double*) noexcept;
template void add_forces(SpringSet<float>&, const float*, const float*, float*) noexcept;
template void add_damping(const SpringSet<double>&, const double*, const double*, double*) noexcept;
template void add_damping(const SpringSet<float>&, const float*, const float*, float*) noexcept;

template <> std::vector<adjacency::Kernels<double>> adjacency_kernels() {
  return kernels_here(&KernelSet::adjacency_double);
}
template <> std::vector<adjacency::Kernels<float>> adjacency_kernels() {
  return kernels_here(&KernelSet::adjacency_float);
}

template <class Real> void AdjacencySprings<Real>::make_padded(const SpringSet<Real>& springs) {
  long nodes = free_nodes_;
  for (const Anchor<Real>& s : springs.anchors) { nodes = std::max(nodes, s.b / 3 + 1L); }
  const auto numbers = static_cast<std::size_t>(adjacency::node_stride * nodes);
  q_.assign(numbers, Real(0));
  f_.assign(numbers, Real(0));
  if (damped_) { v_.assign(numbers, Real(0)); }
  for (const Anchor<Real>& s : springs.anchors) {
    std::ranges::copy(s.place, q_.begin() + adjacency::node_stride * (s.b / 3));
  }
}

template <class Real>
double AdjacencySprings<Real>::add_with(adjacency::Force<Real> kernel, const Real* q, const Real* v,
                                        Real* f, adjacency::View<Real> view) noexcept {
  view.groups = groups_.data();
  view.count = static_cast<long>(groups_.size());
  view.partners = partners_.data();
  view.numbers = numbers_.data();
  if (q_.empty()) { return kernel(view, q, v, f); }
  kernels_.spread(q, free_nodes_, q_.data());
  if (f == nullptr) { return kernel(view, q_.data(), nullptr, nullptr); }
  if (damped_) { kernels_.spread(v, free_nodes_, v_.data()); }
  std::ranges::fill(f_, Real(0));
  const double energy = kernel(view, q_.data(), v_.data(), f_.data());
  kernels_.collect(f_.data(), free_nodes_, f);
  return energy;
}

template <class Real>
void AdjacencySprings<Real>::add_group(int node, std::span<const Link<Real>> members) {
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  const auto numbers_of_batch = lanes * static_cast<std::size_t>(adjacency::batch_numbers(damped_));
  adjacency::Group group{.node = adjacency::node_stride * node};
  for (; !members.empty(); ++group.batches) {
    const std::size_t partner = partners_.size();
    const std::size_t number = numbers_.size();
    partners_.resize(partner + lanes, group.node);
    numbers_.resize(number + numbers_of_batch, Real(0));
    if (!lane_of_.empty()) {  // a law divides by the rest length, also of springs that only fill
      std::fill_n(numbers_.begin() + static_cast<std::ptrdiff_t>(number + lanes), lanes, Real(1));
    }
    const std::size_t count = std::min(lanes, members.size());
    for (std::size_t n = 0; n < count; ++n) {
      partners_[partner + n] = adjacency::node_stride * members[n].b;
      if (!lane_of_.empty()) {
        lane_of_[static_cast<std::size_t>(members[n].law)] = static_cast<int>(partner + n);
      }
      numbers_[number + n] = members[n].stiffness;
      numbers_[number + lanes + n] = members[n].rest_length;
      if (damped_) { numbers_[number + 2 * lanes + n] = members[n].viscosity; }
    }
    members = members.subspan(count);
  }
  groups_.push_back(group);
}

/// Assigns each spring to the adjacency group of one of its ends, in node order. A node computes as
/// many unassigned springs as fill its batches; the others are left to the nodes at their other
/// ends.
template <class Real>
void AdjacencySprings<Real>::take(const SpringSet<Real>& springs, bool damped, int spacing,
                                  int law) {
  damped_ = damped;
  force_ = damped ? kernels_.damped : kernels_.undamped;
  measured_force_ = damped ? kernels_.damped_measured : kernels_.undamped_measured;
  free_nodes_ = 0;
  for (const Link<Real>& s : springs.links) {
    free_nodes_ = std::max(free_nodes_, std::max(s.a, s.b) / spacing + 1L);
  }
  for (const Anchor<Real>& s : springs.anchors) {
    free_nodes_ = std::max(free_nodes_, s.a / spacing + 1L);
  }
  if (spacing != adjacency::node_stride) { make_padded(springs); }
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  std::vector<std::vector<Link<Real>>> must(static_cast<std::size_t>(free_nodes_));
  if (law > 0) { lane_of_.assign(springs.links.size() + springs.anchors.size(), -1); }
  std::vector<Link<Real>> links;
  int index = 0;  // carried by a grouped spring in place of its law
  for (const Link<Real>& s : springs.links) {
    if (s.law == law) {
      links.push_back(s);
      links.back().law = index;
    }
    ++index;
  }
  for (const Anchor<Real>& s : springs.anchors) {
    if (s.law == law) {
      const int node = s.a / spacing;
      auto& own = must[static_cast<std::size_t>(node)];
      own.push_back(s.template between<Real>(node, s.b / spacing));
      own.back().law = index;
    }
    ++index;
  }
  for (Link<Real>& s : links) {
    const auto [first, last] = std::minmax({s.a / spacing, s.b / spacing});
    s.a = first;
    s.b = last;
  }
  std::ranges::stable_sort(links, {}, &Link<Real>::a);
  auto link = links.begin();
  for (int node = 0; node < static_cast<int>(free_nodes_); ++node) {
    std::vector<Link<Real>> members = std::move(must[static_cast<std::size_t>(node)]);
    const auto end =
        std::find_if(link, links.end(), [&](const Link<Real>& s) { return s.a != node; });
    const std::size_t most = members.size() + static_cast<std::size_t>(end - link);
    const std::size_t full = most / lanes * lanes;
    const std::size_t taken = full < members.size() ? most : full;
    for (; link != end; ++link) {
      if (members.size() < taken) {
        members.push_back(*link);
      } else {
        must[static_cast<std::size_t>(link->b)].push_back(
            link->template between<Real>(link->b, node));
      }
    }
    if (!members.empty()) { add_group(node, members); }
  }
  lanes_ = partners_.size();
  const auto ahead = lanes * static_cast<std::size_t>(adjacency::batches_ahead);
  partners_.resize(partners_.size() + ahead);
  numbers_.resize(numbers_.size() +
                  ahead * static_cast<std::size_t>(adjacency::batch_numbers(damped_)));
}

template class AdjacencySprings<double>;
template class AdjacencySprings<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "model/stepping/spring_fans.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "model/stepping/instruction_set.hpp"

namespace palpate {

template <class Real>
std::vector<fans::Kernels<Real>> fan_kernels() {
  return kernels_here(&fans::avx2_kernels<Real>, &fans::baseline_kernels<Real>);
}

template <class Real>
void SpringFans<Real>::make_quads(const SpringSet<Real>& springs) {
  long nodes = free_nodes_;
  for (const Anchor<Real>& s : springs.anchors) { nodes = std::max(nodes, s.b / 3 + 1L); }
  const auto numbers = static_cast<std::size_t>(fans::quad * nodes);
  q_.assign(numbers, Real(0));
  f_.assign(numbers, Real(0));
  if (damped_) { v_.assign(numbers, Real(0)); }
  for (const Anchor<Real>& s : springs.anchors) { std::ranges::copy(s.place, q_.begin() + fans::quad * (s.b / 3)); }
}

template <class Real>
double SpringFans<Real>::add_with(fans::Force<Real> kernel, const Real* q, const Real* v, Real* f) noexcept {
  const fans::View<Real> view{.fans = fans_.data(),
                              .count = static_cast<long>(fans_.size()),
                              .partners = partners_.data(),
                              .numbers = numbers_.data()};
  if (q_.empty()) { return kernel(view, q, v, f); }
  kernels_.spread(q, free_nodes_, q_.data());
  if (damped_) { kernels_.spread(v, free_nodes_, v_.data()); }
  std::ranges::fill(f_, Real(0));
  const double energy = kernel(view, q_.data(), v_.data(), f_.data());
  kernels_.collect(f_.data(), free_nodes_, f);
  return energy;
}

template <class Real>
void SpringFans<Real>::add_fan(int node, std::span<const Member> members) {
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  const auto numbers_of_group = lanes * static_cast<std::size_t>(fans::group_numbers(damped_));
  fans::Fan fan{.node = fans::quad * node};
  for (; !members.empty(); ++fan.groups) {
    const std::size_t partner = partners_.size();
    const std::size_t number = numbers_.size();
    partners_.resize(partner + lanes, fan.node);
    numbers_.resize(number + numbers_of_group, Real(0));
    const std::size_t count = std::min(lanes, members.size());
    for (std::size_t n = 0; n < count; ++n) {
      partners_[partner + n] = fans::quad * members[n].partner;
      numbers_[number + n] = members[n].stiffness;
      numbers_[number + lanes + n] = members[n].rest_length;
      if (damped_) { numbers_[number + 2 * lanes + n] = members[n].viscosity; }
    }
    members = members.subspan(count);
  }
  fans_.push_back(fan);
}

/// Node by node, each answers for the springs that no earlier one does: as many as fill its groups, the others are
/// left to the nodes at their other ends.
template <class Real>
void SpringFans<Real>::take(const SpringSet<Real>& springs, bool damped, int spacing) {
  damped_ = damped;
  force_ = damped ? kernels_.damped : kernels_.undamped;
  measured_force_ = damped ? kernels_.damped_measured : kernels_.undamped_measured;
  free_nodes_ = 0;
  for (const Link<Real>& s : springs.links) { free_nodes_ = std::max(free_nodes_, std::max(s.a, s.b) / spacing + 1L); }
  for (const Anchor<Real>& s : springs.anchors) { free_nodes_ = std::max(free_nodes_, s.a / spacing + 1L); }
  if (spacing != fans::quad) { make_quads(springs); }
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  std::vector<std::vector<Member>> must(static_cast<std::size_t>(free_nodes_));
  for (const Anchor<Real>& s : springs.anchors) {
    must[static_cast<std::size_t>(s.a / spacing)].push_back({s.b / spacing, s.stiffness, s.viscosity, s.rest_length});
  }
  std::vector<Link<Real>> links = springs.links;
  for (Link<Real>& s : links) {
    const auto [first, last] = std::minmax({s.a / spacing, s.b / spacing});
    s.a = first;
    s.b = last;
  }
  std::ranges::stable_sort(links, {}, &Link<Real>::a);
  auto link = links.begin();
  for (int node = 0; node < static_cast<int>(free_nodes_); ++node) {
    std::vector<Member> members = std::move(must[static_cast<std::size_t>(node)]);
    const auto end = std::find_if(link, links.end(), [&](const Link<Real>& s) { return s.a != node; });
    const std::size_t most = members.size() + static_cast<std::size_t>(end - link);
    const std::size_t full = most / lanes * lanes;
    const std::size_t taken = full < members.size() ? most : full;
    for (; link != end; ++link) {
      if (members.size() < taken) {
        members.push_back({link->b, link->stiffness, link->viscosity, link->rest_length});
      } else {
        must[static_cast<std::size_t>(link->b)].push_back({node, link->stiffness, link->viscosity, link->rest_length});
      }
    }
    if (!members.empty()) { add_fan(node, members); }
  }
  const auto ahead = lanes * static_cast<std::size_t>(fans::groups_ahead);
  partners_.resize(partners_.size() + ahead);
  numbers_.resize(numbers_.size() + ahead * static_cast<std::size_t>(fans::group_numbers(damped_)));
}

template std::vector<fans::Kernels<double>> fan_kernels<double>();
template std::vector<fans::Kernels<float>> fan_kernels<float>();
template class SpringFans<double>;
template class SpringFans<float>;

}  // namespace palpate

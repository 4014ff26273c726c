// SPDX-License-Identifier: MIT
#include "model/stepping/spring_fans.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <map>
#include <utility>

#include "model/stepping/instruction_set.hpp"

namespace palpate {

static_assert(fans::View<double>::zero_length == zero_length);

template <class Real>
std::vector<fans::Kernels<Real>> fan_kernels() {
  return kernels_here(&fans::avx2_kernels<Real>, &fans::baseline_kernels<Real>);
}

template <class Real>
std::vector<int> SpringFans<Real>::place_nodes(const SpringSet<Real>& springs) {
  int last = -1;
  for (const Link<Real>& s : springs.links) { last = std::max({last, s.a / 3, s.b / 3}); }
  for (const Anchor<Real>& s : springs.anchors) { last = std::max(last, s.a / 3); }
  free_nodes_ = last + 1;
  using Place = std::array<Real, 3>;
  std::map<std::array<std::byte, sizeof(Place)>, int> places;  // by their bits, which NaN has too
  std::vector<int> nodes;
  nodes.reserve(springs.anchors.size());
  for (const Anchor<Real>& s : springs.anchors) {
    const int next = last + 1 + static_cast<int>(places.size());
    nodes.push_back(places.try_emplace(std::bit_cast<std::array<std::byte, sizeof(Place)>>(s.place), next).first->second);
  }
  const auto width = static_cast<std::size_t>(fans::node_numbers(damped_));
  const std::size_t all = static_cast<std::size_t>(free_nodes_) + places.size();
  states_.assign(width * all, Real(0));
  forces_.assign(fans::quad * all, Real(0));
  for (const auto& [bits, node] : places) {
    std::ranges::copy(std::bit_cast<Place>(bits), states_.begin() + static_cast<std::ptrdiff_t>(width) * node);
  }
  return nodes;
}

template <class Real>
void SpringFans<Real>::add_fan(int node, std::span<const Member> members) {
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  const auto numbers_of_group = lanes * static_cast<std::size_t>(fans::group_numbers(damped_));
  const int width = fans::node_numbers(damped_);
  fans::Fan fan{.node = width * node};
  for (; !members.empty(); ++fan.groups) {
    const std::size_t partner = partners_.size();
    const std::size_t number = numbers_.size();
    partners_.resize(partner + lanes, fan.node);
    numbers_.resize(number + numbers_of_group, Real(0));
    const std::size_t count = std::min(lanes, members.size());
    for (std::size_t n = 0; n < count; ++n) {
      partners_[partner + n] = width * members[n].partner;
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
void SpringFans<Real>::take(const SpringSet<Real>& springs, bool damped) {
  damped_ = damped;
  force_ = damped ? kernels_.damped : kernels_.undamped;
  measured_force_ = damped ? kernels_.damped_measured : kernels_.undamped_measured;
  const std::vector<int> anchored = place_nodes(springs);
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  std::vector<std::vector<Member>> must(static_cast<std::size_t>(free_nodes_));
  for (std::size_t n = 0; n < springs.anchors.size(); ++n) {
    const Anchor<Real>& s = springs.anchors[n];
    must[static_cast<std::size_t>(s.a / 3)].push_back(
        {anchored[n], s.stiffness, s.viscosity, s.rest_length});
  }
  std::vector<Link<Real>> links = springs.links;
  for (Link<Real>& s : links) {
    const auto [first, last] = std::minmax({s.a / 3, s.b / 3});
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
}

template std::vector<fans::Kernels<double>> fan_kernels<double>();
template std::vector<fans::Kernels<float>> fan_kernels<float>();
template class SpringFans<double>;
template class SpringFans<float>;

}  // namespace palpate

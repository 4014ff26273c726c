// SPDX-License-Identifier: MIT
#include "model/stepping/spring_fans.hpp"

#include <algorithm>

#include "model/stepping/instruction_set.hpp"

namespace palpate {

static_assert(fans::View<double>::zero_length == zero_length);

namespace {

/// The first of them, as long as they begin at that node.
template <class Spring>
std::span<const Spring> take_first(std::span<const Spring>& rest, int node) {
  const auto end = std::ranges::find_if(rest, [&](const Spring& s) { return s.a != node; });
  const auto count = static_cast<std::size_t>(end - rest.begin());
  const auto first = rest.first(count);
  rest = rest.subspan(count);
  return first;
}

}  // namespace

template <class Real>
std::vector<fans::Kernels<Real>> fan_kernels() {
  return kernels_here(&fans::avx512_kernels<Real>, &fans::avx2_kernels<Real>, &fans::baseline_kernels<Real>);
}

template <class Real>
void SpringFans<Real>::take_links(fans::Fan& fan, std::span<const Link<Real>> links) {
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  for (std::size_t begin = 0; begin < links.size(); begin += lanes, ++fan.links) {
    const std::size_t at = numbers_.size();
    numbers_.resize(at + fans::link_numbers * lanes, Real(0));
    partners_.resize(partners_.size() + lanes, fan.node);
    for (std::size_t n = 0; n < std::min(lanes, links.size() - begin); ++n) {
      const Link<Real>& s = links[begin + n];
      partners_[partners_.size() - lanes + n] = s.b;
      numbers_[at + n] = s.stiffness;
      numbers_[at + lanes + n] = s.viscosity;
      numbers_[at + 2 * lanes + n] = s.rest_length;
    }
  }
}

template <class Real>
void SpringFans<Real>::take_anchors(fans::Fan& fan, std::span<const Anchor<Real>> anchors) {
  const auto lanes = static_cast<std::size_t>(kernels_.lanes);
  for (std::size_t begin = 0; begin < anchors.size(); begin += lanes, ++fan.anchors) {
    const std::size_t at = numbers_.size();
    numbers_.resize(at + fans::anchor_numbers * lanes, Real(0));
    for (std::size_t n = 0; n < std::min(lanes, anchors.size() - begin); ++n) {
      const Anchor<Real>& s = anchors[begin + n];
      const Real numbers[] = {s.stiffness, s.viscosity, s.rest_length, s.place[0], s.place[1], s.place[2]};
      for (std::size_t m = 0; m < fans::anchor_numbers; ++m) { numbers_[at + m * lanes + n] = numbers[m]; }
    }
  }
}

template <class Real>
void SpringFans<Real>::take(const SpringSet<Real>& springs) {
  std::vector<Link<Real>> sorted = springs.links;
  std::ranges::stable_sort(sorted, {}, &Link<Real>::a);
  std::span<const Link<Real>> links = sorted;
  std::span<const Anchor<Real>> anchors = springs.anchors;
  while (!links.empty() || !anchors.empty()) {
    const int node = links.empty() || (!anchors.empty() && anchors.front().a < links.front().a)
                         ? anchors.front().a
                         : links.front().a;
    fans::Fan fan{.node = node};
    take_links(fan, take_first(links, node));
    take_anchors(fan, take_first(anchors, node));
    fans_.push_back(fan);
  }
}

template std::vector<fans::Kernels<double>> fan_kernels<double>();
template std::vector<fans::Kernels<float>> fan_kernels<float>();
template class SpringFans<double>;
template class SpringFans<float>;

}  // namespace palpate

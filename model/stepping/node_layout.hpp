// SPDX-License-Identifier: MIT
#pragma once
/// Where the coordinates of nodes stand in the vectors of the stepping. Kernels choose it; all else asks it.

#include <vector>

#include <Eigen/Core>

namespace palpate {

struct NodeLayout {
  Eigen::Index size = 0;              ///< of a vector of all coordinates, without that of a tool
  Eigen::Index stride = 1;            ///< from a node's x to its y, and from y to z
  std::vector<Eigen::Index> first{};  ///< of each node's x; -1 for a fixed node
};

/// The three coordinates of a node whose x stands at `first`.
template <class Real>
auto at_node(const Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, Eigen::Index first,
             Eigen::Index stride) noexcept {
  return Eigen::Map<const Eigen::Matrix<Real, 3, 1>, 0, Eigen::InnerStride<>>(
      all.data() + first, Eigen::InnerStride<>(stride));
}
template <class Real>
auto at_node(Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, Eigen::Index first,
             Eigen::Index stride) noexcept {
  return Eigen::Map<Eigen::Matrix<Real, 3, 1>, 0, Eigen::InnerStride<>>(all.data() + first,
                                                                        Eigen::InnerStride<>(stride));
}

/// Coordinates of the free nodes in their order, three each, as a Problem has them.
template <class Real>
void gather(const Eigen::Matrix<Real, Eigen::Dynamic, 1>& all, const NodeLayout& layout,
            Eigen::Ref<Eigen::VectorXd> packed) noexcept {
  Eigen::Index n = 0;
  for (const Eigen::Index first : layout.first) {
    if (first < 0) { continue; }
    packed.segment<3>(n) = at_node(all, first, layout.stride).template cast<double>();
    n += 3;
  }
}
/// And back; what belongs to no free node stays as it is.
template <class Real>
void scatter(const Eigen::VectorXd& packed, const NodeLayout& layout,
             Eigen::Matrix<Real, Eigen::Dynamic, 1>& all) noexcept {
  Eigen::Index n = 0;
  for (const Eigen::Index first : layout.first) {
    if (first < 0) { continue; }
    at_node(all, first, layout.stride) = packed.segment<3>(n).template cast<Real>();
    n += 3;
  }
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/kernels/dissection.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace palpate {

namespace {

class Dissection {
 public:
  template <class Real>
  Dissection(const Eigen::SparseMatrix<Real>& matrix, const NodeVectors& place)
      : place_(place), beside_(static_cast<std::size_t>(place.cols())), half_(beside_.size()) {
    const Eigen::Index rows = 3 * place.cols();
    for (Eigen::Index column = 0; column < rows; ++column) {
      for (typename Eigen::SparseMatrix<Real>::InnerIterator at(matrix, column); at; ++at) {
        if (at.row() >= rows) { continue; }
        const auto a = static_cast<int>(at.row() / 3);
        const auto b = static_cast<int>(column / 3);
        if (a == b) { continue; }
        beside_[static_cast<std::size_t>(a)].push_back(b);
        beside_[static_cast<std::size_t>(b)].push_back(a);
      }
    }
    for (std::vector<int>& nodes : beside_) {
      std::ranges::sort(nodes);
      nodes.erase(std::ranges::unique(nodes).begin(), nodes.end());
    }
    std::vector<int> all(beside_.size());
    std::iota(all.begin(), all.end(), 0);
    split(all);
  }

  [[nodiscard]] const std::vector<int>& order() const { return order_; }

 private:
  void split(const std::vector<int>& nodes) {
    constexpr std::size_t few = 20;
    const auto keep = [&](const std::vector<int>& part) {
      order_.insert(order_.end(), part.begin(), part.end());
    };
    if (nodes.size() <= few) { return keep(nodes); }
    const auto places = place_(Eigen::all, nodes);
    Eigen::Index axis = 0;
    (places.rowwise().maxCoeff() - places.rowwise().minCoeff()).maxCoeff(&axis);
    std::vector<double> along;
    for (const int node : nodes) { along.push_back(place_(axis, node)); }
    const auto middle = along.begin() + static_cast<std::ptrdiff_t>(along.size() / 2);
    std::ranges::nth_element(along, middle);
    for (const int node : nodes) {
      half_[static_cast<std::size_t>(node)] = place_(axis, node) < *middle ? 1 : 2;
    }
    std::vector<int> first, second, between;
    for (const int node : nodes) {
      const bool touches = std::ranges::any_of(
          beside_[static_cast<std::size_t>(node)],
          [&](int other) { return half_[static_cast<std::size_t>(other)] == 1; });
      (half_[static_cast<std::size_t>(node)] == 1 ? first
       : touches                                  ? between
                                                  : second)
          .push_back(node);
    }
    for (const int node : nodes) { half_[static_cast<std::size_t>(node)] = 0; }
    if (first.empty()) { return keep(nodes); }  // half of the nodes or more have one coordinate
    split(first);
    split(second);
    keep(between);
  }

  const NodeVectors& place_;
  std::vector<std::vector<int>> beside_;
  std::vector<unsigned char> half_;
  std::vector<int> order_{};
};

}  // namespace

template <class Real>
Eigen::PermutationMatrix<Eigen::Dynamic> nested_dissection(const Eigen::SparseMatrix<Real>& matrix,
                                                           const NodeVectors& place) {
  Eigen::PermutationMatrix<Eigen::Dynamic> order(matrix.rows());
  order.setIdentity();  // also of the further rows
  const Dissection dissection(matrix, place);
  int row = 0;
  for (const int node : dissection.order()) {
    for (int axis = 0; axis < 3; ++axis) { order.indices()(3 * node + axis) = row++; }
  }
  return order;
}

template Eigen::PermutationMatrix<Eigen::Dynamic> nested_dissection(
    const Eigen::SparseMatrix<double>&, const NodeVectors&);
template Eigen::PermutationMatrix<Eigen::Dynamic> nested_dissection(
    const Eigen::SparseMatrix<float>&, const NodeVectors&);

}  // namespace palpate

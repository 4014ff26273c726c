// SPDX-License-Identifier: MIT
#include "model/stepping/graded_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate {

namespace {

/// By how much a cell is longer than the one before, further away from the box.
constexpr double cell_growth = 1.5;
/// Cells beside the box keep their length, as many as leave no more coarse nodes than this; but so many at least.
constexpr std::size_t most_coarse_nodes = 1500;
constexpr int fewest_even_cells = 2;

/// Below this share of the largest one a pivot of the factor is rounding: its square is 1e-12 of a stiffness.
constexpr double least_pivot = 1e-6;

/// From `from` to `to`, which is in it; `even` cells keep their length.
void walk(int from, int to, int even, std::vector<int>& places) {
  const int way = to < from ? -1 : 1;
  double length = 1.0;
  int place = from;
  for (int n = 0; place != to; ++n) {
    if (n >= even) { length *= cell_growth; }
    const int left = std::abs(to - place);
    int step = static_cast<int>(length);
    if (left < 2 * step) { step = left < step + step / 2 + 1 ? left : left / 2; }
    place += way * step;
    places.push_back(place);
  }
}

std::vector<int> graded_axis(int nodes, int first, int last, int even) {
  std::vector<int> places;
  for (int n = first; n <= last; ++n) { places.push_back(n); }
  walk(first, 0, even, places);
  walk(last, nodes - 1, even, places);
  std::ranges::sort(places);
  return places;
}

std::array<std::vector<int>, 3> graded_axes(const LatticeShape& shape, const LatticeBox& box) {
  std::array<std::vector<int>, 3> axes;
  for (int even = *std::ranges::max_element(shape.nodes);; even = std::max(even / 2, fewest_even_cells)) {
    for (std::size_t n = 0; n < 3; ++n) { axes[n] = graded_axis(shape.nodes[n], box.first[n], box.last[n], even); }
    if (even <= fewest_even_cells || axes[0].size() * axes[1].size() * axes[2].size() <= most_coarse_nodes) { return axes; }
  }
}

}  // namespace

GradedLattice::GradedLattice(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box)
    : problem_(problem), shape_(shape), axes_(graded_axes(shape, box)) {
  for (std::size_t n = 0; n < 3; ++n) {
    int cell = 0;
    for (int place = 0; place < shape.nodes[n]; ++place) {
      while (cell + 2 < static_cast<int>(axes_[n].size()) && axes_[n][static_cast<std::size_t>(cell) + 1] <= place) {
        ++cell;
      }
      cell_of_[n].push_back(cell);
    }
  }
  for (const int l : axes_[2]) {
    for (const int j : axes_[1]) {
      for (const int i : axes_[0]) {
        const bool held = problem.coordinate(shape.index(i, j, l)) < 0;
        coordinate_.push_back(held ? -1 : dof_);
        if (!held) { dof_ += 3; }
      }
    }
  }
}

Eigen::Index GradedLattice::index(int i, int j, int l) const {
  return (l * static_cast<Eigen::Index>(axes_[1].size()) + j) * static_cast<Eigen::Index>(axes_[0].size()) + i;
}

auto GradedLattice::cell_from(const std::array<int, 3>& place) const -> Cell {
  Cell cell{};
  for (std::size_t n = 0; n < 3; ++n) { cell[n] = cell_of_[n][static_cast<std::size_t>(place[n])]; }
  return cell;
}

auto GradedLattice::place_in(int node, const Cell& cell) const -> Place {
  Place at;
  const std::array<int, 3> place = shape_.place(node);
  const bool held = problem_.coordinate(node) < 0;
  std::array<double, 3> share{};
  for (std::size_t n = 0; n < 3; ++n) {
    const auto begin = static_cast<std::size_t>(cell[n]);
    share[n] = static_cast<double>(place[n] - axes_[n][begin]) / (axes_[n][begin + 1] - axes_[n][begin]);
  }
  for (int corner = 0; corner < corners; ++corner) {
    const std::array<int, 3> up{corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = held ? 0.0 : 1.0;
    for (std::size_t n = 0; n < 3; ++n) { weight *= up[n] != 0 ? share[n] : 1.0 - share[n]; }
    const auto c = static_cast<std::size_t>(corner);
    at.coordinate[c] = coordinate_[static_cast<std::size_t>(index(cell[0] + up[0], cell[1] + up[1], cell[2] + up[2]))];
    at.weight[c] = weight;
  }
  return at;
}

auto GradedLattice::place_of(int node) const -> Place { return place_in(node, cell_from(shape_.place(node))); }

Eigen::Index GradedLattice::coordinate(int node) const {
  const Place at = place_of(node);
  const auto most = std::ranges::max_element(at.weight);
  return *most == 1.0 ? at.coordinate[static_cast<std::size_t>(most - at.weight.begin())] : -1;
}

/// Springs are shorter than cells: each lies in one.
auto GradedLattice::cells_with_springs() const -> std::vector<CellStiffness> {
  const SpringNetwork& network = problem_.network();
  const std::size_t along[2] = {axes_[0].size() - 1, axes_[1].size() - 1};
  std::vector<CellStiffness> cells(along[0] * along[1] * (axes_[2].size() - 1));
  for (const Spring& spring : network.springs) {
    if (network.is_fixed(spring.a) && network.is_fixed(spring.b)) { continue; }
    const std::array<int, 3> a = shape_.place(spring.a);
    const std::array<int, 3> b = shape_.place(spring.b);
    const Cell cell = cell_from({std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2])});
    const Place from = place_in(spring.a, cell);
    const Place to = place_in(spring.b, cell);
    const Eigen::Vector3d apart = network.rest_position.col(spring.b) - network.rest_position.col(spring.a);
    Eigen::Matrix<double, block, 1> grows;
    for (int corner = 0; corner < corners; ++corner) {
      const auto c = static_cast<std::size_t>(corner);
      grows.segment<3>(3 * corner) = (to.weight[c] - from.weight[c]) * apart.normalized();
    }
    const auto number = (static_cast<std::size_t>(cell[2]) * along[1] + static_cast<std::size_t>(cell[1])) * along[0] +
                        static_cast<std::size_t>(cell[0]);
    cells[number].coordinate = from.coordinate;
    cells[number].matrix.selfadjointView<Eigen::Lower>().rankUpdate(grows, spring.stiffness);
  }
  return cells;
}

/// The lower half.
Eigen::SparseMatrix<double> GradedLattice::stiffness() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const CellStiffness& cell : cells_with_springs()) {
    for (int column = 0; column < block; ++column) {
      const Eigen::Index c = cell.coordinate[static_cast<std::size_t>(column / 3)];
      for (int row = column; row < block; ++row) {
        const Eigen::Index r = cell.coordinate[static_cast<std::size_t>(row / 3)];
        if (r < 0 || c < 0 || cell.matrix(row, column) == 0.0) { continue; }
        const auto one = static_cast<int>(r + row % 3);
        const auto other = static_cast<int>(c + column % 3);
        entries.emplace_back(std::max(one, other), std::min(one, other), cell.matrix(row, column));
      }
    }
  }
  Eigen::SparseMatrix<double> k(dof_, dof_);
  k.setFromTriplets(entries.begin(), entries.end());
  return k;
}

Eigen::VectorXd GradedLattice::mass() const {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(dof_);
  for (const int node : problem_.free_nodes()) {
    const Place at = place_of(node);
    for (std::size_t c = 0; c < at.weight.size(); ++c) {
      if (at.coordinate[c] >= 0) {
        mass.segment<3>(at.coordinate[c]).array() += at.weight[c] * problem_.network().mass(node);
      }
    }
  }
  return mass;
}

GradedLattice::Statics::Statics(const GradedLattice& lattice) : factors_(lattice.stiffness()) {
  const auto is_held = [&] {
    const Eigen::SparseMatrix<double> factor = factors_.matrixL();
    const auto pivots = factor.diagonal();
    return pivots.minCoeff() > least_pivot * pivots.maxCoeff();
  };
  if (factors_.info() != Eigen::Success || !is_held()) {
    throw std::invalid_argument("nothing holds the tissue: its far field has no response at rest");
  }
}

}  // namespace palpate

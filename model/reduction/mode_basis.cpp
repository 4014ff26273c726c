// SPDX-License-Identifier: MIT

#include "model/reduction/mode_basis.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "model/kernels/dissection.hpp"
#include "model/problem/cell_law.hpp"

namespace palpate {

namespace {

/// Returns true if a node begins displaced or in motion, by more than a denormal number.
bool begins_moved(const SpringNetwork& network, int node) {
  const auto moved = [&](const NodeVectors& begin) {
    return begin.cols() > 0 &&
           begin.col(node).lpNorm<Eigen::Infinity>() >= std::numeric_limits<double>::min();
  };
  return moved(network.initial_displacement) || moved(network.initial_velocity);
}

/// Returns the depth on its line that the tip never passes [m]; infinite if the drive sets no end,
/// or if something could lift the tissue towards the tip.
double reach_of(const Scene& scene, const SpringNetwork& network) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  const Drive drive = scene.drive.value_or(Drive{});
  if (drive.kind != Drive::Kind::trajectory || !drive.depth || !scene.loads.empty()) {
    return unknown;
  }
  for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
    if (begins_moved(network, node)) { return unknown; }
  }
  return std::max(drive.from, *drive.depth);
}

/// Returns the supports of a sliding face at places along its path, a spacing apart or closer.
std::vector<std::vector<NeedlePath::Support>> places_of_face(
    const std::vector<Eigen::Vector3d>& path, const ProbeFace& face) {
  std::vector<std::vector<NeedlePath::Support>> places;
  std::vector<double> share(face.node.size());
  for (std::size_t n = 0; n + 1 < path.size(); ++n) {
    const Eigen::Vector2d from = path[n].tail<2>();
    const Eigen::Vector2d way = path[n + 1].tail<2>() - from;
    const double pieces = std::max(1.0, std::ceil(way.norm() / face.spacing.minCoeff()));
    for (double piece = 0.0; piece <= pieces; ++piece) {
      face.press(from + piece / pieces * way, share);
      std::vector<NeedlePath::Support>& on = places.emplace_back();
      for (std::size_t column = 0; column < share.size(); ++column) {
        if (share[column] != 0.0 && face.node[column] >= 0) {
          on.push_back({.node = face.node[column], .weight = share[column]});
        }
      }
    }
  }
  return places;
}

}  // namespace

std::vector<LoadCase> load_cases_of(const Scene& scene, const NetworkProblem& problem) {
  std::vector<LoadCase> load_cases;
  const auto add = [&](std::vector<NeedlePath::Support> on, const Eigen::Vector3d& direction) {
    std::erase_if(on, [&](const auto& support) { return problem.coordinate(support.node) < 0; });
    if (!on.empty()) { load_cases.push_back({.on = std::move(on), .direction = direction}); }
  };
  if (scene.needle || scene.probe) {
    const NeedlePath path(scene, problem.network());
    std::span<const NeedlePath::Knot> knots = path.knots();
    if (path.sliding_face()) {
      knots = {};
      for (auto& on : places_of_face(*scene.probe->path, *path.sliding_face())) {
        add(std::move(on), path.direction());
      }
    }
    const auto beyond = std::ranges::lower_bound(knots, reach_of(scene, problem.network()), {},
                                                 &NeedlePath::Knot::depth);
    // A tip between two contact points loads both. One more is for tissue that springs back.
    const auto reached = static_cast<std::size_t>(beyond - knots.begin()) + 2;
    for (const NeedlePath::Knot& knot : knots.first(std::min(reached, knots.size()))) {
      const auto supports = path.supports(knot);
      for (int axis = 0; axis < 3; ++axis) {
        add({supports.begin(), supports.end()}, Eigen::Vector3d::Unit(axis));
      }
    }
  }
  for (const Load& load : problem.loads()) {
    if (load.force.isZero(0.0)) { continue; }
    std::vector<NeedlePath::Support> on;
    for (const int node : load.nodes) { on.push_back({.node = node, .weight = 1.0}); }
    add(std::move(on), load.force.normalized());
  }
  return load_cases;
}

std::vector<int> nodes_of_tool(const Scene& scene, const SpringNetwork& network) {
  std::vector<int> nodes;
  if (!scene.needle && !scene.probe) { return nodes; }
  const NeedlePath path(scene, network);
  for (const NeedlePath::Knot& knot : path.knots()) {
    for (const NeedlePath::Support& support : path.supports(knot)) {
      nodes.push_back(support.node);
    }
  }
  return nodes;
}

namespace {

using Place = std::array<int, 3>;

/// Adds the nodes of a ball; `radius` is in spacings.
void add_ball(const LatticeShape& shape, const Place& middle, double radius, NearNodes& nodes) {
  const double most = radius * radius * (1.0 + 1e-9);
  Place first{};
  Place last{};
  for (std::size_t n = 0; n < 3; ++n) {
    const int cells =
        static_cast<int>(std::min(std::sqrt(most), static_cast<double>(shape.nodes[n])));
    first[n] = std::max(0, middle[n] - cells);
    last[n] = std::min(shape.nodes[n] - 1, middle[n] + cells);
    nodes.box.first[n] = std::min(nodes.box.first[n], first[n]);
    nodes.box.last[n] = std::max(nodes.box.last[n], last[n]);
  }
  const auto square = [](int from, int to) { return static_cast<double>(to - from) * (to - from); };
  for (int l = first[2]; l <= last[2]; ++l) {
    for (int j = first[1]; j <= last[1]; ++j) {
      const double beside = square(l, middle[2]) + square(j, middle[1]);
      for (int i = first[0]; i <= last[0]; ++i) {
        if (beside + square(i, middle[0]) <= most) {
          nodes.near[static_cast<std::size_t>(shape.index(i, j, l))] = 1;
        }
      }
    }
  }
}

/// Returns the nodes within `radius` [m] of the loaded nodes.
NearNodes nodes_about(const std::vector<LoadCase>& load_cases, const SpringNetwork& network,
                      double radius) {
  NearNodes nodes{.near =
                      std::vector<unsigned char>(static_cast<std::size_t>(network.node_count()))};
  std::set<int> pushed;
  for (const LoadCase& push : load_cases) {
    for (const NeedlePath::Support& support : push.on) { pushed.insert(support.node); }
  }
  if (const std::optional<LatticeShape>& shape = network.springs.lattice()) {
    nodes.box = {.first = shape->nodes, .last = {0, 0, 0}};
    for (const int node : pushed) {
      add_ball(*shape, shape->place(node), radius / shape->spacing, nodes);
    }
    return nodes;
  }
  const double most = radius * radius * (1.0 + 1e-9);
  for (const int node : pushed) {
    const auto apart = network.rest_position.colwise() - network.rest_position.col(node);
    for (Eigen::Index other = 0; other < network.node_count(); ++other) {
      if (apart.col(other).squaredNorm() <= most) {
        nodes.near[static_cast<std::size_t>(other)] = 1;
      }
    }
  }
  return nodes;
}

/// Returns true if a spring has another length at rest than its natural one.
bool is_stretched_at_rest(const SpringNetwork& network) {
  return std::ranges::any_of(network.springs, [&](const Spring& s) {
    const double length = (network.rest_position.col(s.b) - network.rest_position.col(s.a)).norm();
    return std::abs(length - s.rest_length) > 1e-9 * s.rest_length;
  });
}

/// Returns the reason why the tissue cannot be reduced, or null.
const char* obstacle_to_far_field(const Scene& scene, const NetworkProblem& problem) {
  const SpringNetwork& network = problem.network();
  if (problem.dof() == 3 * network.node_count()) {
    return "nothing is fixed that what lies further away could rest on";
  }
  if (relaxes(network)) { return "its springs relax"; }
  if (!scene.tissue.gravity.isZero()) { return "gravity pulls at what lies further away"; }
  if (scene.simulation.printed.any()) { return "the printed equations are not linear about rest"; }
  if (network.springs.lattice()) { return nullptr; }
  if (problem.free_nodes().size() > most_factorised_nodes) {
    return "it is not a regular lattice and has more than 5000 free nodes";
  }
  if (is_stretched_at_rest(network)) { return "its springs are not at their natural length"; }
  return nullptr;
}

}  // namespace

NearChoice choose_near_nodes(const Scene& scene, const NetworkProblem& problem, double radius) {
  if (const char* obstacle = obstacle_to_far_field(scene, problem)) {
    return {.obstacle = obstacle};
  }
  const std::vector<LoadCase> load_cases = load_cases_of(scene, problem);
  if (load_cases.empty()) {
    return {.obstacle = "neither tool nor load pushes a free node that the rest would be far from"};
  }
  NearNodes nodes = nodes_about(load_cases, problem.network(), radius);
  const auto is_far = [&](int node) { return !nodes.holds(node); };
  const auto far = std::ranges::count_if(problem.free_nodes(), is_far);
  if (far == 0) { return {.obstacle = "no free node lies further away"}; }
  const SpringNetwork& network = problem.network();
  for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
    if ((network.is_fixed(node) || is_far(node)) && begins_moved(network, node)) {
      return {.obstacle = "what lies further away, or is fixed, does not begin at rest"};
    }
  }
  return {.nodes = std::move(nodes), .far_nodes = far};
}

FarNodes far_nodes(const NetworkProblem& problem, const NearNodes& near) {
  FarNodes far(static_cast<std::size_t>(problem.network().node_count()), 0);
  for (const int node : problem.free_nodes()) {
    far[static_cast<std::size_t>(node)] = near.holds(node) ? 0 : 1;
  }
  return far;
}

std::array<Eigen::Vector3d, 8> volume_gradient(const SpringNetwork& network,
                                               const VolumeCell& cell) {
  Corners<double> x;
  for (std::size_t n = 0; n < 8; ++n) {
    const Eigen::Vector3d place = network.rest_position.col(cell.nodes[n]);
    x[n] = {place.x(), place.y(), place.z()};
  }
  Corners<double> sum{};
  for (std::size_t n = 0; n < 8; ++n) {
    add_gradient(edges_at(x, n), n, 1.0 / (8.0 * cell.volume), sum);
  }
  std::array<Eigen::Vector3d, 8> gradient;
  std::ranges::transform(sum, gradient.begin(),
                         [](const Vector3Of<double>& g) { return Eigen::Vector3d(g.x, g.y, g.z); });
  return gradient;
}

namespace {

/// Ratio of the lengths of consecutive cells, away from the box.
constexpr double cell_growth = 1.5;
/// Limit on the coarse nodes, which determines how many cells next to the box keep their length,
/// and the minimum number of such cells.
constexpr std::size_t most_coarse_nodes = 1500;
constexpr int fewest_even_cells = 2;
/// Limit beyond which cells inside the box are longer than the spacing, along the axis with the
/// most nodes first: the factorisation takes seconds.
constexpr std::size_t most_nodes_of_fine_box = 6000;

/// Smallest pivot of the factor relative to the largest. A smaller pivot is rounding error: its
/// square is 1e-12 of a stiffness.
constexpr double least_pivot = 1e-6;

/// Adds the positions from `from` to `to`, inclusive; `even` cells have the length `length`.
void walk(int from, int to, int even, double length, std::vector<int>& places) {
  const int way = to < from ? -1 : 1;
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

/// Returns the positions of the coarse nodes: inside the box every `length`-th, and its ends.
std::vector<int> graded_axis(int nodes, int first, int last, int even, int length) {
  std::vector<int> places;
  for (int n = first; n < last; n += length) { places.push_back(n); }
  places.push_back(last);
  walk(first, 0, even, length, places);
  walk(last, nodes - 1, even, length, places);
  std::ranges::sort(places);
  return places;
}

std::array<std::vector<int>, 3> graded_axes(const LatticeShape& shape, const LatticeBox& box) {
  std::array<std::vector<int>, 3> axes;
  std::array<int, 3> length{1, 1, 1};
  const auto nodes_with = [&](int even) {
    for (std::size_t n = 0; n < 3; ++n) {
      axes[n] = graded_axis(shape.nodes[n], box.first[n], box.last[n], even, length[n]);
    }
    return axes[0].size() * axes[1].size() * axes[2].size();
  };
  int even = *std::ranges::max_element(shape.nodes);
  while (nodes_with(even) > most_coarse_nodes && even > fewest_even_cells) {
    even = std::max(even / 2, fewest_even_cells);
  }
  while (nodes_with(even) > most_nodes_of_fine_box) {
    const auto longest = std::ranges::max_element(axes, {}, &std::vector<int>::size);
    ++length[static_cast<std::size_t>(longest - axes.begin())];
  }
  return axes;
}

}  // namespace

GradedLattice::GradedLattice(const NetworkProblem& problem, const LatticeShape& shape,
                             const LatticeBox& box)
    : PointModel(problem), shape_(shape), axes_(graded_axes(shape, box)) {
  for (std::size_t n = 0; n < 3; ++n) {
    int cell = 0;
    for (int place = 0; place < shape.nodes[n]; ++place) {
      while (cell + 2 < static_cast<int>(axes_[n].size()) &&
             axes_[n][static_cast<std::size_t>(cell) + 1] <= place) {
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

NodeVectors GradedLattice::places() const {
  NodeVectors places(3, dof_ / 3);
  for (std::size_t n = 0; n < coordinate_.size(); ++n) {
    if (coordinate_[n] < 0) { continue; }
    const std::size_t x = axes_[0].size();
    const std::size_t y = axes_[1].size();
    places.col(coordinate_[n] / 3) =
        Eigen::Vector3i(axes_[0][n % x], axes_[1][n / x % y], axes_[2][n / (x * y)]).cast<double>();
  }
  return places;
}

Eigen::Index GradedLattice::index(int i, int j, int l) const {
  return (l * static_cast<Eigen::Index>(axes_[1].size()) + j) *
             static_cast<Eigen::Index>(axes_[0].size()) +
         i;
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
    share[n] =
        static_cast<double>(place[n] - axes_[n][begin]) / (axes_[n][begin + 1] - axes_[n][begin]);
  }
  for (int corner = 0; corner < corners; ++corner) {
    const std::array<int, 3> up{corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = held ? 0.0 : 1.0;
    for (std::size_t n = 0; n < 3; ++n) { weight *= up[n] != 0 ? share[n] : 1.0 - share[n]; }
    const auto c = static_cast<std::size_t>(corner);
    at.coordinate[c] = coordinate_[static_cast<std::size_t>(
        index(cell[0] + up[0], cell[1] + up[1], cell[2] + up[2]))];
    at.weight[c] = weight;
  }
  return at;
}

auto GradedLattice::place_of(int node) const -> Place {
  return place_in(node, cell_from(shape_.place(node)));
}

std::size_t GradedLattice::number_of(const Cell& cell) const {
  const auto at = [&](std::size_t n) { return static_cast<std::size_t>(cell[n]); };
  return (at(2) * (axes_[1].size() - 1) + at(1)) * (axes_[0].size() - 1) + at(0);
}

namespace {

bool is_part_of_far(const SpringNetwork& network, const FarNodes& far, std::span<const int> nodes) {
  const auto is_far = [&](int node) { return far[static_cast<std::size_t>(node)] != 0; };
  return std::ranges::any_of(nodes, is_far) && std::ranges::all_of(nodes, [&](int node) {
           return is_far(node) || network.is_fixed(node);
         });
}

/// Returns the factor of g g^T in the sum of a spring, g being its growth.
double factor_of(const Spring& spring, Constant which) {
  return which == Constant::stiffness ? spring.stiffness : spring.viscosity;
}
/// The same of a cell, g being the growth of its relative volume; 0 if it does not resist that.
double factor_of(const VolumeCell& cell, Constant which) {
  if (cell.stiffness == 0.0) { return 0.0; }
  return cell.volume * (which == Constant::stiffness ? cell.stiffness : cell.viscosity);
}
std::array<int, 2> nodes_of(const Spring& spring) { return {spring.a, spring.b}; }
const std::array<int, 8>& nodes_of(const VolumeCell& cell) { return cell.nodes; }

/// Returns factor_of() for springs and cells in the far part; 0 outside of it.
auto factor_in_far(const SpringNetwork& network, const FarNodes& far, Constant which) {
  return [&network, &far, which](const auto& part) {
    const double factor = factor_of(part, which);
    return factor != 0.0 && is_part_of_far(network, far, nodes_of(part)) ? factor : 0.0;
  };
}

}  // namespace

auto GradedLattice::zero_cells() const -> std::vector<CellMatrix> {
  return std::vector<CellMatrix>((axes_[0].size() - 1) * (axes_[1].size() - 1) *
                                 (axes_[2].size() - 1));
}

auto GradedLattice::growth_of(const VolumeCell& fine, const Cell& cell) const -> Growth {
  const std::array<Eigen::Vector3d, 8> gradient = volume_gradient(problem_.network(), fine);
  Growth growth = Growth::Zero();
  for (std::size_t n = 0; n < 8; ++n) {
    const Place at = place_in(fine.nodes[n], cell);
    for (int corner = 0; corner < corners; ++corner) {
      growth.segment<3>(3 * corner) += at.weight[static_cast<std::size_t>(corner)] * gradient[n];
    }
  }
  return growth;
}

// Springs are not longer than the coarse cells, so each is inside one.
template <class Factor>
auto GradedLattice::of_springs(Factor factor) const -> std::vector<CellMatrix> {
  const SpringNetwork& network = problem_.network();
  std::vector<CellMatrix> cells = zero_cells();
  for (const Spring& spring : network.springs) {
    const double k = factor(spring);
    if (k == 0.0) { continue; }
    const std::array<int, 3> a = shape_.place(spring.a);
    const std::array<int, 3> b = shape_.place(spring.b);
    const Cell cell = cell_from({std::min(a[0], b[0]), std::min(a[1], b[1]), std::min(a[2], b[2])});
    const Place from = place_in(spring.a, cell);
    const Place to = place_in(spring.b, cell);
    const Eigen::Vector3d apart =
        network.rest_position.col(spring.b) - network.rest_position.col(spring.a);
    Growth grows;
    for (int corner = 0; corner < corners; ++corner) {
      const auto c = static_cast<std::size_t>(corner);
      grows.segment<3>(3 * corner) = (to.weight[c] - from.weight[c]) * apart.normalized();
    }
    CellMatrix& into = cells[number_of(cell)];
    into.coordinate = from.coordinate;
    into.matrix.selfadjointView<Eigen::Lower>().rankUpdate(grows, k);
  }
  return cells;
}

void GradedLattice::add_mean_volumes(std::vector<CellMatrix>& cells) const {
  const SpringNetwork& network = problem_.network();
  struct Sum {
    Growth growth = Growth::Zero();  ///< [m^2]
    double volume = 0.0;             ///< [m^3]
    double modulus = 0.0;            ///< times the volume [N m]
  };
  std::map<std::size_t, Sum> sums;
  for (const VolumeCell& fine : network.cells) {
    const auto fixed = [&](int node) { return network.is_fixed(node); };
    if (fine.stiffness == 0.0 || std::ranges::all_of(fine.nodes, fixed)) { continue; }
    const Cell cell = cell_from(shape_.place(*std::ranges::min_element(fine.nodes)));
    const std::size_t number = number_of(cell);
    Sum& sum = sums[number];
    sum.growth += fine.volume * growth_of(fine, cell);
    cells[number].coordinate = place_in(fine.nodes[0], cell).coordinate;
    sum.volume += fine.volume;
    sum.modulus += fine.stiffness * fine.volume;
  }
  for (const auto& [number, sum] : sums) {
    cells[number].matrix.selfadjointView<Eigen::Lower>().rankUpdate(
        sum.growth, sum.modulus / (sum.volume * sum.volume));
  }
}

Eigen::SparseMatrix<double> GradedLattice::assembled(const std::vector<CellMatrix>& cells) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const CellMatrix& cell : cells) {
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
  Eigen::SparseMatrix<double> sum(dof_, dof_);
  sum.setFromTriplets(entries.begin(), entries.end());
  return sum;
}

Eigen::SparseMatrix<double> GradedLattice::stiffness() const {
  const SpringNetwork& network = problem_.network();
  std::vector<CellMatrix> cells = of_springs([&](const Spring& spring) {
    return network.is_fixed(spring.a) && network.is_fixed(spring.b) ? 0.0 : spring.stiffness;
  });
  add_mean_volumes(cells);
  return assembled(cells);
}

Eigen::SparseMatrix<double> GradedLattice::far_part(const FarNodes& far, Constant which) const {
  const SpringNetwork& network = problem_.network();
  const auto factor = factor_in_far(network, far, which);
  std::vector<CellMatrix> cells = of_springs(factor);
  for (const VolumeCell& fine : network.cells) {
    const double k = factor(fine);
    if (k == 0.0) { continue; }
    const Cell cell = cell_from(shape_.place(*std::ranges::min_element(fine.nodes)));
    CellMatrix& into = cells[number_of(cell)];
    into.coordinate = place_in(fine.nodes[0], cell).coordinate;
    into.matrix.selfadjointView<Eigen::Lower>().rankUpdate(growth_of(fine, cell), k);
  }
  return assembled(cells);
}

Eigen::SparseMatrix<double> GradedLattice::far_mass(const FarNodes& far) const {
  std::vector<CellMatrix> cells = zero_cells();
  for (const int node : problem_.free_nodes()) {
    if (far[static_cast<std::size_t>(node)] == 0) { continue; }
    const Cell cell = cell_from(shape_.place(node));
    const Place at = place_in(node, cell);
    CellMatrix& into = cells[number_of(cell)];
    into.coordinate = at.coordinate;
    for (int row = 0; row < block; ++row) {
      for (int column = row % 3; column <= row; column += 3) {
        into.matrix(row, column) += problem_.network().mass(node) *
                                    at.weight[static_cast<std::size_t>(row / 3)] *
                                    at.weight[static_cast<std::size_t>(column / 3)];
      }
    }
  }
  return assembled(cells);
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

namespace {

/// Adds k g g^T over the free nodes of a part, g being its gradient at each.
template <std::size_t count>
void add_part(const NetworkProblem& problem, double k, const std::array<int, count>& nodes,
              const std::array<Eigen::Vector3d, count>& gradient,
              std::vector<Eigen::Triplet<double>>& entries) {
  for (std::size_t row = 0; row < 3 * count; ++row) {
    for (std::size_t column = 0; column < 3 * count; ++column) {
      const Eigen::Index r = problem.coordinate(nodes[row / 3]);
      const Eigen::Index c = problem.coordinate(nodes[column / 3]);
      const auto at_row = static_cast<Eigen::Index>(row % 3);
      const auto at_column = static_cast<Eigen::Index>(column % 3);
      if (r < 0 || c < 0 || r + at_row < c + at_column) { continue; }
      entries.emplace_back(static_cast<int>(r + at_row), static_cast<int>(c + at_column),
                           k * gradient[row / 3](at_row) * gradient[column / 3](at_column));
    }
  }
}

}  // namespace

/// Returns the sum of factor(part) g g^T over springs and cells that resist changes of volume.
template <class Factor> Eigen::SparseMatrix<double> EveryNode::sum_of(Factor factor) const {
  const SpringNetwork& network = problem_.network();
  std::vector<Eigen::Triplet<double>> entries;
  for (const Spring& s : network.springs) {
    const double k = factor(s);
    if (k == 0.0) { continue; }
    const Eigen::Vector3d u =
        (network.rest_position.col(s.b) - network.rest_position.col(s.a)).normalized();
    add_part<2>(problem_, k, {s.a, s.b}, {-u, u}, entries);
  }
  for (const VolumeCell& cell : network.cells) {
    const double k = factor(cell);
    if (k == 0.0) { continue; }
    add_part<8>(problem_, k, cell.nodes, volume_gradient(network, cell), entries);
  }
  Eigen::SparseMatrix<double> sum(dof(), dof());
  sum.setFromTriplets(entries.begin(), entries.end());
  return sum;
}

Eigen::SparseMatrix<double> EveryNode::stiffness() const {
  return sum_of([](const auto& part) { return factor_of(part, Constant::stiffness); });
}

Eigen::SparseMatrix<double> EveryNode::far_part(const FarNodes& far, Constant which) const {
  return sum_of(factor_in_far(problem_.network(), far, which));
}

Eigen::SparseMatrix<double> EveryNode::far_mass(const FarNodes& far) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const int node : problem_.free_nodes()) {
    if (far[static_cast<std::size_t>(node)] == 0) { continue; }
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<int>(problem_.coordinate(node)) + axis;
      entries.emplace_back(at, at, problem_.network().mass(node));
    }
  }
  Eigen::SparseMatrix<double> sum(dof(), dof());
  sum.setFromTriplets(entries.begin(), entries.end());
  return sum;
}

NodeVectors EveryNode::places() const {
  NodeVectors places(3, static_cast<Eigen::Index>(problem_.free_nodes().size()));
  for (const int node : problem_.free_nodes()) {
    places.col(problem_.coordinate(node) / 3) = problem_.network().rest_position.col(node);
  }
  return places;
}

StaticSolver::StaticSolver(const Eigen::SparseMatrix<double>& stiffness, const NodeVectors& place)
    : order_(nested_dissection(stiffness, place)) {
  Eigen::SparseMatrix<double> ordered;
  ordered.selfadjointView<Eigen::Lower>() =
      stiffness.selfadjointView<Eigen::Lower>().twistedBy(order_);
  factors_.compute(ordered);
  if (factors_.info() != Eigen::Success) { return; }
  const Eigen::SparseMatrix<double> factor = factors_.matrixL();
  const auto pivots = factor.diagonal();
  held_ = pivots.minCoeff() > least_pivot * pivots.maxCoeff();
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Returns the loads on the coordinates of a model [N], one column each.
MatrixXd loads_of(const std::vector<LoadCase>& load_cases, const PointModel& model) {
  MatrixXd loads = MatrixXd::Zero(model.dof(), static_cast<Index>(load_cases.size()));
  for (std::size_t n = 0; n < load_cases.size(); ++n) {
    for (const NeedlePath::Support& support : load_cases[n].on) {
      const auto place = model.place_of(support.node);
      for (std::size_t c = 0; c < place.weight.size(); ++c) {
        if (place.coordinate[c] < 0) { continue; }
        loads.col(static_cast<Index>(n)).segment<3>(place.coordinate[c]) +=
            place.weight[c] * support.weight * load_cases[n].direction;
      }
    }
  }
  return loads;
}

MatrixXd random_matrix(Index rows, Index columns) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Extends `basis` by the part of `more` that is linearly independent of it, orthogonal with
/// respect to mass, up to `most` columns. Returns the added columns.
MatrixXd add_orthogonal(const VectorXd& mass, MatrixXd more, Index most, MatrixXd& basis) {
  const Index before = basis.cols();
  for (Index n = 0; n < more.cols() && basis.cols() < most; ++n) {
    VectorXd column = more.col(n);
    const double size = std::sqrt(column.dot(mass.cwiseProduct(column)));
    if (!(size > 0.0)) { continue; }
    column /= size;
    for (int twice = 0; twice < 2; ++twice) {
      column -= (basis * (basis.transpose() * mass.cwiseProduct(column))).eval();
    }
    const double left = std::sqrt(column.dot(mass.cwiseProduct(column)));
    if (left < 1e-6) { continue; }
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols<1>() = column / left;
  }
  return basis.rightCols(basis.cols() - before);
}

/// Returns the coordinates of the points that are near nodes.
std::vector<Index> near_coordinates(const NetworkProblem& problem, const NearNodes& near,
                                    const PointModel& model) {
  std::vector<Index> coordinates;
  for (const int node : problem.free_nodes()) {
    if (!near.holds(node)) { continue; }
    const auto place = model.place_of(node);
    for (std::size_t c = 0; c < place.weight.size(); ++c) {
      if (place.coordinate[c] < 0 || place.weight[c] != 1.0) { continue; }
      for (Index axis = 0; axis < 3; ++axis) { coordinates.push_back(place.coordinate[c] + axis); }
    }
  }
  return coordinates;
}

/// Returns the static responses to the loads with all other coordinates at rest, in the order of
/// `free`.
MatrixXd respond_alone(const Eigen::SparseMatrix<double>& stiffness, const std::vector<Index>& free,
                       const MatrixXd& loads) {
  std::vector<int> place(static_cast<std::size_t>(stiffness.rows()), -1);
  for (std::size_t n = 0; n < free.size(); ++n) {
    place[static_cast<std::size_t>(free[n])] = static_cast<int>(n);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (Index column = 0; column < stiffness.outerSize(); ++column) {
    for (Eigen::SparseMatrix<double>::InnerIterator at(stiffness, column); at; ++at) {
      const int r = place[static_cast<std::size_t>(at.row())];
      const int c = place[static_cast<std::size_t>(column)];
      if (r >= 0 && c >= 0) { entries.emplace_back(std::max(r, c), std::min(r, c), at.value()); }
    }
  }
  const auto size = static_cast<Index>(free.size());
  Eigen::SparseMatrix<double> part(size, size);
  part.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(part).solve(loads(free, Eigen::all));
}

/// Returns the combinations of static responses to the load cases that leave the least of their
/// compliance out. `near` are coordinates of near points.
MatrixXd best_responses(const Eigen::SparseMatrix<double>& stiffness, const StaticSolver& statics,
                        const std::vector<Index>& near, const MatrixXd& loads, Index most) {
  const MatrixXd moved = statics.respond(loads);
  MatrixXd compliance = loads.transpose() * moved;
  const VectorXd scale = compliance.diagonal().unaryExpr(
      [](double each) { return each > 0.0 ? 1.0 / std::sqrt(each) : 0.0; });
  if (!near.empty()) {
    compliance -= loads(near, Eigen::all).transpose() * respond_alone(stiffness, near, loads);
  }
  compliance = (scale.asDiagonal() * compliance * scale.asDiagonal()).eval();
  if (!compliance.allFinite()) { return moved.leftCols(most); }  // the solver would not end
  const Eigen::SelfAdjointEigenSolver<MatrixXd> shares(compliance);
  return moved * (scale.asDiagonal() * shares.eigenvectors().rightCols(most));
}

/// Returns the static responses to the load cases, or the best combinations of them if they are
/// more than the modes. If they are fewer, the responses to the inertia of these follow, and so on.
MatrixXd responses(const NetworkProblem& problem, const ReductionSetting& setting,
                   const PointModel& model) {
  const Eigen::SparseMatrix<double> stiffness = model.stiffness();
  const StaticSolver statics(stiffness, model.places());
  if (!statics.held()) {
    throw std::invalid_argument("nothing holds the tissue: its far field has no response at rest");
  }
  const Index most = setting.modes;
  MatrixXd loads = loads_of(setting.load_cases, model);
  if (loads.cols() > most) {
    return best_responses(stiffness, statics, near_coordinates(problem, setting.near, model), loads,
                          most);
  }
  const VectorXd mass = model.mass();
  MatrixXd basis(model.dof(), 0);
  while (loads.cols() > 0 && basis.cols() < most) {
    const Index left = most - basis.cols();
    if (left < loads.cols()) { loads = (loads * random_matrix(loads.cols(), left)).eval(); }
    loads = mass.asDiagonal() * add_orthogonal(mass, statics.respond(loads), most, basis);
  }
  return basis;
}

/// Relative eigenvalue of a Gram matrix below which a direction is rounding error and is dropped.
constexpr double least_share = 1e-11;

/// Returns columns c with c^T a c = 1 that are orthogonal with respect to a.
MatrixXd independent(const MatrixXd& a) {
  if (!a.allFinite()) { return MatrixXd(a.rows(), 0); }  // the solver would not end
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(a);
  const double least = least_share * modes.eigenvalues().maxCoeff();
  const Index left_out = (modes.eigenvalues().array() <= least).count();
  const Index kept = a.rows() - left_out;
  return modes.eigenvectors().rightCols(kept) *
         modes.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

std::unique_ptr<const PointModel> point_model(const NetworkProblem& problem,
                                              const LatticeBox& box) {
  if (problem.free_nodes().size() <= most_factorised_nodes) {
    return std::make_unique<EveryNode>(problem);
  }
  return std::make_unique<GradedLattice>(problem, problem.network().springs.lattice().value(), box);
}

}  // namespace

Eigen::Matrix<double, Eigen::Dynamic, 3> ModeBasis::of(int node) const {
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  return points->interpolate(node, Columns(Columns::Zero(modes(), 3)),
                             [&](Index first) { return phi.middleCols<3>(first); });
}

ModeBasis mode_basis(const NetworkProblem& problem, const ReductionSetting& setting) {
  ModeBasis shapes{.points = point_model(problem, setting.near.box),
                   .far = far_nodes(problem, setting.near)};
  const PointModel& points = *shapes.points;
  MatrixXd& phi = shapes.phi;
  phi = responses(problem, setting, points).transpose();
  const auto gram = [&](const Eigen::SparseMatrix<double>& a) {
    return MatrixXd(phi * (a.selfadjointView<Eigen::Lower>() * phi.transpose()));
  };
  // Responses to different loads differ by orders of magnitude.
  MatrixXd mass = gram(points.far_mass(shapes.far));
  const VectorXd size = mass.diagonal().unaryExpr(
      [](double square) { return square > 0.0 ? 1.0 / std::sqrt(square) : 1.0; });
  mass = (size.asDiagonal() * mass * size.asDiagonal()).eval();
  double sum = 0.0;
  for (const int node : problem.free_nodes()) {
    if (shapes.holds(node)) { sum += problem.network().mass(node); }
  }
  shapes.mass = sum / static_cast<double>(std::ranges::count(shapes.far, 1));
  phi = (std::sqrt(shapes.mass) * independent(mass).transpose() * size.asDiagonal() * phi).eval();
  if (shapes.modes() == 0) { return shapes; }  // the loads do not displace the far tissue
  GramSum mixed(shapes.modes());
  visit_mixed_parts(problem.network(), shapes,
                    [&](const MixedPart& part) { mixed.add(part.grows, part.stiffness); });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> own(
      gram(points.far_part(shapes.far, Constant::stiffness)) + mixed.take());
  phi = (own.eigenvectors().transpose() * phi).eval();
  shapes.stiffness = own.eigenvalues();
  shapes.damping = gram(points.far_part(shapes.far, Constant::viscosity));
  return shapes;
}

}  // namespace palpate

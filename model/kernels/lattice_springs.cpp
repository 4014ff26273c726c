// SPDX-License-Identifier: MIT

#include "model/kernels/lattice_springs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include "model/kernels/instruction_set.hpp"
#include "model/problem/spring_law.hpp"

namespace palpate {

namespace {

int whole(int nodes, int share) { return (nodes + share - 1) / share; }

/// Minimum gain of interleaved rows. Such a layer moves only after all its rows are computed, which
/// costs time.
constexpr double worth_folding = 1.1;

/// Returns the order of the axes; the two others keep their order.
std::array<std::size_t, 3> axes_from(std::size_t along) {
  return {along, along == 0 ? 1U : 0U, along == 2 ? 1U : 2U};
}

/// Returns the number of elements of a layer's rows per node.
double elements_per_node(int nodes0, int nodes1, int lanes, int folds) {
  const double elements =
      static_cast<double>(whole(nodes0, lanes / folds) * lanes) * whole(nodes1, folds);
  return elements / (static_cast<double>(nodes0) * nodes1);
}

}  // namespace

LatticeRows::LatticeRows(const LatticeShape& shape, int lanes, bool may_fold) : shape_(shape) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t along = 0; along < 3; ++along) {
    const std::array<std::size_t, 3> axes = axes_from(along);
    const int nodes0 = shape.nodes[axes[0]];
    const int nodes1 = shape.nodes[axes[1]];
    // At least two rows per layer, so that the accesses of a vector beyond its row stay in the
    // layer.
    for (int folds = 1; folds == 1 || (may_fold && folds <= lanes && whole(nodes1, folds) > 1);
         folds *= 2) {
      const double cost =
          elements_per_node(nodes0, nodes1, lanes, folds) * (folds > 1 ? worth_folding : 1.0);
      if (cost >= least) { continue; }
      least = cost;
      axes_ = axes;
      folds_ = folds;
    }
  }
  for (std::size_t n = 0; n < 3; ++n) { nodes_[n] = shape.nodes[axes_[n]]; }
  pieces_ = lanes / folds_;
  vectors_ = whole(nodes_[0], pieces_);
  rows1_ = whole(nodes_[1], folds_);
}

auto LatticeRows::place_of(int node) const -> Place {
  const std::array<int, 3> at = shape_.place(node);
  return {at[axes_[0]], at[axes_[1]], at[axes_[2]]};
}

std::vector<unsigned char> LatticeRows::moving(const NetworkProblem& problem) const {
  std::vector<unsigned char> moving(count(), 0);
  for (const int node : problem.free_nodes()) { moving[row_of(place_of(node))] = 1; }
  return moving;
}

long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows) {
  const std::vector<unsigned char> moving = rows.moving(problem);
  const auto stands = [&](int node) { return moving[rows.row_of(rows.place_of(node))] == 0; };
  const SpringList& springs = problem.network().springs;
  long count = 0;
  for (const SpringList::Run& run : springs.runs()) {
    for (int node = run.first_node; node < run.first_node + run.nodes; ++node) {
      if (!stands(node)) { continue; }
      count += std::ranges::count_if(
          springs.bonds(run), [&](const SpringList::Bond& bond) { return stands(node + bond.to); });
    }
  }
  return count;
}

namespace {

/// Unused elements before and after the rows that the outermost lanes access: one cache line.
template <class Real> constexpr Eigen::Index margin = 64 / sizeof(Real);

/// Returns the length of a vector of all coordinates: a multiple of the margin.
template <class Real> Eigen::Index size_for(Eigen::Index elements) {
  return (elements + 3 * margin<Real> - 1) / margin<Real> * margin<Real>;
}

/// Returns the slot of a spring with offset `step` along (row, second, third).
std::size_t slot_of(const std::array<int, 3>& step) {
  for (int kind = 0; kind < lattice::neighbour_kinds; ++kind) {
    const auto& to = lattice::neighbour_steps[kind];
    if (step[1] == to[0] && step[2] == to[1]) {
      return static_cast<std::size_t>(2 + 3 * kind + step[0]);
    }
  }
  return 0;
}

bool leads_back(const std::array<int, 3>& step) {
  if (step[2] != 0) { return step[2] < 0; }
  return step[1] != 0 ? step[1] < 0 : step[0] < 0;
}

}  // namespace

template <class Real> std::vector<lattice::Kernels<Real>> lattice_kernels() {
  return kernels_here(&lattice::avx512_kernels<Real>, &lattice::avx2_kernels<Real>,
                      &lattice::baseline_kernels<Real>);
}

template <class Real>
LatticeSprings<Real>::LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape,
                                     int lanes, bool skip, bool may_fold)
    : problem_(problem),
      spacing_(shape.spacing),
      rows_(shape, lanes, may_fold),
      lanes_(lanes),
      vectors_(rows_.vectors()),
      size_(size_for<Real>(static_cast<Eigen::Index>(rows_.count()) * vectors_ * 3 * lanes_)),
      row_moves_(skip ? rows_.moving(problem) : std::vector<unsigned char>(rows_.count(), 1)) {
  fill_tables(problem, skip);
}

template <class Real>
Eigen::Index LatticeSprings<Real>::element_of(const LatticeRows::Place& place) const {
  const auto row = static_cast<Eigen::Index>(rows_.row_of(place));
  return margin<Real> + (row * vectors_ + place[0] % vectors_) * 3 * lanes_ +
         rows_.first_lane(place) + place[0] / vectors_;
}

template <class Real> NodeLayout LatticeSprings<Real>::layout() const {
  NodeLayout layout{.size = size_, .stride = lanes_};
  const int nodes = static_cast<int>(problem_.network().node_count());
  layout.first.reserve(static_cast<std::size_t>(nodes));
  for (int node = 0; node < nodes; ++node) {
    const bool fixed = problem_.coordinate(node) < 0;
    layout.first.push_back(fixed ? -1 : static_cast<int>(element_of(rows_.place_of(node))));
  }
  return layout;
}

template <class Real>
auto LatticeSprings<Real>::stretch_of(int node, int nodes, const SpringList::Bond& bond) const
    -> Stretch {
  const LatticeRows::Place a = rows_.place_of(node);
  const LatticeRows::Place b = rows_.place_of(node + bond.to);
  std::array<int, 3> step{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const bool back = leads_back(step);
  if (back) {
    for (int& s : step) { s = -s; }
  }
  const LatticeRows::Place& from = back ? b : a;
  return {.row = static_cast<std::uint32_t>(rows_.row_of(from)),
          .place = from[0],
          .nodes = nodes,
          .slot = static_cast<std::uint16_t>(slot_of(step)),
          .first_lane = static_cast<std::uint16_t>(rows_.first_lane(from)),
          .bond = &bond};
}

/// Returns the springs sorted by the row that computes them, in list order within a row. Row n has
/// the springs begins[n] to begins[n + 1].
template <class Real>
auto LatticeSprings<Real>::by_row(const SpringList& springs, std::vector<std::size_t>& begins) const
    -> std::vector<Stretch> {
  const int together = rows_.follows_index() ? rows_.nodes()[0] : 1;
  const auto visit_all = [&](auto visit) {
    for (const SpringList::Run& run : springs.runs()) {
      const int end = run.first_node + run.nodes;
      for (int node = run.first_node; node < end;) {
        const int piece_end = std::min(end, (node / together + 1) * together);
        for (const SpringList::Bond& bond : springs.bonds(run)) {
          visit(stretch_of(node, piece_end - node, bond));
        }
        node = piece_end;
      }
    }
  };
  begins.assign(row_moves_.size() + 1, 0);
  visit_all([&](const Stretch& stretch) { ++begins[stretch.row + 1]; });
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::size_t> next(begins.begin(), begins.end() - 1);
  std::vector<Stretch> sorted(begins.back());
  visit_all([&](const Stretch& stretch) { sorted[next[stretch.row]++] = stretch; });
  return sorted;
}

/// Fills the tables row by row; equal rows share a table.
template <class Real>
void LatticeSprings<Real>::fill_tables(const NetworkProblem& problem, bool skip) {
  const SpringList& springs = problem.network().springs;
  damped_ = !skip || is_damped(springs);
  const auto numbers = static_cast<std::size_t>(damped_ ? 2 : 1);
  const auto lanes = static_cast<std::size_t>(lanes_);
  const std::size_t slot_length = numbers * lanes;
  std::vector<std::size_t> begins;
  const std::vector<Stretch> stretches = by_row(springs, begins);
  const auto before = [](const std::vector<Real>& a, const std::vector<Real>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) <
           0;  // NaN compares unequal to every number
  };
  std::map<std::vector<Real>, long, decltype(before)> known(before);
  std::vector<Real> row(static_cast<std::size_t>(vectors_) * lattice::slots * slot_length);
  std::span<const Stretch> row_before;
  for (std::size_t n = 0; n + 1 < begins.size(); ++n) {
    const auto own = std::span(stretches).subspan(begins[n], begins[n + 1] - begins[n]);
    if (n > 0 && std::ranges::equal(own, row_before, [](const Stretch& a, const Stretch& b) {
          return a.equals(b);
        })) {
      row_table_.push_back(row_table_.back());
      continue;
    }
    row_before = own;
    std::ranges::fill(row, Real(0));
    for (const Stretch& stretch : own) {
      used_[stretch.slot] = true;
      for (int place = stretch.place; place < stretch.place + stretch.nodes; ++place) {
        const auto vector = static_cast<std::size_t>(place % vectors_);
        const auto lane = static_cast<std::size_t>(stretch.first_lane + place / vectors_);
        Real* constants =
            row.data() + (vector * lattice::slots + stretch.slot) * slot_length + lane;
        constants[0] += static_cast<Real>(stretch.bond->stiffness);
        if (damped_) { constants[lanes] += static_cast<Real>(stretch.bond->viscosity); }
      }
    }
    const auto [found, is_new] = known.try_emplace(row, static_cast<long>(tables_.size()));
    if (is_new) { tables_.insert(tables_.end(), row.begin(), row.end()); }
    row_table_.push_back(found->second);
  }
}

template <class Real> Real LatticeSprings<Real>::length_along(int axes) const {
  return static_cast<Real>(spacing_ * std::sqrt(static_cast<double>(axes)));
}

/// Returns the links of a row. After the last interleaved row follow the nodes of the first row in
/// the next lane group.
template <class Real> lattice::Links<Real> LatticeSprings<Real>::links_of(int row1) const {
  const int rows1 = rows_.rows1();
  lattice::Links<Real> links;
  for (int kind = 0; kind < lattice::neighbour_kinds; ++kind) {
    const auto& step = lattice::neighbour_steps[kind];
    const std::size_t slot = 1 + 3 * static_cast<std::size_t>(kind);
    const bool sides = used_[slot] || used_[slot + 2];
    const int folds =
        row1 + step[0] < 0 ? -1 : (row1 + step[0]) / rows1;  // offset in interleaved rows
    if ((!sides && !used_[slot + 1]) || (folds != 0 && rows_.folds() == 1)) { continue; }
    const int rows = step[0] - folds * rows1;
    links.to[links.count++] = {
        .layers = step[1],
        .rows = rows + step[1] * rows1,
        .elements = static_cast<long>(rows) * vectors_ * 3 * lanes_ + folds * rows_.pieces(),
        .constants = static_cast<long>(slot) * lanes_ * (damped_ ? 2 : 1),
        .rest_across = length_along(std::abs(step[0]) + step[1]),
        .rest_aside = length_along(std::abs(step[0]) + step[1] + 1),
        .sides = sides};
    links.within += 1 - step[1];
  }
  return links;
}

template <class Real> lattice::View<Real> LatticeSprings<Real>::view() const {
  return {.rows1 = rows_.rows1(),
          .rows2 = rows_.nodes()[2],
          .vectors = vectors_,
          .row_length = 3L * vectors_ * lanes_,
          .layer_length = 3L * vectors_ * lanes_ * rows_.rows1(),
          .folded = rows_.folds() > 1,
          .lead = margin<Real>,
          .lanes = lanes_,
          .numbers = damped_ ? 2 : 1,
          .tables = tables_.data(),
          .row_table = row_table_.data(),
          .row_moves = row_moves_.data(),
          .own_rest = length_along(1),
          .own_springs = used_[0],
          .links = {links_of(0), links_of(1), links_of(rows_.rows1() - 1)}};
}

template <class Real>
Eigen::Matrix<Real, Eigen::Dynamic, 1> LatticeSprings<Real>::initial_position() const {
  Eigen::Matrix<Real, Eigen::Dynamic, 1> q(size_);
  for (Eigen::Index i = 0; i < size_; ++i) {
    q(i) = static_cast<Real>(-spacing_ * static_cast<double>(1 + i));
  }
  const SpringNetwork& network = problem_.network();
  for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
    at_node(q, element_of(rows_.place_of(node)), lanes_) =
        network.initial_place(node).template cast<Real>();
  }
  return q;
}

template <class Real> std::size_t LatticeSprings<Real>::memory_bytes() const {
  return tables_.capacity() * sizeof(Real) + row_table_.capacity() * sizeof(long) +
         row_moves_.capacity();
}

template std::vector<lattice::Kernels<double>> lattice_kernels<double>();
template std::vector<lattice::Kernels<float>> lattice_kernels<float>();
template class LatticeSprings<double>;
template class LatticeSprings<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/kernels/lattice_rows.hpp"

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

LatticeRows::LatticeRows(const LatticeShape& lattice, int lanes, bool may_fold) : shape(lattice) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t along = 0; along < 3; ++along) {
    const std::array<std::size_t, 3> order = axes_from(along);
    const int nodes0 = shape.nodes[order[0]];
    const int nodes1 = shape.nodes[order[1]];
    // At least two rows per layer, so that the accesses of a vector beyond its row stay in the
    // layer.
    for (int n = 1; n == 1 || (may_fold && n <= lanes && whole(nodes1, n) > 1); n *= 2) {
      const double cost =
          elements_per_node(nodes0, nodes1, lanes, n) * (n > 1 ? worth_folding : 1.0);
      if (cost >= least) { continue; }
      least = cost;
      axes = order;
      folds = n;
    }
  }
  for (std::size_t n = 0; n < 3; ++n) { nodes[n] = shape.nodes[axes[n]]; }
  pieces = lanes / folds;
  vectors = whole(nodes[0], pieces);
  rows1 = whole(nodes[1], folds);
}

auto LatticeRows::place_of(int node) const -> Place {
  const std::array<int, 3> at = shape.place(node);
  return {at[axes[0]], at[axes[1]], at[axes[2]]};
}

std::vector<unsigned char> LatticeRows::moving(const NetworkProblem& problem) const {
  std::vector<unsigned char> moves(count(), 0);
  for (const int node : problem.free_nodes()) { moves[row_of(place_of(node))] = 1; }
  return moves;
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

template <> std::vector<lattice::Kernels<double>> lattice_kernels() {
  return kernels_here(&KernelSet::lattice_double);
}
template <> std::vector<lattice::Kernels<float>> lattice_kernels() {
  return kernels_here(&KernelSet::lattice_float);
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_rows.hpp"

#include <algorithm>

namespace palpate {

namespace {

int vectors_for(int nodes, int lanes) { return (nodes + lanes - 1) / lanes; }

/// Waste of an axis: elements of a row for each of its nodes.
double elements_per_node(int nodes, int lanes) {
  return static_cast<double>(vectors_for(nodes, lanes) * lanes) / nodes;
}

/// The two others keep their order.
std::array<std::size_t, 3> axes_for(const LatticeShape& shape, int lanes) {
  std::size_t along = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    const double waste = elements_per_node(shape.nodes[axis], lanes);
    if (waste < elements_per_node(shape.nodes[along], lanes)) { along = axis; }
  }
  return {along, along == 0 ? 1U : 0U, along == 2 ? 1U : 2U};
}

}  // namespace

LatticeRows::LatticeRows(const LatticeShape& shape, int lanes)
    : shape_(shape), axes_(axes_for(shape, lanes)) {
  for (std::size_t n = 0; n < 3; ++n) { nodes_[n] = shape.nodes[axes_[n]]; }
  vectors_ = vectors_for(nodes_[0], lanes);
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

}  // namespace palpate

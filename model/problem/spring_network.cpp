// SPDX-License-Identifier: MIT

#include "model/problem/spring_network.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

bool has_same_eigen_memory_as_library(EigenMemoryHere /*memory*/) noexcept { return true; }

Eigen::Vector3d LatticeShape::position(int i, int j, int l) const {
  return {spacing * (i - 0.5 * (nodes[0] - 1)), spacing * (j - 0.5 * (nodes[1] - 1)), spacing * l};
}

double LatticeShape::bond_length(const std::array<int, 3>& step) const {
  return (spacing * Eigen::Vector3d(step[0], step[1], step[2])).norm();
}

bool LatticeShape::has_bond(const Spring& spring) const {
  const int count = node_count();
  if (spring.a < 0 || spring.b < 0 || spring.a >= count || spring.b >= count) { return false; }
  const std::array<int, 3> a = place(spring.a);
  const std::array<int, 3> b = place(spring.b);
  const std::array<int, 3> step{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  if (!std::ranges::all_of(step, [](int s) { return std::abs(s) <= 1; })) { return false; }
  constexpr double rounding = 1e-12;  // relative; for a length computed in a different order
  const double natural = bond_length(step);
  return std::abs(spring.rest_length - natural) <= rounding * natural;  // false for NaN
}

SpringList::SpringList(std::span<const Spring> springs, const std::optional<LatticeShape>& lattice)
    : lattice_(lattice) {
  for (const Spring& spring : springs) { push_back(spring); }
  settle();
  runs_.shrink_to_fit();
  bonds_.shrink_to_fit();
}

void SpringList::push_back(const Spring& spring) {
  if (lattice_ && !lattice_->has_bond(spring)) { lattice_.reset(); }
  if (!open_ || spring.a != runs_.back().first_node) {
    settle();
    runs_.push_back({.first_node = spring.a,
                     .nodes = 1,
                     .first_bond = static_cast<std::uint32_t>(bonds_.size()),
                     .first_spring = size_});
    open_ = true;
  }
  bonds_.push_back(
      {spring.b - spring.a, spring.law, spring.stiffness, spring.viscosity, spring.rest_length});
  ++runs_.back().bonds;
  ++size_;
}

bool SpringList::same(const Pattern& known, const Run& run) const {
  const auto pattern = std::span(bonds_).subspan(known.first_bond, known.bonds);
  return std::ranges::equal(pattern, bonds(run));
}

/// Completes the last run: if its node has the bonds of an earlier node, it uses that pattern.
void SpringList::settle() {
  if (!open_) { return; }
  open_ = false;
  Run& last = runs_.back();
  const auto known =
      std::ranges::find_if(recent_, [&](const Pattern& pattern) { return same(pattern, last); });
  if (known == recent_.end()) {
    recent_[next_recent_++ % recent_.size()] = {last.first_bond, last.bonds};
    return;
  }
  bonds_.resize(last.first_bond);
  last.first_bond = known->first_bond;
  if (runs_.size() < 2) { return; }
  Run& before = runs_[runs_.size() - 2];
  const bool alike = before.first_bond == last.first_bond && before.bonds == last.bonds;
  if (alike && before.first_node + before.nodes == last.first_node) {
    ++before.nodes;
    runs_.pop_back();
  }
}

std::vector<Spring> SpringList::listed() const {
  std::vector<Spring> all;
  all.reserve(size_);
  for (const Spring& spring : *this) { all.push_back(spring); }
  return all;
}

Spring SpringList::operator[](std::size_t n) const {
  const auto after = std::ranges::upper_bound(runs_, n, {}, &Run::first_spring);
  const Run& run = *(after - 1);
  const std::size_t within = n - run.first_spring;
  return spring_of(run.first_node + static_cast<int>(within / run.bonds),
                   bonds(run)[within % run.bonds]);
}

bool is_damped(const SpringList& springs) {
  return std::ranges::any_of(springs.kinds(),
                             [](const SpringList::Bond& bond) { return bond.viscosity != 0.0; });
}

bool is_damped(const SpringNetwork& network) {
  return is_damped(network.springs) ||
         std::ranges::any_of(network.cells, [](const VolumeCell& c) { return c.viscosity > 0.0; });
}

bool relaxes(const SpringNetwork& network) {
  return std::ranges::any_of(network.laws,
                             [](const MaterialLaw& law) { return !law.branches.empty(); });
}

int SpringNetwork::law_number(const MaterialLaw& law) {
  if (law.is_linear_elastic()) { return 0; }
  const auto found = std::ranges::find(laws, law);
  const auto number = static_cast<int>(found - laws.begin()) + 1;
  if (found == laws.end()) { laws.push_back(law); }
  return number;
}

bool has_volume_terms(const SpringNetwork& network) {
  return std::ranges::any_of(network.cells, [](const VolumeCell& c) { return c.stiffness > 0.0; });
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_springs.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>

#include "model/dynamics/spring_force.hpp"
#include "model/stepping/instruction_set.hpp"

namespace palpate {

namespace {

/// Elements before and after the rows, which the outermost lanes touch and which mean nothing.
constexpr Eigen::Index margin = 8;

/// Slot of a spring that leads by `step` along (row, second, third).
std::size_t slot_of(const std::array<int, 3>& step) {
  for (int kind = 0; kind < lattice::neighbour_kinds; ++kind) {
    const auto& to = lattice::neighbour_steps[kind];
    if (step[1] == to[0] && step[2] == to[1]) { return static_cast<std::size_t>(2 + 3 * kind + step[0]); }
  }
  return 0;
}

bool leads_back(const std::array<int, 3>& step) {
  if (step[2] != 0) { return step[2] < 0; }
  return step[1] != 0 ? step[1] < 0 : step[0] < 0;
}

static_assert(lattice::View<double>::zero_length == zero_length);

}  // namespace

template <class Real>
lattice::Kernels<Real> lattice_kernels() noexcept {
  return has_avx2() ? lattice::avx2_kernels<Real>() : lattice::baseline_kernels<Real>();
}

template <class Real>
LatticeSprings<Real>::LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes,
                                     bool skip)
    : problem_(problem),
      spacing_(shape.spacing),
      rows_(shape, lanes),
      lanes_(lanes),
      vectors_(rows_.vectors()) {
  lay_out(problem, skip);
  fill_tables(problem, skip);
}

template <class Real>
Eigen::Index LatticeSprings<Real>::element_of(const LatticeRows::Place& place) const {
  const auto row = static_cast<Eigen::Index>(rows_.row_of(place));
  return margin + (row * vectors_ + place[0] % vectors_) * lanes_ + place[0] / vectors_;
}

template <class Real>
void LatticeSprings<Real>::lay_out(const NetworkProblem& problem, bool skip) {
  const auto rows = static_cast<Eigen::Index>(rows_.count());
  const Eigen::Index elements = 2 * margin + rows * vectors_ * lanes_;
  layout_.stride = (elements + margin - 1) / margin * margin;
  layout_.size = 3 * layout_.stride;
  row_moves_ = skip ? rows_.moving(problem) : std::vector<unsigned char>(rows_.count(), 1);
  for (int node = 0; node < problem.network().node_count(); ++node) {
    const bool fixed = problem.coordinate(node) < 0;
    layout_.first.push_back(fixed ? -1 : element_of(rows_.place_of(node)));
  }
}

template <class Real>
auto LatticeSprings<Real>::bond_of(const Spring& spring) const -> Bond {
  LatticeRows::Place from = rows_.place_of(spring.a);
  const LatticeRows::Place to = rows_.place_of(spring.b);
  std::array<int, 3> step{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  if (leads_back(step)) {
    from = to;
    for (int& s : step) { s = -s; }
  }
  return {from, slot_of(step)};
}

/// Springs by the row that they lead from, in their order; row n has those from begins[n] to begins[n + 1].
template <class Real>
std::vector<std::uint32_t> LatticeSprings<Real>::by_row(const std::vector<Spring>& springs,
                                                        std::vector<std::uint32_t>& begins) const {
  begins.assign(row_moves_.size() + 1, 0);
  for (const Spring& spring : springs) { ++begins[rows_.row_of(bond_of(spring).from) + 1]; }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::uint32_t> next(begins.begin(), begins.end() - 1);
  std::vector<std::uint32_t> order(springs.size());
  for (std::uint32_t n = 0; n < springs.size(); ++n) {
    order[next[rows_.row_of(bond_of(springs[n]).from)]++] = n;
  }
  return order;
}

/// One row at a time; rows that are equal share a table.
template <class Real>
void LatticeSprings<Real>::fill_tables(const NetworkProblem& problem, bool skip) {
  const auto& springs = problem.network().springs;
  damped_ = !skip || std::ranges::any_of(springs, [](const Spring& s) { return s.viscosity != 0.0; });
  const auto numbers = static_cast<std::size_t>(damped_ ? 2 : 1);
  const auto lanes = static_cast<std::size_t>(lanes_);
  const std::size_t slot_length = numbers * lanes;
  std::vector<std::uint32_t> begins;
  const std::vector<std::uint32_t> order = by_row(springs, begins);
  const auto before = [](const std::vector<Real>& a, const std::vector<Real>& b) {
    return std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) < 0;  // NaN is equal to no number
  };
  std::map<std::vector<Real>, long, decltype(before)> known(before);
  std::vector<Real> row(static_cast<std::size_t>(vectors_) * lattice::slots * slot_length);
  for (std::size_t n = 0; n + 1 < begins.size(); ++n) {
    std::ranges::fill(row, Real(0));
    for (std::uint32_t k = begins[n]; k < begins[n + 1]; ++k) {
      const Spring& spring = springs[order[k]];
      const Bond bond = bond_of(spring);
      used_[bond.slot] = true;
      const auto vector = static_cast<std::size_t>(bond.from[0] % vectors_);
      const auto lane = static_cast<std::size_t>(bond.from[0] / vectors_);
      Real* constants = row.data() + (vector * lattice::slots + bond.slot) * slot_length + lane;
      constants[0] += static_cast<Real>(spring.stiffness);
      if (damped_) { constants[lanes] += static_cast<Real>(spring.viscosity); }
    }
    const auto [found, is_new] = known.try_emplace(row, static_cast<long>(tables_.size()));
    if (is_new) { tables_.insert(tables_.end(), row.begin(), row.end()); }
    row_table_.push_back(found->second);
  }
}

template <class Real>
lattice::View<Real> LatticeSprings<Real>::view() const {
  lattice::View<Real> view{.rows1 = rows_.nodes()[1],
                           .rows2 = rows_.nodes()[2],
                           .vectors = vectors_,
                           .lead = margin,
                           .stride = layout_.stride,
                           .numbers = damped_ ? 2 : 1,
                           .tables = tables_.data(),
                           .row_table = row_table_.data(),
                           .row_moves = row_moves_.data(),
                           .own_springs = used_[0]};
  for (int n = 0; n < 3; ++n) { view.rest[n] = static_cast<Real>(spacing_ * std::sqrt(n + 1.0)); }
  for (std::size_t kind = 0; kind < lattice::neighbour_kinds; ++kind) {
    view.sides[kind] = used_[1 + 3 * kind] || used_[3 + 3 * kind];
    view.straight[kind] = used_[2 + 3 * kind] || view.sides[kind];
  }
  return view;
}

template <class Real>
Eigen::Matrix<Real, Eigen::Dynamic, 1> LatticeSprings<Real>::initial_position() const {
  Eigen::Matrix<Real, Eigen::Dynamic, 1> q(layout_.size);
  for (Eigen::Index i = 0; i < layout_.size; ++i) {
    q(i) = static_cast<Real>(-spacing_ * static_cast<double>(1 + i % layout_.stride));
  }
  const NodeVectors places = problem_.network().initial_position();
  for (int node = 0; node < places.cols(); ++node) {
    at_node(q, element_of(rows_.place_of(node)), layout_.stride) = places.col(node).template cast<Real>();
  }
  return q;
}

template <class Real>
std::size_t LatticeSprings<Real>::memory_bytes() const {
  return tables_.size() * sizeof(Real) + row_table_.size() * sizeof(long) + row_moves_.size() +
         layout_.first.size() * sizeof(Eigen::Index);
}

template lattice::Kernels<double> lattice_kernels<double>() noexcept;
template lattice::Kernels<float> lattice_kernels<float>() noexcept;
template class LatticeSprings<double>;
template class LatticeSprings<float>;

}  // namespace palpate

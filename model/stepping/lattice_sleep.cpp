// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_sleep.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

template <class Real>
LatticeSleep<Real>::LatticeSleep(const lattice::View<Real>& view, std::vector<unsigned char> awake, double most_withheld)
    : rows1_(view.rows1),
      rows2_(view.rows2),
      lead_(view.lead),
      row_length_(view.row_length),
      lanes_(view.lanes),
      most_withheld_(most_withheld),
      awake_(std::move(awake)) {
  const int rows = rows1_ * rows2_;
  state_.assign(awake_.size(), Row::asleep);
  border_.reserve(awake_.size());
  for (int row = 0; row < rows; ++row) {
    const auto n = static_cast<std::size_t>(row);
    if (view.row_moves[n] == 0) {
      state_[n] = Row::fixed;
      awake_[n] = 0;
      continue;
    }
    ++able_count_;
    if (awake_[n] == 0) { continue; }
    state_[n] = Row::awake;
    ++awake_count_;
  }
  for (int row = 0; row < rows; ++row) {
    if (state_[static_cast<std::size_t>(row)] == Row::awake) { watch_around(row); }
  }
}

template <class Real>
void LatticeSleep<Real>::watch_around(int row) noexcept {
  const int at1 = row % rows1_;
  const int at2 = row / rows1_;
  for (int to2 = std::max(0, at2 - 1); to2 <= std::min(rows2_ - 1, at2 + 1); ++to2) {
    for (int to1 = std::max(0, at1 - 1); to1 <= std::min(rows1_ - 1, at1 + 1); ++to1) {
      const int there = to2 * rows1_ + to1;
      Row& state = state_[static_cast<std::size_t>(there)];
      if (state != Row::asleep) { continue; }
      state = Row::border;
      border_.push_back(there);  // reserved for all rows
    }
  }
}

template <class Real>
void LatticeSleep<Real>::wake(std::size_t place_in_border) noexcept {
  const int row = border_[place_in_border];
  border_[place_in_border] = border_.back();
  border_.pop_back();
  state_[static_cast<std::size_t>(row)] = Row::awake;
  awake_[static_cast<std::size_t>(row)] = 1;
  ++awake_count_;
  watch_around(row);
}

template <class Real>
template <class Visit>
void LatticeSleep<Real>::visit_nodes(int row, Visit visit) const noexcept {
  for (long vector = begin_of(row); vector < begin_of(row) + row_length_; vector += 3 * lanes_) {
    for (long i = vector; i < vector + lanes_; ++i) { visit(i); }
  }
}

template <class Real>
double LatticeSleep<Real>::pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept {
  double pull = 0.0;
  visit_nodes(row, [&](long i) {
    if (inverse_mass[i] == Real(0)) { return; }
    const auto x = static_cast<double>(f[i]);
    const auto y = static_cast<double>(f[i + lanes_]);
    const auto z = static_cast<double>(f[i + 2 * lanes_]);
    pull += std::sqrt(x * x + y * y + z * z);
  });
  return pull;
}

template <class Real>
void LatticeSleep<Real>::clear(Real* f, int row) const noexcept {
  std::fill_n(f + begin_of(row), static_cast<std::size_t>(row_length_), Real(0));
}

/// Each row may withhold its share of what all may. A pull that is no number wakes.
template <class Real>
template <class Visit>
void LatticeSleep<Real>::judge_border(Real* f, const Real* inverse_mass, Visit visit) noexcept {
  const double share = most_withheld_ / static_cast<double>(std::max<std::size_t>(1, border_.size()));
  for (std::size_t n = 0; n < border_.size();) {
    const int row = border_[n];
    if (pull_on(f, inverse_mass, row) <= share) {
      clear(f, row);
      ++n;
    } else {
      visit(row);
      wake(n);
    }
  }
}

template <class Real>
void LatticeSleep<Real>::wake_pulled(Real* f, const Real* inverse_mass) noexcept {
  judge_border(f, inverse_mass, [](int) {});
}

/// As lattice::move_row() does it, without weight: where anything weighs, nothing sleeps.
template <class Real>
double LatticeSleep<Real>::wake_in_step(const lattice::Fields<Real>& fields) noexcept {
  const lattice::Move<Real>& move = *fields.move;
  double squares = 0.0;
  judge_border(fields.f, move.inverse_mass, [&](int row) {
    visit_nodes(row, [&](long i) {
      for (long at = i; at <= i + 2 * lanes_; at += lanes_) {
        move.v[at] += move.h * (fields.f[at] * move.inverse_mass[i]);
        move.q[at] += move.h * move.v[at];
        squares += static_cast<double>(move.v[at] * move.v[at]);
      }
    });
    clear(fields.f, row);
  });
  return squares;
}

template <class Real>
void LatticeSleep<Real>::withhold(Real* f) const noexcept {
  for (const int row : border_) { clear(f, row); }
}

template <class Real>
std::size_t LatticeSleep<Real>::memory_bytes() const noexcept {
  return state_.size() + awake_.size() + border_.capacity() * sizeof(int);
}

template class LatticeSleep<double>;
template class LatticeSleep<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Rows of a lattice at rest, which are not stepped until they are pulled (model/EQUATIONS.md, "Sleeping rows").

#include <vector>

#include "model/stepping/lattice_view.hpp"

namespace palpate {

template <class Real>
class LatticeSleep {
 public:
  /// `view` of the whole lattice, whose rows of `row_length` elements move or never do; 1 in `awake` for those
  /// that move from the beginning. `most_withheld`: size of all forces on sleeping nodes together [N].
  LatticeSleep(const lattice::View<Real>& view, std::vector<unsigned char> awake,
               double most_withheld);

  /// 1 for a row that is stepped; the same vector for ever, to stand in a View.
  [[nodiscard]] const unsigned char* awake() const noexcept { return awake_.data(); }
  /// Share of the rows that can move.
  [[nodiscard]] double awake_share() const noexcept {
    return static_cast<double>(awake_count_) / static_cast<double>(able_count_);
  }

  /// After forces were added to f [N]: rows that are pulled too hard wake; those on the others are withheld.
  void wake_pulled(Real* f, const Real* inverse_mass) noexcept;
  /// After a step (lattice::Task::step): likewise, and rows that wake take theirs. Returns the sum of squares of
  /// their velocities.
  double wake_in_step(const lattice::Fields<Real>& fields) noexcept;
  /// Takes from f what is on sleeping rows.
  void withhold(Real* f) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  enum class Row : unsigned char { fixed, asleep, border, awake };

  [[nodiscard]] long begin_of(int row) const noexcept { return lead_ + row * row_length_; }
  /// visit(where the x of a node stands)
  template <class Visit>
  void visit_nodes(int row, Visit visit) const noexcept;
  void clear(Real* f, int row) const noexcept;
  [[nodiscard]] double pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept;
  void wake(std::size_t place_in_border) noexcept;
  void watch_around(int row) noexcept;
  /// visit(row) for each that wakes; the others' forces are taken away.
  template <class Visit>
  void judge_border(Real* f, const Real* inverse_mass, Visit visit) noexcept;

  int rows1_;
  int rows2_;
  long lead_;
  long row_length_;
  long lanes_;
  double most_withheld_;
  std::vector<Row> state_;
  std::vector<unsigned char> awake_;
  std::vector<int> border_;  ///< sleeping rows beside one that is awake
  long awake_count_ = 0;
  long able_count_ = 0;
};

}  // namespace palpate

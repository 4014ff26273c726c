// SPDX-License-Identifier: MIT
#include "model/stepping/lattice_slabs.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace palpate {

template <class Real>
int LatticeSlabs<Real>::most_threads(int layers, long vectors, int wanted) {
  return vectors > 1 ? std::max(1, std::min(wanted, layers / 2)) : 1;
}

template <class Real>
LatticeSlabs<Real>::LatticeSlabs(const lattice::View<Real>& view, int threads)
    : view_(view), layer_length_(view.layer_length), copy_length_(layer_length_ + 2 * view.lead) {
  const int count = most_threads(view.rows2, view.vectors, threads);
  for (int n = 0; n <= count; ++n) {
    begins_.push_back(static_cast<int>(static_cast<long>(view.rows2) * n / count));
  }
  for (int n = 1; n < count; ++n) {
    boundaries_.push_back(std::make_unique<Boundary>());
    for (auto* numbers : {&boundaries_.back()->below, &boundaries_.back()->above}) {
      numbers->assign(static_cast<std::size_t>(2 * copy_length_ + few_length()), Real(0));
    }
  }
  sums_.assign(static_cast<std::size_t>(count), 0.0);
  if (count > 1) { team_ = std::make_unique<Team>(count); }
}

template <class Real>
lattice::Nodes<Real> LatticeSlabs<Real>::layer_in(AlignedVector<Real>& numbers) const noexcept {
  Real* first = numbers.data() + view_.lead;
  return {.q = first, .v = first + copy_length_, .f = first + 2 * copy_length_};
}

template <class Real>
void LatticeSlabs<Real>::copy(const lattice::Fields<Real>& fields, int layer,
                              AlignedVector<Real>& to) const noexcept {
  const long begin = view_.lead + layer * layer_length_;
  const auto bytes = static_cast<std::size_t>(layer_length_) * sizeof(Real);
  Real* q = to.data() + view_.lead;
  std::memcpy(q, fields.q + begin, bytes);
  if (fields.v != nullptr) { std::memcpy(q + copy_length_, fields.v + begin, bytes); }
}

/// The thread of the upper slab copies the two layers that meet and adds what the lower one does to the upper;
/// the lower slab's thread waits for the copy before its last layer, which is long after.
template <class Real>
template <class VisitLayers>
double LatticeSlabs<Real>::sweep_slab(std::size_t number, lattice::Kernel<Real> kernel,
                                      const lattice::Fields<Real>& fields, const VisitLayers& visit_layers) noexcept {
  const int begin = begins_[number];
  const int end = begins_[number + 1];
  if (number > 0) {
    Boundary& under = *boundaries_[number - 1];
    copy(fields, begin - 1, under.below);
    copy(fields, begin, under.above);
    under.copied.store(round_, std::memory_order_release);
    const lattice::Nodes<Real> below = layer_in(under.below);
    (void)kernel(view_, {.begin = begin - 1, .end = begin, .below = &below}, fields);
  }
  if (number == boundaries_.size()) { return visit_layers(begin, end); }
  const double sum = visit_layers(begin, end - 1);
  Boundary& over = *boundaries_[number];
  while (over.copied.load(std::memory_order_acquire) != round_) { relax(); }
  const lattice::Nodes<Real> above = layer_in(over.above);
  return sum + kernel(view_, {.begin = end - 1, .end = end, .beyond = &above}, fields);
}

/// Sum of what work(number) returns for each slab.
template <class Real>
template <class Work>
double LatticeSlabs<Real>::share_out(const Work& work) noexcept {
  if (team_ == nullptr) { return work(0); }
  ++round_;
  auto kept = [&](int number) noexcept {
    const auto n = static_cast<std::size_t>(number);
    sums_[n] = work(n);
  };
  team_->run(kept);
  return std::accumulate(sums_.begin(), sums_.end(), 0.0);
}

template <class Real>
double LatticeSlabs<Real>::sweep(lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields) noexcept {
  const auto visit_layers = [&](int begin, int end) noexcept {
    return kernel(view_, {.begin = begin, .end = end}, fields);
  };
  return share_out([&](std::size_t number) noexcept { return sweep_slab(number, kernel, fields, visit_layers); });
}

template <class Real>
void LatticeSlabs<Real>::prepare_steps() {
  few_forces_.assign(sums_.size(), AlignedVector<Real>(static_cast<std::size_t>(few_length()), Real(0)));
  stands_.clear();
  for (long layer = 0; layer < view_.rows2; ++layer) {
    const unsigned char* moves = view_.row_moves + layer * view_.rows1;
    stands_.push_back(std::find(moves, moves + view_.rows1, 0) != moves + view_.rows1);
  }
}

template <class Real>
Real* LatticeSlabs<Real>::forces_of(const lattice::Fields<Real>& fields, int layer) const noexcept {
  return fields.f + view_.lead + layer % layers_kept * layer_length_;
}

template <class Real>
void LatticeSlabs<Real>::clear_standing_rows(const lattice::Fields<Real>& fields, int layer) const noexcept {
  if (stands_[static_cast<std::size_t>(layer)] == 0) { return; }
  const long row_length = view_.row_length;
  const unsigned char* moves = view_.row_moves + static_cast<long>(layer) * view_.rows1;
  for (long row = 0; row < view_.rows1; ++row) {
    if (moves[row] == 0) { std::fill_n(forces_of(fields, layer) + row * row_length, row_length, Real(0)); }
  }
}

template <class Real>
void LatticeSlabs<Real>::add_outside(const lattice::Fields<Real>& fields, const Outside<Real>& outside,
                                     int layer) const noexcept {
  if (layer >= view_.rows2) { return; }
  Real* f = forces_of(fields, layer);
  if (outside.weight != nullptr) {
    std::copy_n(outside.weight + view_.lead + layer * layer_length_, layer_length_, f);
  }
  for (int n = outside.pulls_begin[layer]; n < outside.pulls_begin[layer + 1]; ++n) {
    const Pull<Real>& pull = outside.pulls[n];
    for (long c = 0; c < 3; ++c) { f[pull.element + c * view_.lanes] += pull.force[c]; }
  }
}

template <class Real>
double LatticeSlabs<Real>::step(lattice::Kernel<Real> kernel, const lattice::Move<Real>& move,
                                const Outside<Real>& outside) noexcept {
  return share_out([&](std::size_t number) noexcept {
    AlignedVector<Real>& forces = few_forces_[number];
    const lattice::Fields<Real> fields{.q = move.q,
                                       .v = move.v,
                                       .f = forces.data(),
                                       .move = &move,
                                       .force_layers = layers_kept};
    std::ranges::fill(forces, Real(0));
    for (int n = 0; n < layers_kept; ++n) { add_outside(fields, outside, begins_[number] + n); }
    const auto visit_layers = [&](int begin, int end) noexcept {
      double sum = 0.0;
      for (int layer = begin; layer < end; ++layer) {
        sum += kernel(view_, {.begin = layer, .end = layer + 1}, fields);
        clear_standing_rows(fields, layer);
        add_outside(fields, outside, layer + layers_kept);
      }
      return sum;
    };
    return sweep_slab(number, kernel, fields, visit_layers);
  });
}

template <class Real>
std::size_t LatticeSlabs<Real>::memory_bytes() const noexcept {
  std::size_t bytes = few_forces_.size() * static_cast<std::size_t>(few_length()) * sizeof(Real);
  for (const auto& boundary : boundaries_) {
    bytes += (boundary->below.size() + boundary->above.size()) * sizeof(Real);
  }
  return bytes;
}

template class LatticeSlabs<double>;
template class LatticeSlabs<float>;

}  // namespace palpate

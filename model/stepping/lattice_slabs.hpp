// SPDX-License-Identifier: MIT
#pragma once
/// A lattice shared out among threads by layers, to the bits of one thread
/// (model/EQUATIONS.md, "Lattice in lanes").

#include <atomic>
#include <memory>
#include <vector>

#include "model/stepping/aligned_vector.hpp"
#include "model/stepping/lattice_view.hpp"
#include "model/stepping/team.hpp"

namespace palpate {

/// A load on one node of a layer.
template <class Real>
struct Pull {
  long element = 0;  ///< of the node's x, after the layer's first
  Real force[3]{};   ///< [N]
};

/// What acts on nodes beside their springs.
template <class Real>
struct Outside {
  const Real* weight = nullptr;       ///< of all coordinates [N]; null: none
  const Pull<Real>* pulls = nullptr;  ///< by layers
  const int* pulls_begin = nullptr;   ///< of each layer, and the last one's end
};

template <class Real>
class LatticeSlabs {
 public:
  /// Fewer threads than asked for where there are not two layers for each.
  LatticeSlabs(const lattice::View<Real>& view, int threads);

  /// Vectors at the ends of a row of one vector reach into rows of other layers: those are not shared out.
  [[nodiscard]] static int most_threads(int layers, long vectors, int wanted);

  /// Goes through the whole lattice; returns the sum of what the kernel returns.
  double sweep(lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields) noexcept;
  /// The same with a kernel that takes a step. Forces need no room of the caller's: they are kept for two layers at
  /// a time, which stay in the cache.
  double step(lattice::Kernel<Real> kernel, const lattice::Move<Real>& move, const Outside<Real>& outside) noexcept;
  /// Before the first step(): allocates.
  void prepare_steps();

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  static constexpr int layers_kept = 2;  ///< a layer's springs lead to itself and the next
  [[nodiscard]] long few_length() const noexcept { return layers_kept * layer_length_ + 2 * view_.lead; }
  /// Between two slabs: both layers as they were before either moved, and room for forces on them that the
  /// other slab's thread computes itself.
  struct Boundary {
    AlignedVector<Real> below;
    AlignedVector<Real> above;
    std::atomic<long> copied{0};  ///< round
  };
  /// q, v and f of a layer in one vector.
  [[nodiscard]] lattice::Nodes<Real> layer_in(AlignedVector<Real>& numbers) const noexcept;
  void copy(const lattice::Fields<Real>& fields, int layer, AlignedVector<Real>& to) const noexcept;
  /// visit_layers(begin, end) goes through layers that lead to no other slab.
  template <class VisitLayers>
  double sweep_slab(std::size_t number, lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields,
                    const VisitLayers& visit_layers) noexcept;
  [[nodiscard]] Real* forces_of(const lattice::Fields<Real>& fields, int layer) const noexcept;
  /// Where a layer's forces were come those of the one after next: rows that moved left none.
  void clear_standing_rows(const lattice::Fields<Real>& fields, int layer) const noexcept;
  void add_outside(const lattice::Fields<Real>& fields, const Outside<Real>& outside, int layer) const noexcept;
  template <class Work>
  double share_out(const Work& work) noexcept;

  lattice::View<Real> view_;
  long layer_length_;             ///< elements
  long copy_length_;              ///< of a layer's q, with what the outermost lanes touch on both sides
  std::vector<int> begins_;       ///< of the slabs, and the last one's end
  std::vector<std::unique_ptr<Boundary>> boundaries_;  ///< n: under slab n + 1
  std::vector<AlignedVector<Real>> few_forces_;  ///< of two layers, for each slab
  std::vector<unsigned char> stands_;  ///< of each layer: some row does
  std::vector<double> sums_;
  long round_ = 0;
  std::unique_ptr<Team> team_;  ///< last, so that it goes home first
};

}  // namespace palpate

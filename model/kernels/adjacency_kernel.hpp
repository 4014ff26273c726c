// SPDX-License-Identifier: MIT
#pragma once
/// Kernels of adjacency groups. One source file per instruction set includes this header; `Arch`
/// gives each instantiation its own functions.

#include <bit>
#include <type_traits>
#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"

namespace palpate::adjacency {

/// Padded 4-vectors in one register, or in two if registers are short. Uses the compiler's vector
/// types, because xsimd has no batch of four doubles for SSE.
template <class Real, class Arch> struct PaddedVectors {
  static constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
  using Batch = xsimd::batch<Real, Arch>;
  typedef Real Padded __attribute__((vector_size(node_stride * sizeof(Real))));
  template <long size> struct Row {
    typedef Real Type __attribute__((vector_size(size * sizeof(Real))));
  };

  static Padded load(const Real* from) noexcept {
    Padded to;
    __builtin_memcpy(&to, from, sizeof to);
    return to;
  }
  static Padded three(const Real* from) noexcept {
    return Padded{from[0], from[1], from[2], Real(0)};
  }
  static void store(const Padded& from, Real* to) noexcept {
    __builtin_memcpy(to, &from, sizeof from);
  }
  static Padded all(Real number) noexcept { return Padded{number, number, number, number}; }
  /// a b + c, with a single rounding if the processor supports it.
  static Padded add(const Padded& a, const Padded& b, const Padded& c) noexcept {
#if defined(__FMA__)
    if constexpr (std::is_same_v<Real, double>) {
      return Padded(_mm256_fmadd_pd(__m256d(a), __m256d(b), __m256d(c)));
    }
    if constexpr (std::is_same_v<Real, float>) {
      return Padded(_mm_fmadd_ps(__m128(a), __m128(b), __m128(c)));
    }
#endif
    return c + a * b;
  }

  /// Returns the sum of the four numbers of each of `lanes` vectors.
  static Batch sums(const Padded* padded) noexcept {
    return Batch(std::bit_cast<typename Batch::register_type>(row<lanes>(padded)));
  }

 private:
  template <long size> static typename Row<size>::Type row(const Padded* padded) noexcept {
    if constexpr (size == 2) {
      const Padded both = halves(padded[0], padded[1]);
      return __builtin_shufflevector(both, both, 0, 1) + __builtin_shufflevector(both, both, 2, 3);
    } else if constexpr (sizeof(Padded) == 16) {
      return neighbours(neighbours(padded[0], padded[1]), neighbours(padded[2], padded[3]));
    } else {
      const Padded first = halves(padded[0], padded[1]);
      const Padded second = halves(padded[2], padded[3]);
      return __builtin_shufflevector(first, second, 0, 1, 6, 7) +
             __builtin_shufflevector(first, second, 2, 3, 4, 5);
    }
  }
  /// (a0 + a1, a2 + a3, b0 + b1, b2 + b3)
  static Padded neighbours(const Padded& a, const Padded& b) noexcept {
    return __builtin_shufflevector(a, b, 0, 2, 4, 6) + __builtin_shufflevector(a, b, 1, 3, 5, 7);
  }
  /// (a0 + a1, b1 + b0, a2 + a3, b3 + b2), without moving data between the halves of a long
  /// register.
  static Padded halves(const Padded& a, const Padded& b) noexcept {
    return __builtin_shufflevector(a, b, 0, 5, 2, 7) + __builtin_shufflevector(a, b, 1, 4, 3, 6);
  }
};

/// Terms that a loop over adjacency groups computes.
struct Terms {
  bool damped = false;
  bool measured = false;      ///< the elastic energy as well
  bool law = false;           ///< stiffening and relaxation
  bool tension_only = false;  ///< elastic tensions and no forces
};

/// Loop over the springs of adjacency groups.
template <Terms terms, class Real, class Arch> class GroupLoop {
 public:
  static constexpr bool is_damped = terms.damped;
  static constexpr bool is_measured = terms.measured;
  using Four = PaddedVectors<Real, Arch>;
  using Padded = typename Four::Padded;
  using Batch = xsimd::batch<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);

  GroupLoop(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept
      : q_(q),
        v_(v),
        f_(f),
        partners_(view.partners),
        numbers_(view.numbers),
        share_(view.share),
        held_(view.held),
        tension_(view.tension),
        stiffening_(view.stiffening) {}

  void pass(const Group& group) noexcept {
    place_ = Four::load(q_ + group.node);
    if constexpr (is_damped) { velocity_ = Four::load(v_ + group.node); }
    Padded force{};
    for (int n = 0; n < group.batches; ++n) { force = add_batch(force); }
    if constexpr (terms.tension_only) { return; }
    Four::store(Four::load(f_ + group.node) + force, f_ + group.node);
  }
  [[nodiscard]] double energy() const noexcept {
    if constexpr (!is_measured) { return 0.0; }
    return 0.5 * static_cast<double>(xsimd::hadd(energy_));
  }

 private:
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  /// Returns tension divided by length of springs with the given squared length; `closing` is the
  /// elongation rate times the length.
  Batch pull(const Batch& square, const Padded* closing) noexcept {
    const SpringLengths<Real, Arch> lengths(square + Batch(least_square<Real>));
    const SpringNumbers<Batch> spring{
        .stiffness = load(numbers_),
        .rest = load(numbers_ + lanes),
        .viscosity = is_damped ? load(numbers_ + 2 * lanes) : Batch(Real(0))};
    if constexpr (terms.law) { return pull_of_law(spring, square, closing); }
    if constexpr (is_measured) {
      energy_ = add_twice_energy(spring, Batch(lengths.length()), energy_);
    }
    if constexpr (is_damped) { return lengths.pull(spring, Four::sums(closing)); }
    return lengths.pull(spring);
  }
  /// Returns the same for springs that stiffen or relax. Only tensions are needed if the loop
  /// computes no forces.
  Batch pull_of_law(const SpringNumbers<Batch>& spring, const Batch& square,
                    const Padded* closing) noexcept {
    const Batch length = xsimd::sqrt(square + Batch(least_square<Real>));
    Batch extension = length - spring.rest;
    if (!stiffening_.linear) {
      extension = spring.rest * stretched(stiffening_, Batch(extension / spring.rest)).value;
    }
    const Batch elastic = spring.stiffness * extension;
    if constexpr (terms.tension_only) {
      elastic.store_unaligned(tension_);
      tension_ += lanes;
      return elastic;
    } else {
      const Batch inverse = Batch(Real(1)) / length;
      const Batch viscous = spring.viscosity * (Four::sums(closing) * inverse);
      const Batch tension = load(share_) * elastic - load(held_) + viscous;
      share_ += lanes;
      held_ += lanes;
      return tension * inverse;
    }
  }
  /// Prefetches constants and partners: hardware prefetchers are too slow for this stream. Always
  /// inline, because g++ 12 removes a call that only prefetches.
  PALPATE_ALWAYS_INLINE inline void fetch_ahead() noexcept {
    constexpr long length = batch_numbers(is_damped) * lanes;
    for (long n = 0; n < length; n += 64 / static_cast<long>(sizeof(Real))) {
      __builtin_prefetch(numbers_ + batches_ahead * length + n);
    }
    __builtin_prefetch(partners_ + batches_ahead * lanes);
  }
  /// Adds the forces of a batch to the other ends and returns the new force on the node. d and its
  /// rate point from the other ends to the node.
  Padded add_batch(Padded force) noexcept {
    fetch_ahead();
    long far[lanes];
    Padded d[lanes];
    Padded squares[lanes];
    Padded closing[lanes];
    for (long n = 0; n < lanes; ++n) {
      far[n] = partners_[n];
      d[n] = place_ - Four::load(q_ + far[n]);
      squares[n] = d[n] * d[n];
      if constexpr (is_damped) { closing[n] = (velocity_ - Four::load(v_ + far[n])) * d[n]; }
    }
    if constexpr (terms.tension_only) {
      (void)pull(Four::sums(squares), closing);
      partners_ += lanes;
      numbers_ += batch_numbers(true) * lanes;
      return force;
    }
    Real factor[lanes];
    pull(Four::sums(squares), closing).store_unaligned(factor);
    for (long n = 0; n < lanes; ++n) {
      const Padded all = Four::all(factor[n]);
      force = Four::add(-all, d[n], force);
      Four::store(Four::add(all, d[n], Four::load(f_ + far[n])), f_ + far[n]);
    }
    partners_ += lanes;
    numbers_ += batch_numbers(is_damped) * lanes;
    return force;
  }

  const Real* q_;
  const Real* v_;
  Real* f_;
  const int* partners_;
  const Real* numbers_;
  const Real* share_;
  const Real* held_;
  Real* tension_;
  StiffeningNumbers<Real> stiffening_;
  Padded place_{};
  Padded velocity_{};
  Batch energy_ = Batch(Real(0));
};

template <Terms terms, class Real, class Arch>
double pass_all(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  GroupLoop<terms, Real, Arch> loop(view, q, v, f);
  for (long n = 0; n < view.count; ++n) { loop.pass(view.groups[n]); }
  return loop.energy();
}
template <class Real, class Arch>
void spread(const Real* packed, long nodes, Real* padded) noexcept {
  using Four = PaddedVectors<Real, Arch>;
  for (long n = 0; n < nodes; ++n) {
    Four::store(Four::three(packed + 3 * n), padded + node_stride * n);
  }
}
template <class Real, class Arch>
void collect(const Real* padded, long nodes, Real* packed) noexcept {
  for (long n = 0; n < nodes; ++n) {
    for (long c = 0; c < 3; ++c) { packed[3 * n + c] += padded[node_stride * n + c]; }
  }
}
template <class Real, class Arch> double advance(const Move<Real>& move, long nodes) noexcept {
  using Four = PaddedVectors<Real, Arch>;
  using Padded = typename Four::Padded;
  const Padded h = Four::all(move.h);
  const auto step = [&](long node, Padded& squares) {
    const long n = node_stride * node;
    const Padded v =
        Four::load(move.v + n) + h * (Four::load(move.f + n) * Four::load(move.inverse_mass + n));
    Four::store(v, move.v + n);
    Four::store(Four::load(move.q + n) + h * v, move.q + n);
    Four::store(move.weight != nullptr ? Four::load(move.weight + n) : Padded{}, move.f + n);
    squares = Four::add(v, v, squares);
  };
  constexpr long sums = 4;  // independent partial sums
  Padded squares[sums] = {};
  long node = 0;
  for (; node + sums <= nodes; node += sums) {
    for (long n = 0; n < sums; ++n) { step(node + n, squares[n]); }
  }
  for (; node < nodes; ++node) { step(node, squares[0]); }
  const Padded all = (squares[0] + squares[1]) + (squares[2] + squares[3]);
  return (static_cast<double>(all[0]) + static_cast<double>(all[1])) +
         (static_cast<double>(all[2]) + static_cast<double>(all[3]));
}

template <class Real, class Arch> Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .damped = &pass_all<Terms{.damped = true}, Real, Arch>,
          .damped_measured = &pass_all<Terms{.damped = true, .measured = true}, Real, Arch>,
          .undamped = &pass_all<Terms{}, Real, Arch>,
          .undamped_measured = &pass_all<Terms{.measured = true}, Real, Arch>,
          .of_law = &pass_all<Terms{.damped = true, .law = true}, Real, Arch>,
          .tension_of_law = &pass_all<Terms{.law = true, .tension_only = true}, Real, Arch>,
          .spread = &spread<Real, Arch>,
          .collect = &collect<Real, Arch>,
          .advance = &advance<Real, Arch>};
}

}  // namespace palpate::adjacency

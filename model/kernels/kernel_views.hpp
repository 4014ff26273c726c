// SPDX-License-Identifier: MIT
#pragma once
/// Data that the kernels read and write, and tables of kernels for each instruction set.

namespace palpate::lattice {

/// Rows of nodes lead along one axis. Springs join a row to itself and to rows one further along
/// the two other axes: (1,0), (-1,1), (0,1), (1,1); all other neighbours see it from the other end.
inline constexpr int neighbour_kinds = 4;
inline constexpr int neighbour_steps[neighbour_kinds][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
/// Springs of a node to such rows: one within its own row, three (left, across, right) to each
/// other row.
inline constexpr int slots = 1 + 3 * neighbour_kinds;

/// Neighbouring row that receives spring forces from this row. Each pair of rows appears once.
template <class Real> struct Link {
  int layers = 0;     ///< further on: 0 or 1
  int rows = 0;       ///< further on, with those of the layers
  long elements = 0;  ///< further on in its layer
  long constants =
      0;  ///< of springs to the left, from where those straight across and to the right follow
  Real rest_across = Real(0);  ///< length [m] of springs straight across
  Real rest_aside = Real(0);   ///< and of those to the left and to the right
  bool sides = false;          ///< there are such
};

template <class Real> struct Links {
  int count = 0;
  int within = 0;  ///< of them, in the row's own layer; the first ones
  Link<Real> to[neighbour_kinds];
};

/// A row of n nodes is divided into as many segments as there are lanes. Vector i holds the i-th
/// node of every segment: x of all, then y, then z. Neighbours along the row are then neighbouring
/// vectors, and no operation crosses lanes. Short rows are interleaved: several rows share the
/// lanes, each divided into fewer segments.
template <class Real> struct View {
  int rows1 = 0;                    ///< rows along the second axis
  int rows2 = 0;                    ///< and along the third
  long vectors = 0;                 ///< of a row
  long row_length = 0;              ///< elements
  long layer_length = 0;            ///< likewise, of rows1 rows
  bool folded = false;              ///< a layer's last row leads to its first
  long lead = 0;                    ///< elements before the first row
  long lanes = 1;                   ///< from x to y, and from y to z
  long numbers = 2;                 ///< of a spring: stiffness, and viscosity where there is any
  const Real* tables = nullptr;     ///< [vector][slot][number][lane] of a row, as they are read
  const long* row_table = nullptr;  ///< where a row's begins; equal rows share theirs
  const unsigned char* row_moves = nullptr;  ///< 0: no node of a row is free, or all sleep
  Real own_rest = Real(0);                   ///< length [m] of springs within a row
  bool own_springs = false;                  ///< some row has springs within it
  Links<Real> links[3];  ///< of a layer's first row, of those between, and of the last
};

/// Vectors of nodes that follow each other in memory.
template <class Real> struct Nodes {
  const Real* q = nullptr;
  const Real* v = nullptr;
  Real* f = nullptr;
};

/// Layers [begin, end) of a lattice that one thread visits. A layer is all rows at one position
/// along the third axis.
template <class Real> struct Slab {
  int begin = 0;
  int end = 0;
  const Nodes<Real>* beyond = nullptr;  ///< copy of layer `end`, which another thread moves
  /// Copy of layer `begin`, which another thread moves. Only the forces of its springs on layer
  /// `end` are used.
  const Nodes<Real>* below = nullptr;
};

/// State that a step changes, see Task::step.
template <class Real> struct Move {
  Real* q = nullptr;                   ///< as in Fields, [m]
  Real* v = nullptr;                   ///< [m/s]
  const Real* inverse_mass = nullptr;  ///< [1/kg]; only that of x is read
  Real h = Real(0);                    ///< [s]
};

/// What a task does not need may be null. Forces of a step may be kept for the layers alone whose
/// springs are gone through: then layer n is where layer n + force_layers will be.
template <class Real> struct Fields {
  const Real* q = nullptr;
  const Real* v = nullptr;
  Real* f = nullptr;
  const Move<Real>* move = nullptr;
  int force_layers = 0;  ///< 0: all
};

/// Adds forces to f, or -C v. Returns the elastic energy [J] if the task measures it, or the sum of
/// squares of the new velocities if it takes a step.
template <class Real>
using Kernel = double (*)(const View<Real>& view, const Slab<Real>& slab,
                          const Fields<Real>& fields) noexcept;

/// Data that a kernel prefetches: nothing, rows of nodes, or these and the constants of their
/// springs. It does not change results and helps where the data exceed the caches.
enum class Fetch { nothing, rows, rows_and_constants };

/// One for each Fetch.
template <class Real> struct FetchingKernels {
  Kernel<Real> kernels[3]{};
  [[nodiscard]] Kernel<Real> at(Fetch fetch) const noexcept {
    return kernels[static_cast<int>(fetch)];
  }
};

template <class Real> struct Kernels {
  const char* name = "";
  int lanes = 1;
  FetchingKernels<Real> force{};
  FetchingKernels<Real> undamped_force{};
  Kernel<Real> measured_force = nullptr;
  Kernel<Real> measured_undamped_force = nullptr;
  FetchingKernels<Real> step{};
  FetchingKernels<Real> undamped_step{};
  Kernel<Real> damping = nullptr;
  Kernel<Real> energy = nullptr;
  /// to = 1 / sqrt(from), the least work for the length of a spring. `count` is a multiple of 64.
  void (*roots_and_quotients)(const Real* from, Real* to, long count) noexcept = nullptr;
};

template <class Real> Kernels<Real> baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA.
template <class Real> Kernels<Real> avx2_kernels() noexcept;
/// Only where the processor has AVX-512.
template <class Real> Kernels<Real> avx512_kernels() noexcept;

}  // namespace palpate::lattice

namespace palpate::adjacency {

// Springs grouped by nodes.

/// Adjacency group: springs that one free node computes, in batches of as many as there are lanes.
/// Springs without stiffness from the node to itself fill the last batch.
struct Group {
  int node = 0;  ///< first coordinate of the node
  int batches = 0;
};

/// Numbers of a node in a padded vector: x, y, z and a zero, which fill a register together.
inline constexpr int node_stride = 4;
/// Constants of a batch, one vector after the other: stiffness, rest length and viscosity.
inline constexpr int batch_numbers(bool damped) { return damped ? 3 : 2; }
/// Distance, in batches, at which constants and partners are prefetched; as many unused batches
/// follow the last one.
inline constexpr int batches_ahead = 24;

template <class Real> struct View {
  const Group* groups = nullptr;
  long count = 0;
  const int* partners = nullptr;  ///< first coordinates of the other ends, by batches
  const Real* numbers = nullptr;  ///< constants of the springs, by batches
};

/// Adds the forces of springs, and of dampers if there are any, to f. Vectors have four numbers for
/// each node, and for each place that never moves, on which forces are written too. Those that
/// measure do the same to the same bits and return the springs' energy [J], the others 0.
template <class Real>
using Force = double (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;
/// PaddedVectors of nodes from vectors with three numbers each.
template <class Real>
using Spread = void (*)(const Real* packed, long nodes, Real* padded) noexcept;
/// Adds padded vectors to a vector with three numbers for each node.
template <class Real>
using Collect = void (*)(const Real* padded, long nodes, Real* packed) noexcept;

/// A step of semi-implicit Euler with forces that are known, to the bits of one sweep after
/// another. All have four numbers for each node.
template <class Real> struct Move {
  Real* q = nullptr;
  Real* v = nullptr;
  Real* f = nullptr;  ///< becomes the weight
  const Real* inverse_mass = nullptr;
  const Real* weight = nullptr;  ///< or zero without
  Real h = Real(0);              ///< [s]
};
/// Returns the sum of squares of the new velocities.
template <class Real> using Advance = double (*)(const Move<Real>& move, long nodes) noexcept;

template <class Real> struct Kernels {
  const char* name = "";
  int lanes = 1;
  Force<Real> damped = nullptr;
  Force<Real> damped_measured = nullptr;
  Force<Real> undamped = nullptr;
  Force<Real> undamped_measured = nullptr;
  Spread<Real> spread = nullptr;
  Collect<Real> collect = nullptr;
  Advance<Real> advance = nullptr;
};

template <class Real> Kernels<Real> baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA. Longer registers are not faster.
template <class Real> Kernels<Real> avx2_kernels() noexcept;

}  // namespace palpate::adjacency

namespace palpate::supernodes {

// What the kernels of a triangular solve in supernodes see, and the kernels that this machine can
// run (model/EQUATIONS.md, "Panels of a factorisation").

/// Columns that a block of rows has at most side by side: their sums stay in registers.
inline constexpr int tile = 8;

/// Columns [first, first + width) and the rows that they touch, their own first. Stored is not L
/// but what solves with it: the inverse of its own square, and the rows below times that inverse.
/// Tiles of columns one after the other, each in blocks of as many rows as there are lanes, each
/// block by columns.
struct Supernode {
  int first = 0;
  int width = 0;
  int blocks = 0;   ///< of rows
  int below = 0;    ///< rows below its own
  long rows = 0;    ///< where those begin in View::rows
  long values = 0;  ///< where the first tile begins in View::values
};

struct View {
  const Supernode* supernodes = nullptr;
  long count = 0;
  const int* rows = nullptr;
  const float* values = nullptr;
  const float* inverse_pivots = nullptr;
  long size = 0;  ///< of the whole matrix
};

struct Kernels {
  const char* name = "";
  int lanes = 1;
  /// y = (L D L^T)^-1 y. `work` has a place for every row of the highest supernode, in whole
  /// blocks.
  void (*solve)(const View& view, float* y, float* work) noexcept = nullptr;
};

Kernels baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA.
Kernels avx2_kernels() noexcept;
/// Only where the processor has AVX-512.
Kernels avx512_kernels() noexcept;

}  // namespace palpate::supernodes

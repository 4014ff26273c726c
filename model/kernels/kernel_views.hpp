// SPDX-License-Identifier: MIT
#pragma once
/// Data that the kernels read and write, and tables of kernels for each instruction set.

#include "model/problem/material_law.hpp"

namespace palpate::lattice {

/// Offsets to the neighbouring rows with which a row stores its springs, along the second and third
/// axis. Rows of nodes run along the first axis.
inline constexpr int neighbour_kinds = 4;
inline constexpr int neighbour_steps[neighbour_kinds][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
/// Springs of a node in the tables: one in its own row, three to each neighbouring row.
inline constexpr int slots = 1 + 3 * neighbour_kinds;

/// Neighbouring row that receives spring forces from this row. Each pair of rows appears once.
template <class Real> struct Link {
  int layers = 0;              ///< offset: 0 or 1
  int rows = 0;                ///< offset, including that of the layers
  long elements = 0;           ///< offset within the layer
  long constants = 0;          ///< first slot, of the springs to the left; across and right follow
  Real rest_across = Real(0);  ///< rest length of springs straight across [m]
  Real rest_aside = Real(0);   ///< rest length of springs to the left and to the right [m]
  bool sides = false;          ///< springs to the left and right exist
};

template <class Real> struct Links {
  int count = 0;
  int within = 0;  ///< number of links in the row's own layer, which come first
  Link<Real> to[neighbour_kinds];
};

/// A row of n nodes is divided into as many segments as there are lanes. Vector i holds the i-th
/// node of every segment: x of all, then y, then z. Neighbours along the row are then neighbouring
/// vectors, and no operation crosses lanes. Short rows are interleaved: several rows share the
/// lanes, each divided into fewer segments.
template <class Real> struct View {
  int rows1 = 0;          ///< number of rows along the second axis
  int rows2 = 0;          ///< number of rows along the third axis
  long vectors = 0;       ///< vectors per row
  long row_length = 0;    ///< in elements
  long layer_length = 0;  ///< of rows1 rows, in elements
  bool folded = false;    ///< the last row of a layer is connected to its first
  long lead = 0;          ///< elements before the first row
  long lanes = 1;         ///< offset from x to y and from y to z
  long numbers = 2;       ///< constants per spring: stiffness, and viscosity if there are dampers
  const Real* tables = nullptr;     ///< [vector][slot][number][lane] of a row, in reading order
  const long* row_table = nullptr;  ///< first element of each row's table; equal rows share a table
  const unsigned char* row_moves = nullptr;  ///< 0: all nodes of the row are fixed or asleep
  Real own_rest = Real(0);                   ///< rest length of springs within a row [m]
  bool own_springs = false;                  ///< at least one row has springs within it
  Links<Real> links[3];  ///< of a layer's first row, of the rows between, and of the last row
};

/// Consecutive vectors of nodes in memory.
template <class Real> struct Nodes {
  const Real* q = nullptr;
  const Real* v = nullptr;
  Real* f = nullptr;
};

/// Layers [begin, end) that one thread computes; a layer is all rows at one third coordinate.
template <class Real> struct Slab {
  int begin = 0;
  int end = 0;
  const Nodes<Real>* beyond = nullptr;  ///< copy of layer `end`, which belongs to another thread
  /// Copy of layer `begin` of another thread; only the forces of its springs on layer `end` count.
  const Nodes<Real>* below = nullptr;
};

/// State that a step changes; see Task::step.
template <class Real> struct Move {
  Real* q = nullptr;                   ///< as in Fields, [m]
  Real* v = nullptr;                   ///< [m/s]
  const Real* inverse_mass = nullptr;  ///< only the entry of x is read [1/kg]
  const Real* weight = nullptr;        ///< force after the step [N]; null for zero
  Real h = Real(0);                    ///< [s]
};

/// Arrays of a kernel; arrays that a task does not use may be null.
template <class Real> struct Fields {
  const Real* q = nullptr;
  const Real* v = nullptr;
  Real* f = nullptr;
  const Move<Real>* move = nullptr;
};

/// Adds the forces of a slab's springs, or -C v, to f. Returns the elastic energy [J] if the task
/// measures it, or the sum of squares of the new velocities if it takes a step.
template <class Real>
using Kernel = double (*)(const View<Real>& view, const Slab<Real>& slab,
                          const Fields<Real>& fields) noexcept;

/// Data that a kernel prefetches, which helps if they exceed the caches.
enum class Fetch { nothing, rows, rows_and_constants };

/// One kernel for each Fetch.
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
  /// Computes to = 1 / sqrt(from), the minimum work for a spring; `count` is a multiple of 64.
  void (*roots_and_quotients)(const Real* from, Real* to, long count) noexcept = nullptr;
};

}  // namespace palpate::lattice

namespace palpate::adjacency {

/// Springs that one free node computes, in batches of one spring per lane. Springs of zero
/// stiffness from the node to itself fill the last batch.
struct Group {
  int node = 0;  ///< first coordinate of the node
  int batches = 0;
};

/// Length of a padded 4-vector: x, y, z and a zero.
inline constexpr int node_stride = 4;
/// Number of constant vectors per batch: stiffness, rest length and, with dampers, viscosity.
inline constexpr int batch_numbers(bool damped) { return damped ? 3 : 2; }
/// Prefetch distance in batches. The arrays have this many unused batches at the end.
inline constexpr int batches_ahead = 24;

template <class Real> struct View {
  const Group* groups = nullptr;
  long count = 0;
  const int* partners = nullptr;  ///< first coordinates of the other ends, per batch
  const Real* numbers = nullptr;  ///< constants of the springs, per batch
  // For springs of one material law only:
  StiffeningNumbers<Real> stiffening{};
  const Real* share = nullptr;  ///< of the elastic tension that acts, per batch; see Relaxed
  const Real* held = nullptr;   ///< per batch [N]
  Real* tension = nullptr;      ///< elastic tension without relaxation, per batch [N]
};

/// Adds the forces of springs and dampers to f. Vectors hold padded 4-vectors of the free nodes and
/// the fixed points. Measuring kernels also return the elastic energy [J]; the others return 0.
template <class Real>
using Force = double (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;
/// Converts vectors with three numbers per node to padded 4-vectors.
template <class Real>
using Spread = void (*)(const Real* packed, long nodes, Real* padded) noexcept;
/// Adds padded 4-vectors to a vector with three numbers per node.
template <class Real>
using Collect = void (*)(const Real* padded, long nodes, Real* packed) noexcept;

/// Semi-implicit Euler step with known forces of padded vectors.
template <class Real> struct Move {
  Real* q = nullptr;
  Real* v = nullptr;
  Real* f = nullptr;  ///< on return, equal to `weight`
  const Real* inverse_mass = nullptr;
  const Real* weight = nullptr;  ///< weight; null for zero
  Real h = Real(0);              ///< [s]
};
/// Advances the state and returns the sum of squares of the new velocities.
template <class Real> using Advance = double (*)(const Move<Real>& move, long nodes) noexcept;

template <class Real> struct Kernels {
  const char* name = "";
  int lanes = 1;
  Force<Real> damped = nullptr;
  Force<Real> damped_measured = nullptr;
  Force<Real> undamped = nullptr;
  Force<Real> undamped_measured = nullptr;
  Force<Real> of_law = nullptr;          ///< springs and dampers of a material law
  Force<Real> tension_of_law = nullptr;  ///< writes View::tension only
  Spread<Real> spread = nullptr;
  Collect<Real> collect = nullptr;
  Advance<Real> advance = nullptr;
};

}  // namespace palpate::adjacency

namespace palpate::supernodes {

/// Maximum number of columns of a tile, so that the sums stay in registers.
inline constexpr int tile = 8;

/// Supernode: columns [first, first + width) with the rows that they touch, its own rows first. The
/// stored values are the inverse of the diagonal block, and the rows below multiplied by that
/// inverse. Tiles of columns are consecutive; a tile consists of blocks with one row per lane,
/// stored by columns.
struct Supernode {
  int first = 0;
  int width = 0;
  int blocks = 0;   ///< number of row blocks
  int below = 0;    ///< number of rows below the diagonal block
  long rows = 0;    ///< index of these rows in View::rows
  long values = 0;  ///< index of the first tile in View::values
};

struct View {
  const Supernode* supernodes = nullptr;
  long count = 0;
  const int* rows = nullptr;
  const float* values = nullptr;
  const float* inverse_pivots = nullptr;
  long size = 0;  ///< order of the matrix
};

struct Kernels {
  const char* name = "";
  int lanes = 1;
  /// Solves y = (L D L^T)^-1 y in place. `work` has one element for each row of the largest
  /// supernode, rounded up to whole blocks.
  void (*solve)(const View& view, float* y, float* work) noexcept = nullptr;
};

}  // namespace palpate::supernodes

namespace palpate::cells {

/// Cells in batches of one per lane.
template <class Real> struct View {
  long batches = 0;
  const int* first = nullptr;     ///< [batch][corner][lane]: index of x; -1 - n: place n of `fixed`
  const Real* numbers = nullptr;  ///< [batch][4][lane], as in CellNumbers
  const Real* fixed = nullptr;    ///< positions of fixed nodes [m]
  /// [batch][lane], for relaxing kernels: what acts of kappa (J - 1); see Relaxed.
  const Real* share = nullptr;
  const Real* held = nullptr;  ///< [Pa]
};
/// Adds the forces of all cells to f.
template <class Real>
using Force = void (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;
template <class Real> struct Kernels {
  int lanes = 0;
  Force<Real> damped = nullptr;
  Force<Real> undamped = nullptr;
  Force<Real> relaxing = nullptr;  ///< with damping
};

}  // namespace palpate::cells

namespace palpate {

/// Kernels of one instruction set; a kernel without lanes does not exist for it.
struct KernelSet {
  lattice::Kernels<double> lattice_double{};
  lattice::Kernels<float> lattice_float{};
  adjacency::Kernels<double> adjacency_double{.lanes = 0};
  adjacency::Kernels<float> adjacency_float{.lanes = 0};
  supernodes::Kernels supernodes{};
  cells::Kernels<double> cells_double{};
  cells::Kernels<float> cells_float{};
};

KernelSet baseline_kernels() noexcept;
/// Kernels for processors with AVX2 and FMA; must not be called on others.
KernelSet avx2_kernels() noexcept;
/// Kernels for processors with AVX-512; must not be called on others. Adjacency groups are not
/// faster with it.
KernelSet avx512_kernels() noexcept;

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice in SIMD lanes, on one thread or several.

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/lattice_springs.hpp"
#include "model/kernels/network_system.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// Signals a spin loop to the processor.
inline void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Team of threads that run one task together for a few microseconds at a time. Members wait in
/// spin loops, so that a tick neither locks nor makes a system call.
class Team {
 public:
  /// Starts the threads. `members` includes the caller, which is number 0.
  explicit Team(int members);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int members() const { return static_cast<int>(threads_.size()) + 1; }

  /// Runs work(number) once on every member and returns when all have finished.
  template <class Work> void run(Work& work) noexcept {
    work_ = &work;
    call_ = [](void* what, int number) noexcept { (*static_cast<Work*>(what))(number); };
    run_call();
  }

 private:
  void run_call() noexcept;
  void serve(int number) noexcept;

  void* work_ = nullptr;
  void (*call_)(void* work, int number) noexcept = nullptr;
  std::atomic<long> round_{0};     ///< number of tasks so far; negative: threads end
  std::atomic<long> finished_{0};  ///< completed by members other than the caller, over all rounds
  std::vector<std::thread> threads_;
};

/// Partition of a lattice among threads by layers. Results are bitwise identical to those of one
/// thread (model/EQUATIONS.md, "Lattice in lanes").
template <class Real> class LatticeSlabs {
 public:
  /// Partitions the lattice. Uses fewer than `threads` threads if there are fewer than two layers
  /// for each.
  LatticeSlabs(const lattice::View<Real>& view, int threads);

  /// Returns the largest useful number of threads, at most `wanted`. Rows of one vector are not
  /// partitioned, because vectors at the ends of such a row access rows of other layers.
  [[nodiscard]] static int most_threads(int layers, long vectors, int wanted);

  /// Applies the kernel to the whole lattice and returns the sum of its results.
  double sweep(lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields) noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  /// Boundary between two slabs: copies of both layers before either moves, and memory for the
  /// forces on them that the thread of the other slab computes for itself.
  struct Boundary {
    AlignedVector<Real> below;
    AlignedVector<Real> above;
    std::atomic<long> copied{0};  ///< round
  };
  /// Returns q, v and f of a layer that are stored in one vector.
  [[nodiscard]] lattice::Nodes<Real> layer_in(AlignedVector<Real>& numbers) const noexcept;
  void copy(const lattice::Fields<Real>& fields, int layer, AlignedVector<Real>& to) const noexcept;
  double sweep_slab(std::size_t number, lattice::Kernel<Real> kernel,
                    const lattice::Fields<Real>& fields) noexcept;

  lattice::View<Real> view_;
  long layer_length_;  ///< in elements
  long copy_length_;   ///< length of the copy of q, including elements that the outermost lanes
                       ///< access on both sides
  std::vector<int> begins_;  ///< first layer of each slab, then the number of layers
  std::vector<std::unique_ptr<Boundary>> boundaries_;  ///< entry n is below slab n + 1
  std::vector<double> sums_;
  long round_ = 0;
  std::unique_ptr<Team>
      team_;  ///< last member, so that the threads end before the data are destroyed
};

// Rows of a lattice at rest, which are not integrated until a sufficient force acts on them
// (model/EQUATIONS.md, "Sleeping rows").

template <class Real> class LatticeSleep {
 public:
  /// Prepares the rows of the whole lattice `view`; a row of `row_length` elements moves or is
  /// fixed as a whole. `awake` is 1 for rows that are integrated from the start. `most_withheld`
  /// limits the sum of all forces on sleeping nodes [N].
  LatticeSleep(const lattice::View<Real>& view, std::vector<unsigned char> awake,
               double most_withheld);

  /// Returns 1 for each row that is integrated. The pointer stays valid, so that a View can keep
  /// it.
  [[nodiscard]] const unsigned char* awake() const noexcept { return awake_.data(); }
  /// Returns the fraction of the movable rows that are awake.
  [[nodiscard]] double awake_share() const noexcept {
    return static_cast<double>(awake_count_) / static_cast<double>(able_count_);
  }

  /// Wakes rows with too large forces in f [N] and withholds the forces on the other sleeping rows.
  /// Call it after forces were added to f.
  void wake_pulled(Real* f, const Real* inverse_mass) noexcept;
  /// Wakes rows after a step (lattice::Task::step) and moves them by that step. Returns the sum of
  /// squares of their velocities.
  double wake_in_step(const lattice::Fields<Real>& fields) noexcept;
  /// Removes the forces on sleeping rows from f.
  void withhold(Real* f) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  enum class Row : unsigned char { fixed, asleep, border, awake };

  [[nodiscard]] long begin_of(int row) const noexcept { return lead_ + row * row_length_; }
  /// Calls visit(index of x) for each node of a row.
  template <class Visit> void visit_nodes(int row, Visit visit) const noexcept;
  void clear(Real* f, int row) const noexcept;
  [[nodiscard]] double pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept;
  void wake(std::size_t place_in_border) noexcept;
  void watch_around(int row) noexcept;
  /// Calls visit(row) for each row that wakes, and removes the forces on the other rows at the
  /// border.
  template <class Visit> void judge_border(Real* f, const Real* inverse_mass, Visit visit) noexcept;

  int rows1_;
  int rows2_;
  long lead_;
  long row_length_;
  long lanes_;
  double most_withheld_;
  std::vector<Row> state_;
  std::vector<unsigned char> awake_;
  std::vector<int> border_;  ///< sleeping rows next to an awake row
  long awake_count_ = 0;
  long able_count_ = 0;
};

// Regular lattice for explicit schemes: no index arrays, one pass over memory, explicit SIMD
// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and padding elements have zero inverse mass
// and never move.

template <class Real> class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  /// Builds the lattice. Throws std::invalid_argument if the network is not a regular lattice.
  /// `may_fold`: see LatticeRows.
  LatticeNetwork(const NetworkProblem& problem, bool skip, int threads = 1,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(),
                 bool may_fold = true);

  /// Enables sleeping rows. Rows without initial displacement, velocity or load sleep, except the
  /// rows of `touched` nodes. Requires one thread, no weight and no folded
  /// rows.
  void let_sleep(double most_withheld, std::span<const int> touched = {});
  [[nodiscard]] double awake_share() const noexcept override {
    return sleep_ ? sleep_->awake_share() : 1.0;
  }

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  [[nodiscard]] bool has_one_pass() const override { return true; }
  void prepare_one_pass() override;
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override;
  [[nodiscard]] Vector<Real> initial_position() const override {
    return springs_.initial_position();
  }

 private:
  LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                 const lattice::Kernels<Real>& kernels, bool skip, int threads);
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;

  LatticeSprings<Real> springs_;
  bool damped_;
  lattice::Kernels<Real> kernels_;
  lattice::Kernel<Real> force_ = nullptr;
  lattice::Kernel<Real> step_ = nullptr;
  std::optional<LatticeSleep<Real>> sleep_;  ///< only if rows may sleep
  std::unique_ptr<LatticeSlabs<Real>> slabs_;
  /// Force between two one-pass steps: the weight, and the withheld forces of sleeping rows [N].
  Vector<Real> next_force_;
};

}  // namespace palpate

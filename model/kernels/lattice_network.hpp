// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice in lanes, on one thread or several.

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

/// Tells the processor that the thread is in a spin loop.
inline void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Threads that run one task together, a few microseconds at a time. They wait in spin loops, so
/// that a tick neither locks nor calls the system.
class Team {
 public:
  /// `members` includes the caller, who is number 0.
  explicit Team(int members);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int members() const { return static_cast<int>(threads_.size()) + 1; }

  /// Every member calls work(number) once; returns when all have finished.
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
  std::atomic<long> finished_{0};  ///< by members other than the caller, of all rounds
  std::vector<std::thread> threads_;
};

/// Load on one node of a layer.
template <class Real> struct Pull {
  long element = 0;  ///< of the node's x, after the layer's first
  Real force[3]{};   ///< [N]
};

/// Forces on nodes other than those of springs.
template <class Real> struct Outside {
  const Real* weight = nullptr;       ///< of all coordinates [N]; null: none
  const Pull<Real>* pulls = nullptr;  ///< by layers
  const int* pulls_begin = nullptr;   ///< of each layer, and the last one's end
};

/// Partition of a lattice among threads by layers. Results have the same bits as with one thread
/// (model/EQUATIONS.md, "Lattice in lanes").
template <class Real> class LatticeSlabs {
 public:
  /// Uses fewer than `threads` threads if there are not two layers for each.
  LatticeSlabs(const lattice::View<Real>& view, int threads);

  /// Largest useful number of threads. Rows of one vector are not partitioned: vectors at the ends
  /// of such a row reach into rows of other layers.
  [[nodiscard]] static int most_threads(int layers, long vectors, int wanted);

  /// Applies the kernel to the whole lattice and returns the sum of its results.
  double sweep(lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields) noexcept;
  /// The same with a kernel that takes a step. Forces need no room of the caller's: they are kept
  /// for two layers at a time, which stay in the cache.
  double step(lattice::Kernel<Real> kernel, const lattice::Move<Real>& move,
              const Outside<Real>& outside) noexcept;
  /// Before the first step(): allocates.
  void prepare_steps();

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  static constexpr int layers_kept = 2;  ///< a layer's springs lead to itself and the next
  [[nodiscard]] long few_length() const noexcept {
    return layers_kept * layer_length_ + 2 * view_.lead;
  }
  /// Between two slabs: both layers as they were before either moved, and room for forces on them
  /// that the other slab's thread computes itself.
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
  double sweep_slab(std::size_t number, lattice::Kernel<Real> kernel,
                    const lattice::Fields<Real>& fields, const VisitLayers& visit_layers) noexcept;
  [[nodiscard]] Real* forces_of(const lattice::Fields<Real>& fields, int layer) const noexcept;
  /// Where a layer's forces were come those of the one after next: rows that moved left none.
  void clear_standing_rows(const lattice::Fields<Real>& fields, int layer) const noexcept;
  void add_outside(const lattice::Fields<Real>& fields, const Outside<Real>& outside,
                   int layer) const noexcept;
  template <class Work> double share_out(const Work& work) noexcept;

  lattice::View<Real> view_;
  long layer_length_;        ///< elements
  long copy_length_;         ///< of a layer's q, with what the outermost lanes touch on both sides
  std::vector<int> begins_;  ///< of the slabs, and the last one's end
  std::vector<std::unique_ptr<Boundary>> boundaries_;  ///< n: under slab n + 1
  std::vector<AlignedVector<Real>> few_forces_;        ///< of two layers, for each slab
  std::vector<unsigned char> stands_;                  ///< of each layer: some row does
  std::vector<double> sums_;
  long round_ = 0;
  std::unique_ptr<Team> team_;  ///< last member: its threads end before the data go
};

// Rows of a lattice at rest, which are not stepped until they are pulled (model/EQUATIONS.md,
// "Sleeping rows").

template <class Real> class LatticeSleep {
 public:
  /// `view` of the whole lattice, whose rows of `row_length` elements move or never do; 1 in
  /// `awake` for those that move from the beginning. `most_withheld`: size of all forces on
  /// sleeping nodes together [N].
  LatticeSleep(const lattice::View<Real>& view, std::vector<unsigned char> awake,
               double most_withheld);

  /// 1 for a row that is stepped; the same vector for ever, to stand in a View.
  [[nodiscard]] const unsigned char* awake() const noexcept { return awake_.data(); }
  /// Share of the rows that can move.
  [[nodiscard]] double awake_share() const noexcept {
    return static_cast<double>(awake_count_) / static_cast<double>(able_count_);
  }

  /// After forces were added to f [N]: rows that are pulled too hard wake; those on the others are
  /// withheld.
  void wake_pulled(Real* f, const Real* inverse_mass) noexcept;
  /// After a step (lattice::Task::step): likewise, and rows that wake take theirs. Returns the sum
  /// of squares of their velocities.
  double wake_in_step(const lattice::Fields<Real>& fields) noexcept;
  /// Takes from f what is on sleeping rows.
  void withhold(Real* f) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  enum class Row : unsigned char { fixed, asleep, border, awake };

  [[nodiscard]] long begin_of(int row) const noexcept { return lead_ + row * row_length_; }
  /// visit(where the x of a node stands)
  template <class Visit> void visit_nodes(int row, Visit visit) const noexcept;
  void clear(Real* f, int row) const noexcept;
  [[nodiscard]] double pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept;
  void wake(std::size_t place_in_border) noexcept;
  void watch_around(int row) noexcept;
  /// visit(row) for each that wakes; the others' forces are taken away.
  template <class Visit> void judge_border(Real* f, const Real* inverse_mass, Visit visit) noexcept;

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

// A regular lattice under an explicit scheme: no index arrays, one pass over memory, explicit SIMD
// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and the elements that fill rows up have no
// inverse mass and never move.

template <class Real> class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  /// Throws std::invalid_argument for a network that is no regular lattice. `may_fold`: see
  /// LatticeRows.
  LatticeNetwork(const NetworkProblem& problem, bool skip, int threads = 1,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(),
                 bool may_fold = true);

  /// Rows that nothing displaces, moves or loads in the beginning sleep, but those of `touched`
  /// nodes (lattice_sleep.hpp). For one thread, without weight and without folds.
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

  double one_pass_with_sleep(double t, double gate, Real h, State<Real>& state) noexcept;
  void sort_loads();

  LatticeSprings<Real> springs_;
  bool damped_;
  lattice::Kernels<Real> kernels_;
  lattice::Kernel<Real> force_ = nullptr;
  lattice::Kernel<Real> step_ = nullptr;
  std::optional<LatticeSleep<Real>> sleep_;  ///< where rows may sleep
  std::unique_ptr<LatticeSlabs<Real>> slabs_;
  Vector<Real> next_force_;  ///< between two steps in one pass, where rows may sleep [N]
  std::vector<typename NetworkSystem<Real>::LoadOnCoordinate>
      loaded_;  ///< by layers, for steps in one pass
  std::vector<Pull<Real>> pulls_;
  std::vector<int> pulls_begin_;
};

}  // namespace palpate

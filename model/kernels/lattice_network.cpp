// SPDX-License-Identifier: MIT

#include "model/kernels/lattice_network.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "model/kernels/instruction_set.hpp"

namespace palpate {

namespace {

/// Number of polls without a task before a member yields the processor: about a millisecond.
constexpr long patience = 20000;

/// Signals a spin loop to the processor.
void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Team of threads that run one task together for a few microseconds at a time. Members wait in
/// spin loops, so that a tick neither locks nor makes a system call.
class Team {
 public:
  /// Starts the threads for the task work(number). `members` includes the caller, which is number
  /// 0.
  Team(int members, std::function<void(int)> work) : work_(std::move(work)) {
    for (int number = 1; number < members; ++number) {
      threads_.emplace_back([this, number] { serve(number); });
    }
  }
  ~Team() {
    round_.store(-1, std::memory_order_release);
    for (std::thread& thread : threads_) { thread.join(); }
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// Runs the task once on every member and returns when all have finished.
  void run() noexcept {
    const long round = round_.load(std::memory_order_relaxed) + 1;
    round_.store(round, std::memory_order_release);
    work_(0);
    const long all = round * static_cast<long>(threads_.size());
    while (finished_.load(std::memory_order_acquire) < all) { relax(); }
  }

 private:
  void serve(int number) noexcept {
    const FlushedDenormals flushed;  // same mode as on the calling thread
    for (long seen = 0;;) {
      long idle = 0;
      long round = seen;
      while ((round = round_.load(std::memory_order_acquire)) == seen) {
        relax();
        if (++idle > patience) { std::this_thread::yield(); }
      }
      if (round < 0) { return; }
      seen = round;
      work_(number);
      finished_.fetch_add(1, std::memory_order_release);
    }
  }

  std::function<void(int)> work_;
  std::atomic<long> round_{0};     ///< number of tasks so far; negative: threads end
  std::atomic<long> finished_{0};  ///< completed by members other than the caller, over all rounds
  std::vector<std::thread> threads_;
};

}  // namespace

int most_lattice_threads(int layers, long vectors, int wanted) {
  return vectors > 1 ? std::max(1, std::min(wanted, layers / 2)) : 1;
}

/// Partition of a lattice among threads by layers. Results are bitwise identical to those of one
/// thread (model/EQUATIONS.md, "Lattice in lanes").
template <class Real> class LatticeSlabs {
 public:
  LatticeSlabs(const lattice::View<Real>& view, int threads)
      : view_(view), copy_length_(view.layer_length + 2 * view.lead) {
    const int count = most_lattice_threads(view.rows2, view.vectors, threads);
    for (int n = 0; n <= count; ++n) {
      begins_.push_back(static_cast<int>(static_cast<long>(view.rows2) * n / count));
    }
    for (int n = 1; n < count; ++n) {
      boundaries_.push_back(std::make_unique<Boundary>());
      for (auto* numbers : {&boundaries_.back()->below, &boundaries_.back()->above}) {
        numbers->assign(static_cast<std::size_t>(3 * copy_length_), Real(0));
      }
    }
    sums_.assign(static_cast<std::size_t>(count), 0.0);
    if (count > 1) {
      team_ = std::make_unique<Team>(count, [this](int number) {
        const auto n = static_cast<std::size_t>(number);
        sums_[n] = sweep_slab(n, kernel_, fields_);
      });
    }
  }

  /// Applies the kernel to the whole lattice and returns the sum of its results.
  double sweep(lattice::Kernel<Real> kernel, const lattice::Fields<Real>& fields) noexcept {
    if (team_ == nullptr) { return sweep_slab(0, kernel, fields); }
    ++round_;
    kernel_ = kernel;
    fields_ = fields;
    team_->run();
    return std::accumulate(sums_.begin(), sums_.end(), 0.0);
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t bytes = 0;
    for (const auto& boundary : boundaries_) {
      bytes += (boundary->below.size() + boundary->above.size()) * sizeof(Real);
    }
    return bytes;
  }

 private:
  /// Boundary between two slabs: copies of both layers before either moves, and memory for the
  /// forces on them that the thread of the other slab computes for itself.
  struct Boundary {
    AlignedVector<Real> below;
    AlignedVector<Real> above;
    std::atomic<long> copied{0};  ///< round
  };
  /// Returns q, v and f of a layer that are stored in one vector.
  lattice::Nodes<Real> layer_in(AlignedVector<Real>& numbers) const noexcept {
    Real* first = numbers.data() + view_.lead;
    return {.q = first, .v = first + copy_length_, .f = first + 2 * copy_length_};
  }
  void copy(const lattice::Fields<Real>& fields, int layer,
            AlignedVector<Real>& to) const noexcept {
    const long begin = view_.lead + layer * view_.layer_length;
    const auto bytes = static_cast<std::size_t>(view_.layer_length) * sizeof(Real);
    Real* q = to.data() + view_.lead;
    std::memcpy(q, fields.q + begin, bytes);
    if (fields.v != nullptr) { std::memcpy(q + copy_length_, fields.v + begin, bytes); }
  }
  /// Computes one slab. The thread of the upper slab copies the two layers at the boundary and adds
  /// the forces of the lower slab's springs on the upper slab. The thread of the lower slab waits
  /// for the copy only before its last layer.
  double sweep_slab(std::size_t number, lattice::Kernel<Real> kernel,
                    const lattice::Fields<Real>& fields) noexcept {
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
    if (number == boundaries_.size()) {
      return kernel(view_, {.begin = begin, .end = end}, fields);
    }
    const double sum = kernel(view_, {.begin = begin, .end = end - 1}, fields);
    Boundary& over = *boundaries_[number];
    while (over.copied.load(std::memory_order_acquire) != round_) { relax(); }
    const lattice::Nodes<Real> above = layer_in(over.above);
    return sum + kernel(view_, {.begin = end - 1, .end = end, .beyond = &above}, fields);
  }

  lattice::View<Real> view_;
  long copy_length_;  ///< of q, including elements that the outermost lanes access on both sides
  std::vector<int> begins_;  ///< first layer of each slab, then the number of layers
  std::vector<std::unique_ptr<Boundary>> boundaries_;  ///< entry n is below slab n + 1
  std::vector<double> sums_;
  lattice::Kernel<Real> kernel_ = nullptr;  ///< of the current sweep
  lattice::Fields<Real> fields_{};
  long round_ = 0;
  std::unique_ptr<Team> team_;  ///< last member: the threads end before the data are destroyed
};

/// Rows of a lattice at rest, which are not integrated until a sufficient force acts on them
/// (model/EQUATIONS.md, "Sleeping rows").
template <class Real> class LatticeSleep {
 public:
  /// Prepares the rows of the whole lattice `view`; a row of `row_length` elements moves or is
  /// fixed as a whole. `awake` is 1 for rows that are integrated from the start. `most_withheld`
  /// limits the sum of all forces on sleeping nodes [N].
  LatticeSleep(const lattice::View<Real>& view, std::vector<unsigned char> awake,
               double most_withheld)
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

  /// Returns 1 for each row that is integrated. The pointer stays valid, so that a View can keep
  /// it.
  [[nodiscard]] const unsigned char* awake() const noexcept { return awake_.data(); }
  /// Returns the fraction of the movable rows that are awake.
  [[nodiscard]] double awake_share() const noexcept {
    return static_cast<double>(awake_count_) / static_cast<double>(able_count_);
  }

  /// Wakes rows with too large forces in f [N] and withholds the forces on the other sleeping rows.
  /// Call it after forces were added to f.
  void wake_pulled(Real* f, const Real* inverse_mass) noexcept {
    judge_border(f, inverse_mass, [](int) {});
  }
  /// Wakes rows after a step (lattice::Task::step) and moves them by that step, as
  /// lattice::move_row() does; rows never sleep under gravity. Returns the sum of squares of their
  /// velocities.
  double wake_in_step(const lattice::Fields<Real>& fields) noexcept {
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
  /// Removes the forces on sleeping rows from f.
  void withhold(Real* f) const noexcept {
    for (const int row : border_) { clear(f, row); }
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return state_.size() + awake_.size() + border_.capacity() * sizeof(int);
  }

 private:
  enum class Row : unsigned char { fixed, asleep, border, awake };

  [[nodiscard]] long begin_of(int row) const noexcept { return lead_ + row * row_length_; }
  /// Calls visit(index of x) for each node of a row.
  template <class Visit> void visit_nodes(int row, Visit visit) const noexcept {
    for (long vector = begin_of(row); vector < begin_of(row) + row_length_; vector += 3 * lanes_) {
      for (long i = vector; i < vector + lanes_; ++i) { visit(i); }
    }
  }
  void clear(Real* f, int row) const noexcept {
    std::fill_n(f + begin_of(row), static_cast<std::size_t>(row_length_), Real(0));
  }
  double pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept {
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
  void wake(std::size_t place_in_border) noexcept {
    const int row = border_[place_in_border];
    border_[place_in_border] = border_.back();
    border_.pop_back();
    state_[static_cast<std::size_t>(row)] = Row::awake;
    awake_[static_cast<std::size_t>(row)] = 1;
    ++awake_count_;
    watch_around(row);
  }
  void watch_around(int row) noexcept {
    const int at1 = row % rows1_;
    const int at2 = row / rows1_;
    for (int to2 = std::max(0, at2 - 1); to2 <= std::min(rows2_ - 1, at2 + 1); ++to2) {
      for (int to1 = std::max(0, at1 - 1); to1 <= std::min(rows1_ - 1, at1 + 1); ++to1) {
        const int there = to2 * rows1_ + to1;
        Row& state = state_[static_cast<std::size_t>(there)];
        if (state != Row::asleep) { continue; }
        state = Row::border;
        border_.push_back(there);  // capacity is reserved for all rows
      }
    }
  }
  /// Withholds at most an equal share of the total limit on each row at the border, and calls
  /// visit(row) for each row that wakes. A NaN force wakes the row.
  template <class Visit>
  void judge_border(Real* f, const Real* inverse_mass, Visit visit) noexcept {
    const double share =
        most_withheld_ / static_cast<double>(std::max<std::size_t>(1, border_.size()));
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

namespace {

template <class Real>
LatticeSprings<Real> springs_of(const NetworkProblem& problem, int lanes, bool skip,
                                bool may_fold) {
  const auto& shape = problem.network().springs.lattice();
  if (!shape) { throw std::invalid_argument("the network is no regular lattice"); }
  return LatticeSprings<Real>(problem, *shape, lanes, skip, may_fold);
}

/// Size [bytes] above which the data exceed the caches and prefetching of rows is faster
/// (docs/bench.md).
constexpr std::size_t largest_cached = 8UL << 20U;

/// Chooses the prefetched data from the sizes of the node arrays and of the spring constants.
template <class Real> lattice::Fetch fetch_for(Eigen::Index coordinates, std::size_t spring_bytes) {
  if (spring_bytes > largest_cached) { return lattice::Fetch::rows_and_constants; }
  const bool fits = 7 * sizeof(Real) * static_cast<std::size_t>(coordinates) / 3 <= largest_cached;
  return fits ? lattice::Fetch::nothing : lattice::Fetch::rows;
}

}  // namespace

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, bool skip, int threads,
                                     const lattice::Kernels<Real>& kernels, bool may_fold)
    : LatticeNetwork(problem, springs_of<Real>(problem, kernels.lanes, skip, may_fold), kernels,
                     skip, threads) {}

template <class Real>
LatticeNetwork<Real>::LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                                     const lattice::Kernels<Real>& kernels, bool skip, int threads)
    : NetworkSystem<Real>(problem, springs.layout(), skip),
      springs_(std::move(springs)),
      damped_(springs_.view().numbers > 1),
      kernels_(kernels),
      slabs_(std::make_unique<LatticeSlabs<Real>>(springs_.view(), threads)) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
  scatter(problem.mass(), this->layout(), mass);
  this->set_mass(mass);
  this->spread_weight();
  const lattice::Fetch fetch = fetch_for<Real>(this->layout().size, springs_.memory_bytes());
  force_ = (damped_ ? kernels.force : kernels.undamped_force).at(fetch);
  step_ = (damped_ ? kernels.step : kernels.undamped_step).at(fetch);
}

template <class Real> LatticeNetwork<Real>::~LatticeNetwork() = default;

template <class Real> double LatticeNetwork<Real>::awake_share() const noexcept {
  return sleep_ ? sleep_->awake_share() : 1.0;
}

template <class Real>
void LatticeNetwork<Real>::let_sleep(double most_withheld, std::span<const int> touched) {
  const NetworkProblem& problem = this->problem();
  const SpringNetwork& network = problem.network();
  const LatticeRows& rows = springs_.rows();
  std::vector<unsigned char> awake(rows.count(), 0);
  const auto wake = [&](int node) { awake[rows.row_of(rows.place_of(node))] = 1; };
  const auto stirred = [](const NodeVectors& columns, int node) {
    return columns.cols() > 0 && !columns.col(node).isZero(0.0);
  };
  for (int node = 0; node < network.node_count(); ++node) {
    if (stirred(network.initial_displacement, node) || stirred(network.initial_velocity, node)) {
      wake(node);
    }
  }
  for (const Load& load : problem.loads()) { std::ranges::for_each(load.nodes, wake); }
  std::ranges::for_each(touched, wake);
  lattice::View<Real> view = springs_.view();
  sleep_ = std::make_unique<LatticeSleep<Real>>(view, std::move(awake), most_withheld);
  view.row_moves = sleep_->awake();
  slabs_ = std::make_unique<LatticeSlabs<Real>>(view, 1);
}

template <class Real>
void LatticeNetwork<Real>::add_springs(const Vector<Real>& q, const Vector<Real>& v,
                                       Vector<Real>& f) noexcept {
  slabs_->sweep(force_, {q.data(), v.data(), f.data()});
  if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
}

template <class Real>
double LatticeNetwork<Real>::measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                             Vector<Real>& f) noexcept {
  const double energy =
      slabs_->sweep(damped_ ? kernels_.measured_force : kernels_.measured_undamped_force,
                    {q.data(), v.data(), f.data()});
  if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
  return energy;
}

template <class Real> void LatticeNetwork<Real>::prepare_one_pass() {
  next_force_.setZero(this->layout().size);
  this->put_weight(next_force_);
}

template <class Real>
double LatticeNetwork<Real>::one_pass(double t, double gate, Real h, State<Real>& state) noexcept {
  this->add_loads(t, gate, Real(1), next_force_);
  const lattice::Move<Real> move{.q = state.position.data(),
                                 .v = state.velocity.data(),
                                 .inverse_mass = this->inverse_mass().data(),
                                 .weight = this->weight(),
                                 .h = h};
  const lattice::Fields<Real> fields{
      .q = move.q, .v = move.v, .f = next_force_.data(), .move = &move};
  const double squares = slabs_->sweep(step_, fields);
  return sleep_ ? squares + sleep_->wake_in_step(fields) : squares;
}

template <class Real>
void LatticeNetwork<Real>::damping(const Vector<Real>& q, const Vector<Real>& w,
                                   Vector<Real>& f) noexcept {
  f.setZero();
  if (!damped_) { return; }
  slabs_->sweep(kernels_.damping, {q.data(), w.data(), f.data()});
  if (sleep_) { sleep_->withhold(f.data()); }
  f = -f;
}

template <class Real>
double LatticeNetwork<Real>::elastic_energy(const Vector<Real>& q) const noexcept {
  return slabs_->sweep(kernels_.energy, {.q = q.data()});
}

template <class Real> std::size_t LatticeNetwork<Real>::spring_bytes() const noexcept {
  return springs_.memory_bytes() + slabs_->memory_bytes() + (sleep_ ? sleep_->memory_bytes() : 0) +
         static_cast<std::size_t>(next_force_.size()) * sizeof(Real);
}

template class LatticeNetwork<double>;
template class LatticeNetwork<float>;

}  // namespace palpate

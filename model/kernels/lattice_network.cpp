// SPDX-License-Identifier: MIT

#include "model/kernels/lattice_network.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
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
      : view_(view), most_withheld_(most_withheld), awake_(std::move(awake)) {
    const int rows = view.rows1 * view.rows2;
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
        for (long at = i; at <= i + 2 * view_.lanes; at += view_.lanes) {
          move.v[at] += move.h * (fields.f[at] * move.inverse_mass[i]);
          move.q[at] += move.h * move.v[at];
          squares += static_cast<double>(move.v[at] * move.v[at]);
        }
      });
      clear(fields.f, row);
    });
    return squares;
  }
  /// Takes the rows that are awake in the same lattice.
  void continue_from(const LatticeSleep& from) noexcept {
    std::ranges::copy(from.state_, state_.begin());
    std::ranges::copy(from.awake_, awake_.begin());            // in place: a View has the pointer
    border_.assign(from.border_.begin(), from.border_.end());  // capacity for all rows
    awake_count_ = from.awake_count_;
  }
  [[nodiscard]] bool resembles(const LatticeSleep& other) const {
    return state_.size() == other.state_.size();
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

  [[nodiscard]] long begin_of(int row) const noexcept {
    return view_.lead + row * view_.row_length;
  }
  /// Calls visit(index of x) for each node of a row.
  template <class Visit> void visit_nodes(int row, Visit visit) const noexcept {
    const long end = begin_of(row) + view_.row_length;
    for (long vector = begin_of(row); vector < end; vector += 3 * view_.lanes) {
      for (long i = vector; i < vector + view_.lanes; ++i) { visit(i); }
    }
  }
  void clear(Real* f, int row) const noexcept {
    std::fill_n(f + begin_of(row), static_cast<std::size_t>(view_.row_length), Real(0));
  }
  double pull_on(const Real* f, const Real* inverse_mass, int row) const noexcept {
    double pull = 0.0;
    visit_nodes(row, [&](long i) {
      if (inverse_mass[i] == Real(0)) { return; }
      const auto x = static_cast<double>(f[i]);
      const auto y = static_cast<double>(f[i + view_.lanes]);
      const auto z = static_cast<double>(f[i + 2 * view_.lanes]);
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
    const int at1 = row % view_.rows1;
    const int at2 = row / view_.rows1;
    for (int to2 = std::max(0, at2 - 1); to2 <= std::min(view_.rows2 - 1, at2 + 1); ++to2) {
      for (int to1 = std::max(0, at1 - 1); to1 <= std::min(view_.rows1 - 1, at1 + 1); ++to1) {
        const int there = to2 * view_.rows1 + to1;
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

  lattice::View<Real> view_;
  double most_withheld_;
  std::vector<Row> state_;
  std::vector<unsigned char> awake_;
  std::vector<int> border_;  ///< sleeping rows next to an awake row
  long awake_count_ = 0;
  long able_count_ = 0;
};

/// Unused elements before and after the rows that the outermost lanes access: one cache line.
template <class Real> constexpr Eigen::Index margin = 64 / sizeof(Real);

/// Returns the length of a vector of all coordinates: a multiple of the margin.
template <class Real> Eigen::Index size_for(Eigen::Index elements) {
  return (elements + 3 * margin<Real> - 1) / margin<Real> * margin<Real>;
}

/// Returns the slot of a spring with offset `step` along (row, second, third).
std::size_t slot_of(const std::array<int, 3>& step) {
  for (int kind = 0; kind < lattice::neighbour_kinds; ++kind) {
    const auto& to = lattice::neighbour_steps[kind];
    if (step[1] == to[0] && step[2] == to[1]) {
      return static_cast<std::size_t>(2 + 3 * kind + step[0]);
    }
  }
  return 0;
}

bool leads_back(const std::array<int, 3>& step) {
  if (step[2] != 0) { return step[2] < 0; }
  return step[1] != 0 ? step[1] < 0 : step[0] < 0;
}

/// Kernel data of a regular lattice: nodes in SIMD lanes, and tables of spring constants that equal
/// rows share (model/EQUATIONS.md, "Lattice in lanes").
template <class Real> class LatticeSprings {
 public:
  /// Builds the tables. `shape` is the lattice of the problem's network. With skip = false, absent
  /// dampers and rows of fixed nodes are computed too; results are bitwise identical.
  LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes, bool skip,
                 bool may_fold)
      : problem_(problem),
        spacing_(shape.spacing),
        rows_(shape, lanes, may_fold),
        lanes_(lanes),
        vectors_(rows_.vectors),
        size_(size_for<Real>(static_cast<Eigen::Index>(rows_.count()) * vectors_ * 3 * lanes_)),
        row_moves_(skip ? rows_.moving(problem) : std::vector<unsigned char>(rows_.count(), 1)) {
    fill_tables(problem, skip);
  }

  /// newly built by each call
  [[nodiscard]] NodeLayout layout() const {
    NodeLayout layout{.size = size_, .stride = lanes_};
    const int nodes = static_cast<int>(problem_.network().node_count());
    layout.first.reserve(static_cast<std::size_t>(nodes));
    for (int node = 0; node < nodes; ++node) {
      const bool fixed = problem_.coordinate(node) < 0;
      layout.first.push_back(fixed ? -1 : static_cast<int>(element_of(rows_.place_of(node))));
    }
    return layout;
  }
  [[nodiscard]] const LatticeRows& rows() const { return rows_; }
  [[nodiscard]] lattice::View<Real> view() const {
    return {.rows1 = rows_.rows1,
            .rows2 = rows_.nodes[2],
            .vectors = vectors_,
            .row_length = 3L * vectors_ * lanes_,
            .layer_length = 3L * vectors_ * lanes_ * rows_.rows1,
            .folded = rows_.folds > 1,
            .lead = margin<Real>,
            .lanes = lanes_,
            .numbers = damped_ ? 2 : 1,
            .tables = tables_.data(),
            .row_table = row_table_.data(),
            .row_moves = row_moves_.data(),
            .own_rest = length_along(1),
            .own_springs = used_[0],
            .links = {links_of(0), links_of(1), links_of(rows_.rows1 - 1)}};
  }
  /// Returns the initial position of all nodes. Padding elements get positions far from each other.
  [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> initial_position() const {
    Eigen::Matrix<Real, Eigen::Dynamic, 1> q(size_);
    for (Eigen::Index i = 0; i < size_; ++i) {
      q(i) = static_cast<Real>(-spacing_ * static_cast<double>(1 + i));
    }
    const SpringNetwork& network = problem_.network();
    for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
      at_node(q, element_of(rows_.place_of(node)), lanes_) =
          network.initial_place(node).template cast<Real>();
    }
    return q;
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return tables_.capacity() * sizeof(Real) + row_table_.capacity() * sizeof(long) +
           row_moves_.capacity();
  }

 private:
  [[nodiscard]] Eigen::Index element_of(const LatticeRows::Place& place) const {
    const auto row = static_cast<Eigen::Index>(rows_.row_of(place));
    return margin<Real> + (row * vectors_ + place[0] % vectors_) * 3 * lanes_ +
           rows_.first_lane(place) + place[0] / vectors_;
  }
  /// Equal springs of consecutive nodes in a row, stored with the row that computes them.
  struct Stretch {
    std::uint32_t row = 0;
    int place = 0;  ///< position of the first node in the row
    int nodes = 0;
    std::uint16_t slot = 0;
    std::uint16_t first_lane = 0;  ///< first lane of its lattice row
    const SpringList::Bond* bond = nullptr;
    /// Returns true if all members except the row are equal.
    [[nodiscard]] bool equals(const Stretch& other) const {
      return place == other.place && nodes == other.nodes && slot == other.slot &&
             first_lane == other.first_lane && bond->stiffness == other.bond->stiffness &&
             bond->viscosity == other.bond->viscosity;
    }
  };
  [[nodiscard]] auto stretch_of(int node, int nodes, const SpringList::Bond& bond) const
      -> Stretch {
    const LatticeRows::Place a = rows_.place_of(node);
    const LatticeRows::Place b = rows_.place_of(node + bond.to);
    std::array<int, 3> step{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const bool back = leads_back(step);
    if (back) {
      for (int& s : step) { s = -s; }
    }
    const LatticeRows::Place& from = back ? b : a;
    return {.row = static_cast<std::uint32_t>(rows_.row_of(from)),
            .place = from[0],
            .nodes = nodes,
            .slot = static_cast<std::uint16_t>(slot_of(step)),
            .first_lane = static_cast<std::uint16_t>(rows_.first_lane(from)),
            .bond = &bond};
  }
  /// rest length of the springs [m]
  [[nodiscard]] Real length_along(int axes) const {
    return static_cast<Real>(spacing_ * std::sqrt(static_cast<double>(axes)));
  }
  /// Returns the links of a row. After the last interleaved row follow the nodes of the first row
  /// in the next lane group.
  [[nodiscard]] lattice::Links<Real> links_of(int row1) const {
    const int rows1 = rows_.rows1;
    lattice::Links<Real> links;
    for (int kind = 0; kind < lattice::neighbour_kinds; ++kind) {
      const auto& step = lattice::neighbour_steps[kind];
      const std::size_t slot = 1 + 3 * static_cast<std::size_t>(kind);
      const bool sides = used_[slot] || used_[slot + 2];
      const int folds =
          row1 + step[0] < 0 ? -1 : (row1 + step[0]) / rows1;  // offset in interleaved rows
      if ((!sides && !used_[slot + 1]) || (folds != 0 && rows_.folds == 1)) { continue; }
      const int rows = step[0] - folds * rows1;
      links.to[links.count++] = {
          .layers = step[1],
          .rows = rows + step[1] * rows1,
          .elements = static_cast<long>(rows) * vectors_ * 3 * lanes_ + folds * rows_.pieces,
          .constants = static_cast<long>(slot) * lanes_ * (damped_ ? 2 : 1),
          .rest_across = length_along(std::abs(step[0]) + step[1]),
          .rest_aside = length_along(std::abs(step[0]) + step[1] + 1),
          .sides = sides};
      links.within += 1 - step[1];
    }
    return links;
  }
  /// Fills the tables row by row; equal rows share a table.
  void fill_tables(const NetworkProblem& problem, bool skip) {
    const SpringList& springs = problem.network().springs;
    damped_ = !skip || is_damped(springs);
    const auto numbers = static_cast<std::size_t>(damped_ ? 2 : 1);
    const auto lanes = static_cast<std::size_t>(lanes_);
    const std::size_t slot_length = numbers * lanes;
    std::vector<std::size_t> begins;
    const std::vector<Stretch> stretches = by_row(springs, begins);
    const auto before = [](const std::vector<Real>& a, const std::vector<Real>& b) {
      return std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) <
             0;  // NaN compares unequal to every number
    };
    std::map<std::vector<Real>, long, decltype(before)> known(before);
    std::vector<Real> row(static_cast<std::size_t>(vectors_) * lattice::slots * slot_length);
    std::span<const Stretch> row_before;
    for (std::size_t n = 0; n + 1 < begins.size(); ++n) {
      const auto own = std::span(stretches).subspan(begins[n], begins[n + 1] - begins[n]);
      if (n > 0 && std::ranges::equal(own, row_before, [](const Stretch& a, const Stretch& b) {
            return a.equals(b);
          })) {
        row_table_.push_back(row_table_.back());
        continue;
      }
      row_before = own;
      std::ranges::fill(row, Real(0));
      for (const Stretch& stretch : own) {
        used_[stretch.slot] = true;
        for (int place = stretch.place; place < stretch.place + stretch.nodes; ++place) {
          const auto vector = static_cast<std::size_t>(place % vectors_);
          const auto lane = static_cast<std::size_t>(stretch.first_lane + place / vectors_);
          Real* constants =
              row.data() + (vector * lattice::slots + stretch.slot) * slot_length + lane;
          constants[0] += static_cast<Real>(stretch.bond->stiffness);
          if (damped_) { constants[lanes] += static_cast<Real>(stretch.bond->viscosity); }
        }
      }
      const auto [found, is_new] = known.try_emplace(row, static_cast<long>(tables_.size()));
      if (is_new) { tables_.insert(tables_.end(), row.begin(), row.end()); }
      row_table_.push_back(found->second);
    }
  }
  /// Returns the springs sorted by the row that computes them, in list order within a row. Row n
  /// has the springs begins[n] to begins[n + 1].
  [[nodiscard]] auto by_row(const SpringList& springs, std::vector<std::size_t>& begins) const
      -> std::vector<Stretch> {
    const int together = rows_.follows_index() ? rows_.nodes[0] : 1;
    const auto visit_all = [&](auto visit) {
      for (const SpringList::Run& run : springs.runs()) {
        const int end = run.first_node + run.nodes;
        for (int node = run.first_node; node < end;) {
          const int piece_end = std::min(end, (node / together + 1) * together);
          for (const SpringList::Bond& bond : springs.bonds(run)) {
            visit(stretch_of(node, piece_end - node, bond));
          }
          node = piece_end;
        }
      }
    };
    begins.assign(row_moves_.size() + 1, 0);
    visit_all([&](const Stretch& stretch) { ++begins[stretch.row + 1]; });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::vector<std::size_t> next(begins.begin(), begins.end() - 1);
    std::vector<Stretch> sorted(begins.back());
    visit_all([&](const Stretch& stretch) { sorted[next[stretch.row]++] = stretch; });
    return sorted;
  }

  const NetworkProblem& problem_;
  double spacing_;  ///< [m]
  LatticeRows rows_;
  int lanes_;
  int vectors_;
  Eigen::Index size_;  ///< length of a vector of all coordinates
  std::vector<unsigned char> row_moves_;
  bool damped_ = false;
  AlignedVector<Real> tables_{};
  std::vector<long> row_table_{};
  std::array<bool, lattice::slots> used_{};  ///< slots with a spring in at least one row
};

/// Size [bytes] above which the data exceed the caches and prefetching of rows is faster
/// (docs/bench.md).
constexpr std::size_t largest_cached = 8UL << 20U;

/// Chooses the prefetched data from the sizes of the node arrays and of the spring constants.
template <class Real> lattice::Fetch fetch_for(Eigen::Index coordinates, std::size_t spring_bytes) {
  if (spring_bytes > largest_cached) { return lattice::Fetch::rows_and_constants; }
  const bool fits = 7 * sizeof(Real) * static_cast<std::size_t>(coordinates) / 3 <= largest_cached;
  return fits ? lattice::Fetch::nothing : lattice::Fetch::rows;
}

/// Regular lattice for explicit schemes: no index arrays, one pass over memory, explicit SIMD
/// (model/EQUATIONS.md, "Lattice in lanes"). Fixed nodes and padding elements have zero inverse
/// mass and never move.
template <class Real> class LatticeNetwork final : public NetworkSystem<Real> {
 public:
  LatticeNetwork(const NetworkProblem& problem, LatticeSprings<Real> springs,
                 const LatticeOptions<Real>& options)
      : NetworkSystem<Real>(problem, springs.layout(), options.skip),
        springs_(std::move(springs)),
        damped_(springs_.view().numbers > 1),
        kernels_(options.kernels),
        slabs_(std::make_unique<LatticeSlabs<Real>>(springs_.view(), options.threads)) {
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
    scatter(problem.mass(), this->layout(), mass);
    this->set_mass(mass);
    this->spread_weight();
    const lattice::Fetch fetch = fetch_for<Real>(this->layout().size, springs_.memory_bytes());
    force_ = (damped_ ? kernels_.force : kernels_.undamped_force).at(fetch);
    step_ = (damped_ ? kernels_.step : kernels_.undamped_step).at(fetch);
    if (options.sleep_force > 0.0) { let_sleep(options.sleep_force, options.touched); }
  }

  [[nodiscard]] double awake_share() const noexcept override {
    return sleep_ ? sleep_->awake_share() : 1.0;
  }
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override {
    f.setZero();
    if (!damped_) { return; }
    slabs_->sweep(kernels_.damping, {q.data(), w.data(), f.data()});
    if (sleep_) { sleep_->withhold(f.data()); }
    f = -f;
  }
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  [[nodiscard]] bool has_one_pass() const override { return true; }
  void prepare_one_pass() override {
    next_force_.setZero(this->layout().size);
    this->put_weight(next_force_);
  }
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override {
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
  [[nodiscard]] Vector<Real> initial_position() const override {
    return springs_.initial_position();
  }
  void prepare_to_continue(const NetworkSystem<Real>& from) override {
    if (!sleep_) { return; }
    const auto* other = dynamic_cast<const LatticeNetwork*>(&from);
    if (other == nullptr || !other->sleep_ || !sleep_->resembles(*other->sleep_)) {
      throw std::invalid_argument("rows may sleep now that could not before");
    }
  }
  void continue_from(const NetworkSystem<Real>& from, const Vector<Real>& /*q*/,
                     const Vector<Real>& /*v*/, State<Real>& /*state*/) noexcept override {
    if (sleep_) { sleep_->continue_from(*static_cast<const LatticeNetwork&>(from).sleep_); }
  }

 private:
  /// Rows without initial displacement, velocity or load sleep, except the rows of `touched` nodes.
  void let_sleep(double most_withheld, std::span<const int> touched) {
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
    sleep_.emplace(view, std::move(awake), most_withheld);
    view.row_moves = sleep_->awake();
    slabs_ = std::make_unique<LatticeSlabs<Real>>(view, 1);
  }
  void add_springs(const Vector<Real>& q, const Vector<Real>& v,
                   Vector<Real>& f) noexcept override {
    slabs_->sweep(force_, {q.data(), v.data(), f.data()});
    if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
  }
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override {
    const double energy =
        slabs_->sweep(damped_ ? kernels_.measured_force : kernels_.measured_undamped_force,
                      {q.data(), v.data(), f.data()});
    if (sleep_) { sleep_->wake_pulled(f.data(), this->inverse_mass().data()); }
    return energy;
  }
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override {
    return slabs_->sweep(kernels_.energy, {.q = q.data()});
  }
  [[nodiscard]] std::size_t spring_bytes() const noexcept override {
    return springs_.memory_bytes() + slabs_->memory_bytes() +
           (sleep_ ? sleep_->memory_bytes() : 0) +
           static_cast<std::size_t>(next_force_.size()) * sizeof(Real);
  }

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

}  // namespace

int most_lattice_threads(int layers, long vectors, int wanted) {
  return vectors > 1 ? std::max(1, std::min(wanted, layers / 2)) : 1;
}

template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_lattice_network(const NetworkProblem& problem,
                                                          const LatticeOptions<Real>& options) {
  const auto& shape = problem.network().springs.lattice();
  if (!shape) { throw std::invalid_argument("the network is no regular lattice"); }
  return std::make_unique<LatticeNetwork<Real>>(
      problem,
      LatticeSprings<Real>(problem, *shape, options.kernels.lanes, options.skip,
                           options.sleep_force <= 0.0),
      options);
}

template std::unique_ptr<NetworkSystem<double>> make_lattice_network(const NetworkProblem&,
                                                                     const LatticeOptions<double>&);
template std::unique_ptr<NetworkSystem<float>> make_lattice_network(const NetworkProblem&,
                                                                    const LatticeOptions<float>&);

}  // namespace palpate

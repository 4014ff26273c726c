// SPDX-License-Identifier: MIT
#pragma once
/// Network of springs in a list, of any topology, and the matrices of implicit schemes.

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "model/kernels/cell_forces.hpp"
#include "model/kernels/law_springs.hpp"
#include "model/kernels/network_system.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// Layout of the vectors of a list network.
struct ListVectors {
  [[nodiscard]] int spacing() const { return padded ? adjacency::node_stride : 3; }
  /// Padded 4-vectors, fixed points after the free nodes; not available with matrices.
  bool padded = false;
  Eigen::Index further = 0;  ///< additional coordinates, with masses from a derived class
};

template <class Real> class ListNetwork : public NetworkSystem<Real> {
 public:
  /// Builds the network. skip = false computes unnecessary terms too, with identical results.
  ListNetwork(const NetworkProblem& problem, const PrintedForm& printed, double h, bool skip,
              const ListVectors& vectors = {})
      : NetworkSystem<Real>(problem, layout_of(problem, vectors), skip),
        spacing_(vectors.spacing()) {
    if (vectors.further == 0) {
      Eigen::VectorXd mass = Eigen::VectorXd::Zero(this->layout().size);
      scatter(problem.mass(), this->layout(), mass);
      this->set_mass(mass);
    }
    sort_springs(problem, skip);
    cells_.take(problem, this->layout());
    damped_ = is_damped(problem.network());
    springs_.law = SpringLaw::from(printed);
    springs_.lagged = printed.lagged_velocity;
    springs_.lag = static_cast<Real>(h);
    if (springs_.lagged) { remember_lengths(); }
    grouped_ = !SpringLaw::is_printed(printed);
    if (grouped_) { groups_.take(springs_, damped_ || !skip, spacing_); }
    if (!problem.network().laws.empty()) {
      const Vector<Real> q = ListNetwork::initial_position();
      laws_.take(springs_, problem.network().laws, spacing_, q.data());
      cells_.begin(q.data());
    }
    this->spread_weight();
  }

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override {
    f.setZero();
    if (!damped_) { return; }
    add_damping(springs_, q.data(), w.data(), f.data());
    cells_.add_damping(q.data(), w.data(), f.data());
    f = -f;
  }
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  [[nodiscard]] bool has_one_pass() const override { return spacing_ == adjacency::node_stride; }
  void prepare_one_pass() override {
    next_force_.setZero(this->layout().size);
    this->put_weight(next_force_);
  }
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override {
    this->add_loads(t, gate, Real(1), next_force_);
    reach(t);
    add_springs(state.position, state.velocity, next_force_);
    return groups_.advance({.q = state.position.data(),
                            .v = state.velocity.data(),
                            .f = next_force_.data(),
                            .inverse_mass = this->inverse_mass().data(),
                            .weight = this->weight(),
                            .h = h},
                           this->layout().size / adjacency::node_stride);
  }
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override {
    // The stage of a step is `on_damping` seconds after its start.
    laws_.at(static_cast<double>(on_damping));
    cells_.at(static_cast<double>(on_damping));
    Real* values = a.valuePtr();
    std::fill(values, values + a.nonZeros(), Real(0));
    for (Eigen::Index i = 0; i < this->mass().size(); ++i) {
      values[diagonal_slots_[static_cast<std::size_t>(i)]] = this->mass()(i);
    }
    for_each_spring(springs_, q.data(), v.data(),
                    [&](std::size_t index, const auto& s, int b, const auto& d, const auto& w) {
                      ElasticPull pull;
                      const int element = laws_.element(index);
                      if (element >= 0) {
                        pull = laws_.pull(s, element, static_cast<double>(d.norm()));
                      }
                      const auto g = spring_gradient<Real>(springs_.law, numbers_of<Real>(s), d, w,
                                                           element >= 0 ? &pull : nullptr);
                      const Eigen::Matrix<Real, 3, 3> block =
                          on_stiffness * g.position + on_damping * g.velocity;
                      const std::size_t blocks = b < 0 ? 1 : 4;
                      for (std::size_t n = 0; n < blocks; ++n) {
                        const Real sign = n < 2 ? Real(1) : Real(-1);
                        for (int c = 0; c < 3; ++c) {
                          Real* column =
                              values + slots_[index][3 * n + static_cast<std::size_t>(c)];
                          for (int r = 0; r < 3; ++r) { column[r] += sign * block(r, c); }
                        }
                      }
                    });
    cells_.add_jacobian(q.data(), v.data(), on_damping, on_stiffness, values);
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    assert(spacing_ == 3);
    const Eigen::Index of_nodes = this->problem().dof();
    std::vector<Eigen::Triplet<Real>> triplets;
    add_entries(triplets);
    triplets.reserve(triplets.size() + 18 * springs_.links.size() +
                     static_cast<std::size_t>(9 * of_nodes));
    const auto block = [&](int row, int column) {
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) { triplets.emplace_back(row + r, column + c, Real(0)); }
      }
    };
    for (int i = 0; i < static_cast<int>(of_nodes); i += 3) { block(i, i); }
    for (const auto& s : springs_.links) {
      block(s.a, s.b);
      block(s.b, s.a);
    }
    cells_.for_each_pair(block);
    a.resize(this->dof(), this->dof());
    a.setFromTriplets(triplets.begin(), triplets.end());
    a.makeCompressed();
    slots_.clear();
    diagonal_slots_.clear();
    for (const auto& s : springs_.links) {
      std::array<std::int64_t, 12>& slots = slots_.emplace_back();
      for (int c = 0; c < 3; ++c) {
        const auto n = static_cast<std::size_t>(c);
        slots[n] = slot_of(a, s.a, s.a + c);
        slots[3 + n] = slot_of(a, s.b, s.b + c);
        slots[6 + n] = slot_of(a, s.a, s.b + c);
        slots[9 + n] = slot_of(a, s.b, s.a + c);
      }
    }
    for (const auto& s : springs_.anchors) {
      slots_.push_back({slot_of(a, s.a, s.a), slot_of(a, s.a, s.a + 1), slot_of(a, s.a, s.a + 2)});
    }
    cells_.find_slots(a);
    for (int i = 0; i < static_cast<int>(a.cols()); ++i) {
      diagonal_slots_.push_back(slot_of(a, i, i));
    }
  }
  [[nodiscard]] Vector<Real> initial_position() const override {
    Vector<Real> q = Vector<Real>::Zero(this->layout().size);
    scatter(this->problem().initial_position(), this->layout(), q);
    if (spacing_ == adjacency::node_stride) {
      for (const auto& s : springs_.anchors) {
        q.template segment<3>(s.b) = Eigen::Map<const Eigen::Matrix<Real, 3, 1>>(s.place);
      }
    }
    return q;
  }

  [[nodiscard]] double unmeasured_energy(const Vector<Real>& q) const noexcept override {
    return !grouped_ ? 0.0 : law_energy(q) + cells_.energy(q.data());
  }
  void remember(double t, const Vector<Real>& q) noexcept override {
    reach(t);
    laws_.remember(q.data());
    cells_.remember(q.data());
    last_time_ = t;
  }
  void prepare_to_continue(const NetworkSystem<Real>& from) override {
    const auto* other = dynamic_cast<const ListNetwork*>(&from);
    const bool same =
        other == nullptr
            ? laws_.empty() && !springs_.lagged
            : laws_.resembles(other->laws_) && cells_.resembles(other->cells_) &&
                  springs_.previous_length.size() == other->springs_.previous_length.size();
    if (!same) {
      throw std::invalid_argument("the relaxing springs or cells are others than before");
    }
  }
  void continue_from(const NetworkSystem<Real>& from, const Vector<Real>& /*q*/,
                     const Vector<Real>& /*v*/, State<Real>& /*state*/) noexcept override {
    const auto* other = dynamic_cast<const ListNetwork*>(&from);
    if (other == nullptr) { return; }
    last_time_ = other->last_time_;
    laws_.continue_from(other->laws_);
    cells_.continue_from(other->cells_);
    std::ranges::copy(other->springs_.previous_length, springs_.previous_length.begin());
  }
  [[nodiscard]] int relaxing(const Spring& spring) const override {
    const auto first = [&](int node) {
      return this->layout().first[static_cast<std::size_t>(node)];
    };
    int free_end = first(spring.a);
    int other = first(spring.b);
    if (free_end < 0) { std::swap(free_end, other); }
    const Vector<Real> place = this->problem()
                                   .held_position()
                                   .col(first(spring.a) < 0 ? spring.a : spring.b)
                                   .template cast<Real>();
    std::size_t index = 0;
    for (const auto& s : springs_.links) {
      const bool ends = (s.a == free_end && s.b == other) || (s.a == other && s.b == free_end);
      if (ends && s.law == spring.law) { return laws_.element(index); }
      ++index;
    }
    for (const auto& s : springs_.anchors) {
      const bool ends =
          s.a == free_end && other < 0 && std::equal(s.place, s.place + 3, place.data());
      if (ends && s.law == spring.law) { return laws_.element(index); }
      ++index;
    }
    return -1;
  }
  [[nodiscard]] int relaxing(const VolumeCell& cell) const override {
    return cells_.relaxing(cell, this->problem(), this->layout());
  }
  [[nodiscard]] Relaxed relaxed_spring(int number) const noexcept override {
    return laws_.relaxed(number);
  }
  [[nodiscard]] Relaxed relaxed_cell(int number) const noexcept override {
    const auto cell = cells_.relaxed(static_cast<std::size_t>(number));
    return {static_cast<double>(cell.share), static_cast<double>(cell.held)};
  }

 protected:
  void reach(double t) noexcept override {
    laws_.at(t - last_time_);
    cells_.at(t - last_time_);
  }
  void add_springs(const Vector<Real>& q, const Vector<Real>& v,
                   Vector<Real>& f) noexcept override {
    if (grouped_) {
      groups_.add(q.data(), v.data(), f.data());
    } else {
      add_forces(springs_, q.data(), v.data(), f.data());
    }
    laws_.add(q.data(), v.data(), f.data());
    cells_.add(q.data(), v.data(), f.data());
    add_fixed_pairs();
  }
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override {
    if (!grouped_) { return NetworkSystem<Real>::measure_springs(q, v, f); }
    const double energy = groups_.measure(q.data(), v.data(), f.data());
    laws_.add(q.data(), v.data(), f.data());
    cells_.add(q.data(), v.data(), f.data());
    add_fixed_pairs();
    return energy;
  }
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override {
    double energy = 0.0;
    for_each_spring(springs_, q.data(), q.data(),
                    [&](std::size_t, const auto& s, int, const auto& d, const auto&) {
                      if (s.law > 0) { return; }
                      energy += 0.5 * add_twice_energy(numbers_of<double>(s),
                                                       static_cast<double>(d.norm()), 0.0);
                    });
    return energy + law_energy(q) + cells_.energy(q.data());
  }
  [[nodiscard]] std::size_t spring_bytes() const noexcept override {
    return springs_.links.size() * sizeof(Link<Real>) +
           springs_.anchors.size() * sizeof(Anchor<Real>) +
           springs_.previous_length.size() * sizeof(Real) + slots_.size() * sizeof(slots_[0]) +
           diagonal_slots_.size() * sizeof(diagonal_slots_[0]) +
           static_cast<std::size_t>(next_force_.size()) * sizeof(Real) + groups_.memory_bytes() +
           cells_.memory_bytes() + laws_.memory_bytes();
  }
  /// Adds entries of the pattern that do not belong to nodes.
  virtual void add_entries(std::vector<Eigen::Triplet<Real>>& /*entries*/) const {}

 private:
  /// Returns the elastic energy of the springs that stiffen or relax [J].
  [[nodiscard]] double law_energy(const Vector<Real>& q) const noexcept {
    double energy = 0.0;
    if (laws_.empty()) { return energy; }
    for_each_spring(springs_, q.data(), q.data(),
                    [&](std::size_t index, const auto& s, int, const auto& d, const auto&) {
                      const int element = laws_.element(index);
                      if (element < 0) { return; }
                      energy += laws_.pull(s, element, static_cast<double>(d.norm())).energy;
                    });
    return energy;
  }
  void add_fixed_pairs() noexcept {
    if (!fixed_pairs_.links.empty()) {
      add_forces(fixed_pairs_, fixed_q_.data(), fixed_v_.data(), fixed_f_.data());
    }
  }
  static NodeLayout layout_of(const NetworkProblem& problem, const ListVectors& vectors) {
    const int spacing = vectors.spacing();
    const auto at = [&](Eigen::Index coordinate) {
      return coordinate < 0 ? coordinate : coordinate / 3 * spacing;
    };
    NodeLayout layout{.size = at(problem.dof()) + vectors.further, .stride = 1};
    for (int node = 0; node < problem.network().node_count(); ++node) {
      layout.first.push_back(static_cast<int>(at(problem.coordinate(node))));
    }
    if (vectors.padded) {
      const auto held =
          std::ranges::count_if(places_of(problem.network()), [](int place) { return place >= 0; });
      layout.size += adjacency::node_stride * held;
    }
    return layout;
  }
  void sort_springs(const NetworkProblem& problem, bool skip) {
    const NodeVectors& places = problem.held_position();
    const std::vector<int> places_behind = places_of(problem.network());
    const int free_end = static_cast<int>(problem.dof()) / 3 * spacing_;
    const auto first = [&](int node) {
      return this->layout().first[static_cast<std::size_t>(node)];
    };
    std::vector<Spring> between_fixed;
    for (const Spring& s : problem.network().springs) {
      int a = first(s.a);
      int b = first(s.b);
      int fixed_node = s.b;
      if (a < 0 && b < 0) {
        if (!skip) { between_fixed.push_back(s); }
        continue;
      }
      if (a < 0) {
        std::swap(a, b);
        fixed_node = s.a;
      }
      if (b >= 0) {
        springs_.links.push_back(s.between<Real>(a, b));
      } else {
        const int place = places_behind[static_cast<std::size_t>(fixed_node)];
        Anchor<Real> anchor{s.between<Real>(a, free_end + spacing_ * place)};
        for (int n = 0; n < 3; ++n) { anchor.place[n] = static_cast<Real>(places(n, fixed_node)); }
        springs_.anchors.push_back(anchor);
      }
    }
    // Nodes close in memory are close in space. A stable order makes sums reproducible.
    std::ranges::stable_sort(springs_.links, [](const auto& l, const auto& r) {
      return std::min(l.a, l.b) < std::min(r.a, r.b);
    });
    std::ranges::stable_sort(springs_.anchors, {}, &Anchor<Real>::a);
    if (between_fixed.empty()) { return; }
    const auto nodes = places.cols();
    fixed_q_ = Eigen::Map<const Eigen::VectorXd>(places.data(), 3 * nodes).template cast<Real>();
    fixed_v_.setZero(3 * nodes);
    fixed_f_.setZero(3 * nodes);
    for (const Spring& s : between_fixed) {
      fixed_pairs_.links.push_back(s.between<Real>(3 * s.a, 3 * s.b));
    }
  }
  void remember_lengths() {
    const Vector<Real> q = ListNetwork::initial_position();
    for_each_spring(springs_, q.data(), q.data(),
                    [&](std::size_t, const auto&, int, const auto& d, const auto&) {
                      springs_.previous_length.push_back(d.norm());
                    });
  }

  /// Returns an index for each fixed node with a spring to a free node, in node order; -1 for all
  /// other nodes.
  static std::vector<int> places_of(const SpringNetwork& network) {
    std::vector<int> places(static_cast<std::size_t>(network.node_count()), -1);
    const auto find = [&](int node, int other) {
      if (network.is_fixed(node) && !network.is_fixed(other)) {
        places[static_cast<std::size_t>(node)] = 0;
      }
    };
    for (const Spring& s : network.springs) {
      find(s.a, s.b);
      find(s.b, s.a);
    }
    int count = 0;
    for (int& place : places) {
      if (place == 0) { place = count++; }
    }
    return places;
  }

  int spacing_;  ///< offset between the coordinates of consecutive nodes
  SpringSet<Real> springs_;
  bool grouped_ = false;             ///< no printed form is selected
  AdjacencySprings<Real> groups_{};  ///< the springs without a law, if grouped_
  LawSprings<Real> laws_{};
  double last_time_ = 0.0;  ///< of the last state that was remembered [s]
  CellForces<Real> cells_{};
  bool damped_ = true;
  Vector<Real> next_force_;      ///< weight, between two one-pass steps [N]
  SpringSet<Real> fixed_pairs_;  ///< only with skip = false
  Vector<Real> fixed_q_, fixed_v_, fixed_f_;
  /// Entries of a matrix that a spring changes: the first rows of the three columns of its blocks
  /// (a,a) (b,b) (a,b) (b,a); an anchor has the first block only.
  std::vector<std::array<std::int64_t, 12>> slots_;
  std::vector<std::int64_t> diagonal_slots_;
};

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Relaxation of elastic tensions (model/EQUATIONS.md, "Relaxation").

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/material_law.hpp"

namespace palpate {

/// Relaxed tension of an element: share * T_e - held, with its elastic tension T_e.
struct Relaxed {
  double share = 1.0;
  double held = 0.0;
};

/// Relaxing tensions of elements, springs [N] or cells [Pa]. Each branch of an element keeps a
/// tension z with tau z' = T_e - z, so that T = T_e - sum of g z. Between two states T_e is linear
/// in time, for which z is integrated exactly (Taylor, Pister, Goudreau 1970). Before t = 0 the
/// tissue is at rest.
template <class Real> class Relaxation {
 public:
  /// Adds elements of a law after those added before. Allocates.
  void add(const MaterialLaw& law, std::size_t elements) {
    groups_.push_back({static_cast<Eigen::Index>(last_.size()),
                       static_cast<Eigen::Index>(elements),
                       law.branches,
                       {}});
    active_ = active_ || !law.branches.empty();
    last_.resize(last_.size() + elements);
    share_.resize(last_.size(), Real(1));
    held_.resize(last_.size(), Real(0));
    for (std::size_t n = 0; n < law.branches.size(); ++n) { filtered_[n].resize(last_.size()); }
  }
  [[nodiscard]] bool active() const noexcept { return active_; }
  /// Forgets the past: these elastic tensions have just begun to act.
  void restart(const Real* tension) noexcept {
    for (auto& z : filtered_) { std::ranges::fill(z, Real(0)); }
    begin(tension);
  }
  /// Takes the elastic tensions at the start, after which remember() gives those of later states.
  void begin(const Real* tension) noexcept {
    std::copy_n(tension, last_.size(), last_.begin());
    s_ = -1.0;
    at(0.0);
  }
  /// Prepares share() and held() for a state `s` seconds after the last one that was remembered.
  void at(double s) noexcept {
    if (s == s_) { return; }
    s_ = s;
    for (Group& group : groups_) {
      Real share = 1;
      Real before = 0;
      for (std::size_t n = 0; n < group.branches.size(); ++n) {
        const RelaxationBranch& branch = group.branches[n];
        const double x = s / branch.time;
        const double decay = std::exp(-x);
        const double mean = x > 0.0 ? -std::expm1(-x) / x : 1.0;
        group.weights[n] = {static_cast<Real>(decay), static_cast<Real>(mean - decay),
                            static_cast<Real>(1.0 - mean)};
        share -= static_cast<Real>(branch.share) * group.weights[n].now;
        before += static_cast<Real>(branch.share) * group.weights[n].before;
      }
      if (group.branches.empty()) { continue; }
      part(share_, group).setConstant(share);
      auto held = part(held_, group);
      held = before * part(last_, group);
      for (std::size_t n = 0; n < group.branches.size(); ++n) {
        const Real weight = static_cast<Real>(group.branches[n].share) * group.weights[n].decay;
        held += weight * part(filtered_[n], group);
      }
    }
  }
  /// Remembers the state that at() prepared, with these elastic tensions.
  void remember(const Real* tension) noexcept {
    for (const Group& group : groups_) {
      const Eigen::Map<const Numbers> now(tension + group.first, group.count);
      for (std::size_t n = 0; n < group.branches.size(); ++n) {
        const Weights& w = group.weights[n];
        auto z = part(filtered_[n], group);
        z = w.decay * z + w.before * part(last_, group) + w.now * now;
      }
    }
    begin(tension);
  }
  /// Takes the past of the same elements at the same state with other stiffnesses. The strains of
  /// the branches stay; scale(element) is the ratio of the new stiffness to that of `from`.
  template <class Scale> void continue_from(const Relaxation& from, Scale scale) noexcept {
    const auto take = [&](const auto& past, auto& now) {
      for (std::size_t n = 0; n < now.size(); ++n) { now[n] = scale(n) * past[n]; }
    };
    take(from.last_, last_);
    // A branch ends with the last group that has it.
    for (std::size_t n = 0; n < most_branches; ++n) { take(from.filtered_[n], filtered_[n]); }
    s_ = -1.0;
    at(0.0);
  }
  /// Returns true if both have the same elements in the same order, with the same branches.
  [[nodiscard]] bool resembles(const Relaxation& other) const {
    return std::ranges::equal(groups_, other.groups_, [](const Group& a, const Group& b) {
      return a.first == b.first && a.count == b.count && a.branches.size() == b.branches.size();
    });
  }
  [[nodiscard]] const Real* share() const noexcept { return share_.data(); }
  [[nodiscard]] const Real* held() const noexcept { return held_.data(); }
  [[nodiscard]] Relaxed of(std::size_t element) const noexcept {
    return {static_cast<double>(share_[element]), static_cast<double>(held_[element])};
  }
  /// Returns the energy of an element at the last remembered state: that of the lasting part and of
  /// the springs of the branches, whose extensions are (T_e - z) / k. With stiffening the latter is
  /// an approximation.
  [[nodiscard]] double energy(std::size_t element, double elastic, double tension,
                              double stiffness) const noexcept {
    const auto index = static_cast<Eigen::Index>(element);
    for (const Group& group : groups_) {
      if (group.branches.empty() || index < group.first || index >= group.first + group.count) {
        continue;
      }
      double energy = elastic;
      for (std::size_t n = 0; n < group.branches.size(); ++n) {
        const double in_branch = tension - static_cast<double>(filtered_[n][element]);
        energy += group.branches[n].share * (0.5 * in_branch * in_branch / stiffness - elastic);
      }
      return energy;
    }
    return elastic;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t numbers = last_.size() + share_.size() + held_.size();
    for (const auto& z : filtered_) { numbers += z.size(); }
    return numbers * sizeof(Real);
  }

 private:
  using Numbers = Eigen::Array<Real, Eigen::Dynamic, 1>;
  /// z at the new state: decay z + before T_e(last) + now T_e(new).
  struct Weights {
    Real decay, before, now;
  };
  struct Group {
    Eigen::Index first = 0;
    Eigen::Index count = 0;
    std::vector<RelaxationBranch> branches{};
    std::array<Weights, most_branches> weights{};
  };
  static Eigen::Map<Numbers> part(AlignedVector<Real>& all, const Group& group) noexcept {
    return {all.data() + group.first, group.count};
  }

  std::vector<Group> groups_{};
  AlignedVector<Real> last_{}, share_{}, held_{};
  std::array<AlignedVector<Real>, most_branches> filtered_{};  ///< z of each branch
  double s_ = -1.0;
  bool active_ = false;
};

}  // namespace palpate

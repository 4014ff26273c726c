// SPDX-License-Identifier: MIT
#pragma once
/// Springs of a list that stiffen or relax (model/EQUATIONS.md, "Stiffening", "Relaxation").

#include <algorithm>
#include <vector>

#include "model/kernels/instruction_set.hpp"
#include "model/kernels/relaxation.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/problem/cell_law.hpp"

namespace palpate {

template <class Real> class LawSprings {
 public:
  /// Takes the springs of a set that have a law; `q` is the initial position. Allocates.
  void take(const SpringSet<Real>& springs, const std::vector<MaterialLaw>& laws, const Real* q) {
    if constexpr (std::is_same_v<Real, float>) {
      kernels_ = kernels_here(&KernelSet::laws_float).front();
    } else {
      kernels_ = kernels_here(&KernelSet::laws_double).front();
    }
    laws_ = laws;
    element_.assign(springs.links.size() + springs.anchors.size(), -1);
    for (std::size_t law = 1; law <= laws.size(); ++law) {
      const std::size_t before = ends_.size();
      std::size_t index = 0;
      for (const Link<Real>& s : springs.links) {
        if (s.law == static_cast<int>(law)) { add(s, s.b, index); }
        ++index;
      }
      for (const Anchor<Real>& s : springs.anchors) {
        if (s.law == static_cast<int>(law)) {
          fixed_.insert(fixed_.end(), s.place, s.place + 3);
          add(s, 2 - static_cast<int>(fixed_.size()), index);
        }
        ++index;
      }
      if (ends_.size() > before) { complete(laws[law - 1], before); }
    }
    if (empty()) { return; }
    tension_.resize(numbers_.size() / 3);
    kernels_.tension(view(), q, tension_.data());
    relaxation_.begin(tension_.data());
  }
  [[nodiscard]] bool empty() const noexcept { return groups_.empty(); }
  /// Prepares the forces of a state `s` seconds after the last one that was remembered.
  void at(double s) noexcept {
    if (relaxation_.active()) { relaxation_.at(s); }
  }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) const noexcept {
    if (!empty()) { kernels_.force(view(), q, v, f); }
  }
  /// Remembers the state that at() prepared.
  void remember(const Real* q) noexcept {
    if (!relaxation_.active()) { return; }
    kernels_.tension(view(), q, tension_.data());
    relaxation_.remember(tension_.data());
  }
  /// Returns the element of a spring of the set, or -1 for a spring without a law.
  [[nodiscard]] int element(std::size_t index) const noexcept {
    return element_.empty() ? -1 : element_[index];
  }
  [[nodiscard]] Relaxed relaxed(int element) const noexcept {
    return relaxation_.of(static_cast<std::size_t>(element));
  }
  /// Returns the elastic part of a spring with a law at a length: tension and stiffness as they act
  /// now, and the energy at the last remembered state.
  [[nodiscard]] ElasticPull pull(const SpringOf<Real>& spring, int element,
                                 double length) const noexcept {
    const ElasticPull at_once =
        elastic_pull(laws_[static_cast<std::size_t>(spring.law - 1)], spring, length);
    const Relaxed now = relaxed(element);
    return {now.share * at_once.tension - now.held, now.share * at_once.stiffness,
            relaxation_.energy(static_cast<std::size_t>(element), at_once.energy, at_once.tension,
                               static_cast<double>(spring.stiffness))};
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return (ends_.size() + element_.size()) * sizeof(int) + relaxation_.memory_bytes() +
           (numbers_.size() + fixed_.size() + tension_.size()) * sizeof(Real);
  }

 private:
  void add(const SpringOf<Real>& spring, int end, std::size_t index) {
    const auto lanes = static_cast<std::size_t>(kernels_.lanes);
    const std::size_t lane = count_ % lanes;
    const std::size_t batch = count_ / lanes;
    if (lane == 0) {  // springs of zero stiffness fill the batch
      ends_.resize(2 * lanes * (batch + 1), spring.a);
      numbers_.resize(3 * lanes * (batch + 1), Real(0));
      std::fill_n(numbers_.end() - 2 * static_cast<std::ptrdiff_t>(lanes), lanes,
                  spring.rest_length);
    }
    element_[index] = static_cast<int>(count_++);
    ends_[(2 * batch + 1) * lanes + lane] = end;
    ends_[2 * batch * lanes + lane] = spring.a;
    Real* numbers = numbers_.data() + 3 * batch * lanes + lane;
    numbers[0] = spring.stiffness;
    numbers[lanes] = spring.rest_length;
    numbers[2 * lanes] = spring.viscosity;
  }
  /// Ends the springs of a law, which began where `ends_` had `before` elements.
  void complete(const MaterialLaw& law, std::size_t before) {
    const auto lanes = static_cast<std::size_t>(kernels_.lanes);
    const std::size_t batches = (ends_.size() - before) / (2 * lanes);
    groups_.push_back({static_cast<long>(batches), stiffening_numbers<Real>(law)});
    relaxation_.add(law, batches * lanes);
    count_ = ends_.size() / 2;
  }
  [[nodiscard]] laws::View<Real> view() const noexcept {
    return {.groups = groups_.data(),
            .count = static_cast<long>(groups_.size()),
            .ends = ends_.data(),
            .numbers = numbers_.data(),
            .share = relaxation_.share(),
            .held = relaxation_.held(),
            .fixed = fixed_.data()};
  }

  laws::Kernels<Real> kernels_{};
  std::vector<MaterialLaw> laws_{};
  std::vector<laws::Group<Real>> groups_{};
  std::vector<int> ends_{};      ///< as in laws::View
  std::vector<Real> numbers_{};  ///< as in laws::View
  std::vector<Real> fixed_{};    ///< as in laws::View
  std::vector<int> element_{};   ///< of each spring of the set
  std::vector<Real> tension_{};  ///< elastic tensions of the elements [N]
  std::size_t count_ = 0;
  Relaxation<Real> relaxation_{};
};

}  // namespace palpate

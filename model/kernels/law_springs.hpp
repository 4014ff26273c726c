// SPDX-License-Identifier: MIT
#pragma once
/// Springs of a list that stiffen or relax (model/EQUATIONS.md, "Stiffening", "Relaxation").

#include <algorithm>
#include <vector>

#include "model/kernels/relaxation.hpp"
#include "model/kernels/spring_kernels.hpp"

namespace palpate {

template <class Real> class LawSprings {
 public:
  /// Takes the springs of a set that have a law; `q` is the initial position, with `spacing`
  /// numbers per node as in AdjacencySprings::take(). Allocates.
  void take(const SpringSet<Real>& springs, const std::vector<MaterialLaw>& laws, int spacing,
            const Real* q) {
    element_.assign(springs.links.size() + springs.anchors.size(), -1);
    for (std::size_t n = 0; n < laws.size(); ++n) {
      Part part;
      part.law = laws[n];
      part.stiffening = stiffening_numbers<Real>(laws[n]);
      part.first = tension_.size();
      part.springs.take(springs, true, spacing, static_cast<int>(n + 1));
      for (std::size_t spring = 0; spring < element_.size(); ++spring) {
        const int lane = part.springs.lane_of(spring);
        if (lane >= 0) { element_[spring] = static_cast<int>(part.first) + lane; }
      }
      tension_.resize(tension_.size() + part.springs.lanes());
      stiffness_.resize(tension_.size(), Real(1));
      relaxation_.add(laws[n], part.springs.lanes());
      parts_.push_back(std::move(part));
    }
    std::size_t spring = 0;
    for (const auto& link : springs.links) { take_stiffness(spring++, link.stiffness); }
    for (const auto& anchor : springs.anchors) { take_stiffness(spring++, anchor.stiffness); }
    find_tensions(q);
    relaxation_.begin(tension_.data());
  }
  /// Takes the relaxation of the same springs with other stiffnesses at the same state.
  void continue_from(const LawSprings& from) noexcept {
    if (!relaxation_.active()) { return; }
    relaxation_.continue_from(from.relaxation_,
                              [&](std::size_t n) { return stiffness_[n] / from.stiffness_[n]; });
  }
  [[nodiscard]] bool resembles(const LawSprings& other) const {
    return relaxation_.resembles(other.relaxation_);
  }
  [[nodiscard]] bool empty() const noexcept { return parts_.empty(); }
  /// Prepares the forces of a state `s` seconds after the last one that was remembered.
  void at(double s) noexcept {
    if (relaxation_.active()) { relaxation_.at(s); }
  }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept {
    for (Part& part : parts_) { part.springs.add_law(view(part), q, v, f); }
  }
  /// Remembers the state that at() prepared.
  void remember(const Real* q) noexcept {
    if (!relaxation_.active()) { return; }
    find_tensions(q);
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
    const MaterialLaw& law = parts_[static_cast<std::size_t>(spring.law - 1)].law;
    const ElasticPull at_once = elastic_pull(law, spring, length);
    const Relaxed now = relaxed(element);
    return {now.share * at_once.tension - now.held, now.share * at_once.stiffness,
            relaxation_.energy(static_cast<std::size_t>(element), at_once.energy, at_once.tension,
                               static_cast<double>(spring.stiffness))};
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    std::size_t bytes = element_.size() * sizeof(int) + 2 * tension_.size() * sizeof(Real) +
                        relaxation_.memory_bytes();
    for (const Part& part : parts_) { bytes += part.springs.memory_bytes(); }
    return bytes;
  }

 private:
  /// Springs of one law; their elements are the lanes of their batches, from `first` on.
  struct Part {
    MaterialLaw law{};
    StiffeningNumbers<Real> stiffening{};
    std::size_t first = 0;
    AdjacencySprings<Real> springs{};
  };
  void take_stiffness(std::size_t spring, Real stiffness) {
    if (element_[spring] >= 0) {
      stiffness_[static_cast<std::size_t>(element_[spring])] = stiffness;
    }
  }
  void find_tensions(const Real* q) noexcept {
    for (Part& part : parts_) { part.springs.find_tensions(view(part), q); }
  }
  [[nodiscard]] adjacency::View<Real> view(const Part& part) noexcept {
    return {.stiffening = part.stiffening,
            .share = relaxation_.share() + part.first,
            .held = relaxation_.held() + part.first,
            .tension = tension_.data() + part.first};
  }

  std::vector<Part> parts_{};
  std::vector<int> element_{};     ///< of each spring of the set
  AlignedVector<Real> tension_{};  ///< elastic tensions of the elements [N]
  std::vector<Real> stiffness_{};  ///< of the elements [N/m]
  Relaxation<Real> relaxation_{};
};

}  // namespace palpate

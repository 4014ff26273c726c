// SPDX-License-Identifier: MIT
#pragma once
/// Anderson acceleration of a preconditioned iteration (model/EQUATIONS.md, "Solver of a step").

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/kernels/system.hpp"

namespace palpate {

/// Solves r(x) = 0 by steps from the corrections c = P^-1 r(x) of a fixed preconditioner P. Pairs
/// of a step and the change of c that it caused replace the Jacobian. They are kept for the next
/// system, which differs little from this one.
template <class Real> class AndersonIteration {
 public:
  /// Allocates the workspace.
  void prepare(Eigen::Index dof) {
    for (Vector<Real>* vector : {&best_place_, &best_correction_, &correction_, &step_}) {
      vector->setZero(dof);
    }
    moves_.setZero(dof, most_pairs);
    changes_.setZero(dof, most_pairs);
  }
  /// Discards the pairs; call it if P or the equations have changed.
  void forget() noexcept { pairs_ = 0; }
  /// Begins the solution of another system.
  void start() noexcept {
    started_ = false;
    returns_ = 0;
  }
  /// Replaces the correction at x by the step to the next x. If the correction is much larger than
  /// the smallest one so far, sets x back to the place of that one and gives a shorter step.
  /// Returns the ratio of this correction to the one before: 0 for the first, 1 after a return.
  Real advance(Vector<Real>& x, Vector<Real>& correction) noexcept {
    const Real size = correction.template lpNorm<Eigen::Infinity>();
    Real ratio = Real(0);
    if (started_) {
      learn(correction);
      ratio = size_ > Real(0) ? size / size_ : Real(0);
    }
    size_ = size;
    if (!started_ || size <= smallest_) {
      reach_ = started_ ? 2 * reach_ : std::numeric_limits<Real>::infinity();
      smallest_ = size;
      best_place_ = x;
      best_correction_ = correction;
    } else if (size > most_growth * smallest_) {
      // Pairs of another system are the first suspects, the length of the step is the second.
      if (++returns_ == 1) {
        forget();
      } else {
        reach_ = step_.template lpNorm<Eigen::Infinity>() / 4;
      }
      ratio = Real(1);
      size_ = smallest_;
      x = best_place_;
      correction = best_correction_;
    }
    started_ = true;
    correction_ = correction;
    extrapolate(correction);
    const Real length = correction.template lpNorm<Eigen::Infinity>();
    if (length > reach_) { correction *= reach_ / length; }
    step_ = correction;
    return ratio;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return static_cast<std::size_t>(moves_.size() + changes_.size() + 4 * step_.size()) *
           sizeof(Real);
  }

 private:
  static constexpr int most_pairs = 8;
  /// Growth of the correction above which a step is taken back.
  static constexpr Real most_growth = 4;
  /// Squared sine of the angle between a change and the newer ones below which it is not used.
  static constexpr double least_angle = 1e-4;
  using Small = std::array<std::array<double, most_pairs>, most_pairs>;

  [[nodiscard]] static std::size_t at(int n) { return static_cast<std::size_t>(n); }
  /// Keeps the last step and the change of the correction, in place of the oldest pair. Both are
  /// scaled so that the change has length one.
  void learn(const Vector<Real>& correction) noexcept {
    const int next = pairs_ == 0 ? 0 : (newest_ + 1) % most_pairs;
    auto change = changes_.col(next);
    change = correction_ - correction;
    const Real length = change.norm();
    if (!(length > Real(0) && length < std::numeric_limits<Real>::infinity())) {
      forget();
      return;
    }
    change /= length;
    moves_.col(next) = step_ / length;
    newest_ = next;
    pairs_ = std::max(pairs_, next + 1);
    for (int n = 0; n < pairs_; ++n) {
      gram_[at(n)][at(next)] = gram_[at(next)][at(n)] =
          static_cast<double>(changes_.col(n).dot(change));
    }
  }
  /// Adds to a correction what the pairs say of the Jacobian: with the combination of changes that
  /// is nearest to the correction, the step is the same combination of moves plus what remains of
  /// the correction. Uses the Cholesky factors of the Gram matrix, the newest pair first.
  void extrapolate(Vector<Real>& correction) const noexcept {
    Small factor{};
    std::array<int, most_pairs> used{};
    std::array<double, most_pairs> share{};
    int count = 0;
    for (int age = 0; age < pairs_; ++age) {
      const int pair = (newest_ - age + pairs_) % pairs_;
      double pivot = 1.0;
      for (int m = 0; m < count; ++m) {
        double sum = gram_[at(pair)][at(used[at(m)])];
        for (int k = 0; k < m; ++k) { sum -= factor[at(count)][at(k)] * factor[at(m)][at(k)]; }
        factor[at(count)][at(m)] = sum / factor[at(m)][at(m)];
        pivot -= factor[at(count)][at(m)] * factor[at(count)][at(m)];
      }
      if (pivot < least_angle) { continue; }
      factor[at(count)][at(count)] = std::sqrt(pivot);
      used[at(count++)] = pair;
    }
    for (int m = 0; m < count; ++m) {
      share[at(m)] = static_cast<double>(changes_.col(used[at(m)]).dot(correction_));
      for (int k = 0; k < m; ++k) { share[at(m)] -= factor[at(m)][at(k)] * share[at(k)]; }
      share[at(m)] /= factor[at(m)][at(m)];
    }
    for (int m = count - 1; m >= 0; --m) {
      for (int k = m + 1; k < count; ++k) { share[at(m)] -= factor[at(k)][at(m)] * share[at(k)]; }
      share[at(m)] /= factor[at(m)][at(m)];
    }
    for (int m = 0; m < count; ++m) {
      correction +=
          static_cast<Real>(share[at(m)]) * (moves_.col(used[at(m)]) - changes_.col(used[at(m)]));
    }
  }

  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> moves_, changes_;  ///< one pair a column
  Small gram_{};                                                         ///< of the changes
  int pairs_ = 0;
  int newest_ = 0;  ///< column of the newest pair
  bool started_ = false;
  int returns_ = 0;
  Real size_ = Real(0);      ///< of the last correction
  Real smallest_ = Real(0);  ///< correction of this system, that at best_place_
  Real reach_ = Real(0);     ///< longest step
  Vector<Real> best_place_, best_correction_, correction_, step_;
};

}  // namespace palpate

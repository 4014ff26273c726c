// SPDX-License-Identifier: MIT
#pragma once
/// Generalised Pareto distribution of excesses over a threshold, P(Y > y) = (1 + xi y / sigma)^(-1
/// / xi) (Pickands, Annals of Statistics 3, 1975), fitted by maximum likelihood.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/certificate/paced_loop.hpp"
#include "validation/outcome.hpp"

namespace palpate::certificate {

struct ParetoFit {
  double shape = 0.0;  ///< xi
  double scale = 0.0;  ///< sigma, in the unit of the excesses
  double log_likelihood = 0.0;
  std::size_t count = 0;

  /// Returns the asymptotic standard error of the shape, (1 + xi) / sqrt(n) (Smith, Biometrika 72,
  /// 1985).
  [[nodiscard]] double shape_error() const;
  /// Returns P(Y > y).
  [[nodiscard]] double exceeded(double y) const;
  /// Returns the excess that is exceeded with probability q.
  [[nodiscard]] double excess_at(double q) const;
};

/// Fits the distribution to at least two excesses > 0 that are not all equal. The shape is searched
/// from -0.5, below which the likelihood has no regular maximum, to 3.
ParetoFit fit_pareto(std::span<const double> excess);

struct ExcessInterval {
  double lower = 0.0;
  double upper = 0.0;  ///< infinite if unbounded
};

/// Returns the confidence interval of the excess at q: all values whose profile log likelihood is
/// within half the chi-squared quantile (one degree of freedom, `confidence`) of the maximum
/// (Coles, An Introduction to Statistical Modeling of Extreme Values, 2001, section 4.3.3).
ExcessInterval excess_interval(const ParetoFit& fit, std::span<const double> excess, double q,
                               double confidence);

// Extrapolation of response times by peaks over a threshold and a generalised Pareto distribution.
// It is refused where the data contradict an assumption of the method (Cazorla et al.,
// OASIcs.WCET.2013.64, give the reasons).

/// A fit above one threshold [s].
struct ThresholdFit {
  double threshold = 0.0;
  ParetoFit fit{};
};

/// The response time that one tick in 1 / probability exceeds [s].
struct ReturnLevel {
  double probability = 0.0;
  double value = 0.0;
  double lower = 0.0;  ///< at 95 %
  double upper = 0.0;
};

struct Tail {
  std::string refusal{};              ///< why there are no levels; empty if there are
  std::vector<Quantity> checks{};     ///< assumptions of the method; bound_from says what must hold
  std::vector<ThresholdFit> fits{};   ///< lowest threshold first; the levels are from that
  std::vector<ReturnLevel> levels{};  ///< one and two decades beyond the data
  /// Probability that a response exceeds the deadline. Absent if it is below 1 / (100 x number of
  /// ticks), where the data allow no statement.
  std::optional<double> beyond_deadline{};
};

/// Minimum number of ticks for an extrapolation: three thresholds, 50 excesses over the highest.
inline constexpr long least_ticks_of_tail = 4000;
/// Probability of each check that it rejects a true assumption.
inline constexpr double false_alarm = 1e-3;

/// Extrapolates from the largest responses of `ticks` ticks, sorted in descending order.
Tail judge_tail(std::span<const LargeTick> largest, long ticks, double deadline);

// Assumptions of the extrapolation about excesses over a threshold, each as a bounded quantity.

/// Response times above a threshold in the order of time.
struct Exceedances {
  double threshold = 0.0;  ///< [s]
  std::vector<LargeTick> ticks{};
  long of = 0;  ///< total number of ticks

  [[nodiscard]] std::size_t count() const { return ticks.size(); }
  [[nodiscard]] std::vector<double> excess() const;  ///< [s]
  /// Returns the excesses of one half of the time.
  [[nodiscard]] Exceedances half(bool second) const;
};

/// Returns the `count` largest of a list sorted in descending order; the next one is the threshold.
Exceedances exceedances(std::span<const LargeTick> largest, std::size_t count, long ticks);

/// Returns the extremal index (Ferro & Segers, Journal of the Royal Statistical Society B 65,
/// 2003): 1 for isolated excesses, 1/m for clusters of m.
double extremal_index(const Exceedances& all);

std::vector<Quantity> independence_checks(const Exceedances& all);
std::vector<Quantity> stationarity_checks(const Exceedances& all);

}  // namespace palpate::certificate

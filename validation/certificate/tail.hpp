// SPDX-License-Identifier: MIT
#pragma once
/// The generalised Pareto distribution of excesses over a threshold, P(Y > y) = (1 + xi y /
/// sigma)^(-1 / xi) (Pickands, Annals of Statistics 3, 1975), by maximum likelihood.

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

  /// Standard error of the shape, asymptotic: (1 + xi) / sqrt(n) (Smith, Biometrika 72, 1985).
  [[nodiscard]] double shape_error() const;
  /// P(Y > y).
  [[nodiscard]] double exceeded(double y) const;
  /// The excess that is exceeded with probability q.
  [[nodiscard]] double excess_at(double q) const;
};

/// Of at least two excesses > 0, not all alike. The shape is looked for from -0.5, below which the
/// likelihood has no regular maximum, to 3.
ParetoFit fit_pareto(std::span<const double> excess);

struct ExcessInterval {
  double lower = 0.0;
  double upper = 0.0;  ///< infinite where nothing bounds it
};

/// What excesses allow the one at q to be: all values whose profile likelihood lies within half the
/// quantile of chi-squared with one degree of freedom at `confidence` of the largest (Coles, An
/// Introduction to Statistical Modeling of Extreme Values, 2001, section 4.3.3).
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
  std::string refusal{};              ///< why there are no levels; empty: there are
  std::vector<Quantity> checks{};     ///< assumptions of the method; bound_from says what must hold
  std::vector<ThresholdFit> fits{};   ///< lowest threshold first; the levels are from that
  std::vector<ReturnLevel> levels{};  ///< one and two decades beyond the data
  /// That a response exceeds the deadline; empty where that is rarer than one in a hundred times
  /// the ticks that were seen, about which nothing is said.
  std::optional<double> beyond_deadline{};
};

/// Fewest ticks with which there is any answer: three thresholds, 50 excesses over the highest.
inline constexpr long least_ticks_of_tail = 4000;
/// Of each check, that it contradicts what is true.
inline constexpr double false_alarm = 1e-3;

/// Of the largest responses of `ticks` ticks, largest first.
Tail judge_tail(std::span<const LargeTick> largest, long ticks, double deadline);

// Assumptions of the extrapolation about excesses over a threshold, each as a bounded quantity.

/// Response times above a threshold, in the order of time.
struct Exceedances {
  double threshold = 0.0;  ///< [s]
  std::vector<LargeTick> ticks{};
  long of = 0;  ///< ticks in all

  [[nodiscard]] std::size_t count() const { return ticks.size(); }
  [[nodiscard]] std::vector<double> excess() const;  ///< [s]
  /// Those of one half of the time.
  [[nodiscard]] Exceedances half(bool second) const;
};

/// The `count` largest of a list with the largest first; the one after them is the threshold.
Exceedances exceedances(std::span<const LargeTick> largest, std::size_t count, long ticks);

/// Ferro & Segers, Journal of the Royal Statistical Society B 65, 2003: 1 where excesses come
/// alone, 1/m where they come in clusters of m.
double extremal_index(const Exceedances& all);

std::vector<Quantity> independence_checks(const Exceedances& all);
std::vector<Quantity> stationarity_checks(const Exceedances& all);

}  // namespace palpate::certificate

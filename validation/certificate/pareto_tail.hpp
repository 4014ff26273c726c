// SPDX-License-Identifier: MIT
#pragma once
/// The generalised Pareto distribution of excesses over a threshold, P(Y > y) = (1 + xi y / sigma)^(-1 / xi)
/// (Pickands, Annals of Statistics 3, 1975), by maximum likelihood.

#include <cstddef>
#include <span>

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

/// Of at least two excesses > 0, not all alike. The shape is looked for from -0.5, below which the likelihood
/// has no regular maximum, to 3.
ParetoFit fit_pareto(std::span<const double> excess);

struct ExcessInterval {
  double lower = 0.0;
  double upper = 0.0;  ///< infinite where nothing bounds it
};

/// What excesses allow the one at q to be: all values whose profile likelihood lies within half the quantile
/// of chi-squared with one degree of freedom at `confidence` of the largest (Coles, An Introduction to
/// Statistical Modeling of Extreme Values, 2001, section 4.3.3).
ExcessInterval excess_interval(const ParetoFit& fit, std::span<const double> excess, double q,
                               double confidence);

}  // namespace palpate::certificate

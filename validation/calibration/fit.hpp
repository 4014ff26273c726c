// SPDX-License-Identifier: MIT
#pragma once
/// Linearised posterior of fitted parameters. Parameters are standardised, so the prior of each has
/// variance 1.

#include <Eigen/Core>
#include <vector>

#include "reference/least_squares.hpp"
#include "validation/calibration/forward.hpp"
#include "validation/calibration/observation.hpp"
#include "validation/statistics.hpp"

namespace palpate::calibration {

/// Linearisation at the fit, one row per available observable.
struct Linearised {
  Eigen::MatrixXd slope{};       ///< J of the fitted parameters
  Eigen::MatrixXd considered{};  ///< J of the parameters kept at their prior
  Eigen::MatrixXd covariance{};  ///< full covariance C of the fitted means
};

/// Returns the posterior covariance. The fit weights rows by their own variances, w = 1 / C_ii: x =
/// G (y - f) with G = H^-1 J^T w, H = J^T w J + 1. The covariance is G (C + J_c J_c^T) G^T + H^-2
/// for correlated rows, parameters kept at their prior, and the prior ("consider covariance",
/// Schmidt 1966; sandwich of Huber 1967).
Eigen::MatrixXd posterior_covariance(const Linearised& at);

/// Returns G c G^T, the contribution of one part c of the covariance of the rows.
Eigen::MatrixXd passed_on(const Linearised& at, const Eigen::MatrixXd& part);

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

/// Returns the `candidates` (columns of `slope`) that the data constrain: fitted without the
/// others, each has less than half of its prior variance. The least constrained ones are removed
/// one by one.
std::vector<Eigen::Index> told_columns(const Eigen::MatrixXd& slope,
                                       const Eigen::MatrixXd& covariance,
                                       std::vector<Eigen::Index> candidates);

// Least-squares problem of a fit: some parameters free, the others fixed, priors as rows.

class Search {
 public:
  /// `free` are indices of the forward model's parameters.
  Search(Forward& forward, const Pooled& data, std::vector<std::size_t> free);

  struct Found {
    Forward::Values values{};
    double cost = 0.0;  ///< sum of squares of rows and priors
    std::size_t iterations = 0;
    bool converged = false;
  };
  /// Minimises from these values; parameters that are not free keep theirs.
  Found from(const Forward::Values& start, const reference::LeastSquaresRule& rule = {}) const;

  /// Returns the standardised slopes d f / d x of these parameters, one column each, one row per
  /// observable.
  [[nodiscard]] Eigen::MatrixXd slopes(const Forward::Values& at,
                                       const std::vector<std::size_t>& of) const;
  /// Returns the covariance of the rows.
  [[nodiscard]] Eigen::MatrixXd covariance() const { return data_.covariance(rows_, rows_); }
  /// Returns (simulated - observed) over the standard uncertainty of each row.
  [[nodiscard]] Eigen::VectorXd misfits(const Observation& simulated) const;

 private:
  [[nodiscard]] const Parameter& free_parameter(Eigen::Index n) const {
    return forward_.parameters()[free_[static_cast<std::size_t>(n)]];
  }
  [[nodiscard]] Forward::Values values_at(const Forward::Values& base,
                                          const Eigen::VectorXd& q) const;
  [[nodiscard]] Eigen::VectorXd residuals(const Forward::Values& at) const;
  [[nodiscard]] Eigen::MatrixXd jacobian(const Forward::Values& at, const Eigen::VectorXd& q) const;

  Forward& forward_;
  const Pooled& data_;
  std::vector<std::size_t> free_;
  std::vector<Eigen::Index> rows_;
  Eigen::VectorXd deviation_;  ///< standard uncertainty of each row
};

// Fit of scene parameters to recordings: parameters that the data constrain are fitted, the others
// keep their prior value (docs/calibration.md).

enum class Telling {
  told,         ///< constrained by the data and fitted
  insensitive,  ///< one prior spread changes the observables by less than their uncertainty
  wide,  ///< data leave half of the prior variance or more: other parameters have the same effect
};
std::string_view name_of(Telling telling);

struct FittedParameter {
  Parameter parameter{};
  Telling telling = Telling::insensitive;
  double value = 0.0;        ///< prior value if it is not constrained
  double sensitivity = 0.0;  ///< effect of one prior spread, in uncertainties
  double deviation = 1.0;    ///< standard deviation of the logarithm over the prior spread [1]
  double interval_factor = normal_factor;  ///< half width of the interval in standard deviations
  comparison::Interval interval{};         ///< 95 % interval; of the prior if it is not constrained
  bool at_bound = false;
};

struct Fit {
  std::vector<FittedParameter> parameters{};  ///< in the order of the forward model
  std::vector<std::size_t> told{};            ///< indices of the constrained parameters
  Eigen::MatrixXd correlation{};     ///< correlation of the constrained parameters, in their order
  std::vector<Eigen::Index> rows{};  ///< fitted observables
  Pooled data{};
  Observation before{};        ///< simulated at the priors
  Observation after{};         ///< simulated at the fit
  double misfit_before = 0.0;  ///< sum of squares over uncertainties, rows only
  double misfit_after = 0.0;
  double widening = 1.0;  ///< factor on intervals if the misfit is larger than chance
  std::size_t iterations = 0;
  bool converged = false;

  [[nodiscard]] Forward::Values values() const;
};

/// Fits the parameters. Throws the runtime_error of the forward model, and invalid_argument if
/// there is nothing to fit.
Fit fit(Forward& forward, const Pooled& data);

}  // namespace palpate::calibration

// SPDX-License-Identifier: MIT
#pragma once
/// What is known of parameters after a fit, from its linearisation alone. Parameters are
/// standardised, so the prior of each has variance 1.

#include <Eigen/Core>
#include <vector>

#include "reference/least_squares.hpp"
#include "validation/calibration/forward.hpp"
#include "validation/calibration/observation.hpp"
#include "validation/statistics.hpp"

namespace palpate::calibration {

/// Around the place of the fit, one row per observable that is there.
struct Linearised {
  Eigen::MatrixXd slope{};       ///< J, of the parameters that are fitted
  Eigen::MatrixXd considered{};  ///< J of those left at their prior, whose uncertainty stays
  Eigen::MatrixXd covariance{};  ///< C of the means that were fitted, in full
};

/// The fit weighs rows by their own variances, w = 1 / C_ii, and so is x = G (y - f) with
/// G = H^-1 J^T w, H = J^T w J + 1. What it passes on is
///   G (C + J_c J_c^T) G^T + H^-2
/// of correlated rows, of the parameters that were left, and of the prior ("consider covariance",
/// Schmidt 1966; sandwich of Huber 1967).
Eigen::MatrixXd posterior_covariance(const Linearised& at);

/// G c G^T: what one part c of the rows' covariance passes on.
Eigen::MatrixXd passed_on(const Linearised& at, const Eigen::MatrixXd& part);

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

/// Those of `candidates` (columns of `slope`) that data tell: fitted without the others, each has
/// less than half of its prior variance, so that data say more than the prior. The worst are left
/// one by one.
std::vector<Eigen::Index> told_columns(const Eigen::MatrixXd& slope,
                                       const Eigen::MatrixXd& covariance,
                                       std::vector<Eigen::Index> candidates);

/// The columns of a matrix in this order, and those that are left.
Eigen::MatrixXd columns_of(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& columns);
Eigen::MatrixXd columns_besides(const Eigen::MatrixXd& matrix,
                                const std::vector<Eigen::Index>& columns);

// The least squares problem behind a fit: some parameters free, the others held, priors as rows.

class Search {
 public:
  /// `free` are indices of the forward model's parameters.
  Search(Forward& forward, const Pooled& data, std::vector<std::size_t> free);

  struct Found {
    Forward::Values values{};
    double cost = 0.0;  ///< sum of squares, rows and priors
    std::size_t iterations = 0;
    bool converged = false;
  };
  /// From these values; those that are not free stay as they are.
  Found from(const Forward::Values& start, const reference::LeastSquaresRule& rule = {}) const;

  /// Standardised slopes d f / d x of these parameters, one column each, rows of the data.
  [[nodiscard]] Eigen::MatrixXd slopes(const Forward::Values& at,
                                       const std::vector<std::size_t>& of) const;
  [[nodiscard]] Eigen::VectorXd rows_of(const Observation& observation) const;
  [[nodiscard]] const std::vector<Eigen::Index>& rows() const { return rows_; }
  [[nodiscard]] Eigen::MatrixXd covariance() const { return rows_of(data_.covariance); }
  [[nodiscard]] Eigen::MatrixXd rows_of(const Eigen::MatrixXd& covariance) const;
  /// (simulated - seen) over the standard uncertainty of each row.
  [[nodiscard]] Eigen::VectorXd misfits(const Observation& simulated) const;

 private:
  [[nodiscard]] Forward::Values values_at(const Forward::Values& base,
                                          const Eigen::VectorXd& q) const;
  [[nodiscard]] Eigen::VectorXd residuals(const Forward::Values& at) const;
  [[nodiscard]] Eigen::MatrixXd jacobian(const Forward::Values& at, const Eigen::VectorXd& q) const;

  Forward& forward_;
  const Pooled& data_;
  std::vector<std::size_t> free_;
  std::vector<Eigen::Index> rows_{};
  Eigen::VectorXd deviation_{};  ///< standard uncertainty of each row
};

// Parameters of a scene from recordings: what they can tell is fitted, the rest stays at its prior
// and is named. docs/calibration.md says how.

enum class Telling {
  told,         ///< fitted
  insensitive,  ///< one spread of the prior moves all that was seen by less than its uncertainty
  wide,         ///< data leave half of the prior variance or more: other parameters do the same
};
std::string_view name_of(Telling telling);

struct FittedParameter {
  Parameter parameter{};
  Telling telling = Telling::insensitive;
  double value = 0.0;        ///< the prior's where it is not told
  double sensitivity = 0.0;  ///< what one spread of the prior moves, in uncertainties
  double deviation = 1.0;    ///< standard, of the logarithm over the prior's spread [1]
  double interval_factor = normal_factor;  ///< deviations that the interval reaches to either side
  comparison::Interval interval{};         ///< 95 %; of the prior where it is not told
  bool at_bound = false;
};

struct Fit {
  std::vector<FittedParameter> parameters{};  ///< in the order of the forward model
  std::vector<std::size_t> told{};            ///< indices of these
  Eigen::MatrixXd correlation{};              ///< of those told, in their order
  std::vector<Eigen::Index> rows{};           ///< observables that were fitted
  Pooled data{};
  Observation before{};        ///< simulated at the priors
  Observation after{};         ///< simulated at the fit
  double misfit_before = 0.0;  ///< sum of squares over uncertainties, of the rows alone
  double misfit_after = 0.0;
  double widening = 1.0;  ///< of intervals, where the misfit is more than chance
  std::size_t iterations = 0;
  bool converged = false;

  [[nodiscard]] Forward::Values values() const;
};

/// Throws runtime_error of the forward model, and invalid_argument where there is nothing to fit.
Fit fit(Forward& forward, const Pooled& data);

}  // namespace palpate::calibration

// SPDX-License-Identifier: MIT
#pragma once
/// Calibration of a scene with recordings, and checks of the fit: profile of the misfit and
/// prediction of groups that were left out.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "reference/least_squares.hpp"
#include "validation/calibration/forward.hpp"
#include "validation/calibration/observation.hpp"
#include "validation/outcome.hpp"
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
  /// observable. A difference is taken to the other side if an observable is NaN; the slope is zero
  /// if it is NaN on both.
  [[nodiscard]] Eigen::MatrixXd slopes(const Forward::Values& at,
                                       const std::vector<std::size_t>& of) const;
  /// Returns the covariance of the rows.
  [[nodiscard]] Eigen::MatrixXd covariance() const { return data_.covariance(rows_, rows_); }
  /// Returns (simulated - observed) over the standard uncertainty of each row; simulated is 0 if it
  /// is NaN, so that a search turns back.
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

/// Fits the parameters, from their priors or from `start`. Throws the runtime_error of the forward
/// model, and invalid_argument if there is nothing to fit.
Fit fit(Forward& forward, const Pooled& data, const Forward::Values& start = {},
        const reference::LeastSquaresRule& rule = {});

/// Misfit for values of one parameter around its fit, with the other constrained parameters fitted
/// again at each value.
struct Profile {
  std::size_t parameter = 0;  ///< index
  std::vector<double> value{};
  std::vector<double> growth{};  ///< of the sum of squares, priors included, over that of the fit
};
/// Profile of the constrained parameter with the largest posterior deviation relative to its prior
/// spread; empty if none is constrained.
Profile profile_of_worst(Forward& forward, const Fit& fit);

/// Prediction of one group by a fit to the others.
struct HeldOut {
  std::string group{};
  std::size_t subjects = 0;
  Pooled seen{};                 ///< observations of the group that was left out
  Observation predicted{};       ///< depth of loss corrected for the difference in body mass index
  double error_fitted = 0.0;     ///< relative root mean square over observables, fitted groups
  double error_predicted = 0.0;  ///< the same for the group that was left out
  bool converged = false;
};

/// Returns the names of the groups in the order of the recordings.
std::vector<std::string> groups_of(std::span<const ObservedRecording> subjects);

/// Fits the constrained parameters again without each group in turn; empty for fewer than two
/// groups.
std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const ObservedRecording> subjects,
                                      const SharedUncertainty& shared = {});

/// Returns the relative error of every observable that both have; NaN elsewhere.
Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen);
double root_mean_square(const Eigen::VectorXd& values);  ///< of the finite values

struct CalibrationOptions {
  Coarsening coarsening{};
  SharedUncertainty shared{};
  int jobs = 2;
  const std::atomic<bool>* stop = nullptr;
  std::function<void(const char* stage)> progress{};
  Forward::Simulate simulate{};  ///< replaces the simulation, for planted faults
};

struct Calibration {
  Fit fit{};
  Profile profile{};
  std::vector<HeldOut> held_out{};
  Scene fitted{};       ///< the scene with the values of the fit
  Observation whole{};  ///< the fitted scene with its own block and step, until the run ends
  std::size_t simulations = 0;  ///< number of simulations of the coarser scene

  /// Largest change of an observable by the shortcuts, divided by its uncertainty.
  [[nodiscard]] double shortcut_cost() const;
  /// The verdict: the search converged, at least one parameter is constrained, none is at a bound,
  /// the misfit did not grow, its root mean square is at most two uncertainties, and the shortcuts
  /// change each observable by less than its uncertainty.
  [[nodiscard]] Outcome outcome() const;
};

/// Calibrates a scene. Every recording must have observables (no refusal); `parameters` is a subset
/// of parameters_of(), possibly with changed priors. Throws runtime_error if the scene cannot be
/// simulated at the tested values, and Interrupted on a stop.
Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const ObservedRecording> recordings,
                      const CalibrationOptions& options = {});

}  // namespace palpate::calibration

// SPDX-License-Identifier: MIT
#pragma once
/// Parameters of a scene from recordings: what they can tell is fitted, the rest stays at its prior and is
/// named. docs/calibration.md says how.

#include "validation/calibration/forward.hpp"
#include "validation/calibration/pooled.hpp"
#include "validation/calibration/search.hpp"
#include "validation/comparison/statistics.hpp"

namespace palpate::calibration {

enum class Telling {
  told,         ///< fitted
  insensitive,  ///< one spread of the prior moves all that was seen by less than its uncertainty
  wide,         ///< data leave half of the prior variance or more: other parameters do the same
};
std::string_view name_of(Telling telling);

struct FittedParameter {
  Parameter parameter{};
  Telling telling = Telling::insensitive;
  double value = 0.0;                      ///< the prior's where it is not told
  double sensitivity = 0.0;                ///< what one spread of the prior moves, in uncertainties
  double deviation = 1.0;                  ///< standard, of the logarithm over the prior's spread [1]
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

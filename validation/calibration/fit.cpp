// SPDX-License-Identifier: MIT
#include "validation/calibration/fit.hpp"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <stdexcept>

#include "validation/calibration/posterior.hpp"

namespace palpate::calibration {
namespace {

constexpr double level = 0.95;

std::vector<std::size_t> all_of(const Forward& forward) {
  std::vector<std::size_t> all;
  for (std::size_t n = 0; n < forward.parameters().size(); ++n) { all.push_back(n); }
  return all;
}

std::vector<std::size_t> besides(const Forward& forward, const std::vector<std::size_t>& told) {
  std::vector<std::size_t> others = all_of(forward);
  std::erase_if(others, [&](std::size_t n) { return std::ranges::find(told, n) != told.end(); });
  return others;
}

/// What one spread of the prior moves all rows by, in their uncertainties.
Eigen::VectorXd sensitivities(const Eigen::MatrixXd& slopes, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd weight = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return (weight.asDiagonal() * slopes).colwise().norm().transpose();
}

/// Those of `candidates` that are told, others left at their priors.
std::vector<std::size_t> choose(const Search& search, const Forward& forward, const Forward::Values& at,
                                const std::vector<std::size_t>& candidates) {
  const std::vector<Eigen::Index> columns(candidates.begin(), candidates.end());
  const auto told = told_columns(search.slopes(at, all_of(forward)), search.covariance(), columns);
  return {told.begin(), told.end()};
}

/// What data tell is judged at the prior first, and again where the fit has led, until all that is fitted is
/// told; none comes back, so it ends.
Search::Found search_told(Forward& forward, const Pooled& data, Fit& result) {
  const Forward::Values priors = forward.priors();
  result.told = choose(Search(forward, data, {}), forward, priors, all_of(forward));
  Search::Found found{.values = priors};
  for (;;) {
    const Search search(forward, data, result.told);
    Forward::Values start = found.values;
    for (const std::size_t n : besides(forward, result.told)) { start[n] = priors[n]; }
    found = search.from(start);
    result.iterations += found.iterations;
    const std::vector<std::size_t> still = choose(search, forward, found.values, result.told);
    if (still == result.told) { return found; }
    result.told = still;
  }
}

/// More than one in a hundred would show by chance: then uncertainties were too small by this factor
/// (R. T. Birge 1932), or the model cannot follow.
double widening_of(double misfit, std::size_t rows) {
  const boost::math::chi_squared chance(static_cast<double>(rows));
  return misfit > quantile(chance, 0.99) ? std::sqrt(misfit / static_cast<double>(rows)) : 1.0;
}

FittedParameter untold(const Parameter& p, double sensitivity) {
  return {.parameter = p,
          .telling = sensitivity < 1.0 ? Telling::insensitive : Telling::wide,
          .value = p.prior,
          .sensitivity = sensitivity,
          .interval = {p.value(-normal_factor), p.value(normal_factor)}};
}

/// Student's t with as many degrees of freedom as are left where a part of the variance alone was estimated
/// from n subjects: (n - 1) (all / part)^2 (Welch and Satterthwaite; GUM, annex G.4).
double factor_of(double all, double sampled, std::size_t degrees_of_freedom) {
  constexpr double many = 1e4;  // as good as normal
  if (degrees_of_freedom == 0 || !(sampled > 0.0)) { return normal_factor; }
  const double effective = static_cast<double>(degrees_of_freedom) * (all / sampled) * (all / sampled);
  return comparison::student_factor(level, static_cast<std::size_t>(std::fmin(effective, many)));
}

void conclude_told(Fit& result, const Search& search, const Forward& forward, const Search::Found& found) {
  const Linearised at{.slope = search.slopes(found.values, result.told),
                      .considered = search.slopes(found.values, besides(forward, result.told)),
                      .covariance = search.covariance()};
  const Eigen::MatrixXd covariance = posterior_covariance(at);
  const std::size_t freedom = result.data.degrees_of_freedom();
  const Eigen::VectorXd sampled =
      freedom == 0 ? Eigen::VectorXd::Zero(covariance.rows())
                   : Eigen::VectorXd(passed_on(at, search.rows_of(result.data.sampled)).diagonal());
  result.correlation = correlation_of(covariance);
  for (std::size_t n = 0; n < result.told.size(); ++n) {
    FittedParameter& each = result.parameters[result.told[n]];
    const Parameter& p = each.parameter;
    const auto k = static_cast<Eigen::Index>(n);
    each.telling = Telling::told;
    each.value = found.values[result.told[n]];
    each.deviation = result.widening * std::sqrt(covariance(k, k));
    const double middle = p.standardised(each.value);
    each.interval_factor = factor_of(covariance(k, k), sampled[k], freedom);
    const double reach = each.interval_factor * each.deviation;
    each.interval = {p.value(middle - reach), p.value(middle + reach)};
    each.at_bound = middle - p.standardised(p.lower) < 0.05 || p.standardised(p.upper) - middle < 0.05;
  }
}

}  // namespace

std::string_view name_of(Telling telling) {
  switch (telling) {
    case Telling::told:
      return "told";
    case Telling::insensitive:
      return "insensitive";
    case Telling::wide:
      return "wide";
  }
  return {};
}

Forward::Values Fit::values() const {
  Forward::Values values;
  for (const FittedParameter& each : parameters) { values.push_back(each.value); }
  return values;
}

Fit fit(Forward& forward, const Pooled& data) {
  Fit result{.data = data};
  result.rows = data.present();
  if (result.rows.empty() || forward.parameters().empty()) {
    throw std::invalid_argument("calibration: no observable or no parameter is left to fit");
  }
  const Forward::Values priors = forward.priors();
  const Search search(forward, data, {});
  result.before = forward.at(priors);
  const Eigen::VectorXd sensitivity =
      sensitivities(search.slopes(priors, all_of(forward)), search.covariance());
  const Search::Found found = search_told(forward, data, result);
  result.after = forward.at(found.values);
  result.converged = found.converged;
  result.misfit_before = search.misfits(result.before).squaredNorm();
  result.misfit_after = search.misfits(result.after).squaredNorm();
  result.widening = widening_of(result.misfit_after, result.rows.size());
  for (std::size_t n = 0; n < forward.parameters().size(); ++n) {
    result.parameters.push_back(untold(forward.parameters()[n], sensitivity[static_cast<Eigen::Index>(n)]));
  }
  if (!result.told.empty()) { conclude_told(result, search, forward, found); }
  return result;
}

}  // namespace palpate::calibration

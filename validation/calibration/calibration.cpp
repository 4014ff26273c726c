// SPDX-License-Identifier: MIT

#include "validation/calibration/calibration.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <numeric>
#include <stdexcept>

namespace palpate::calibration {

namespace {

/// Weighted slopes w J, and H^-1.
struct Normal {
  Eigen::MatrixXd weighted{};
  Eigen::MatrixXd inverse{};
};

Normal normal_equations(const Linearised& at) {
  const Eigen::Index count = at.slope.cols();
  const Eigen::MatrixXd weighted = at.covariance.diagonal().cwiseInverse().asDiagonal() * at.slope;
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(count, count);
  const Eigen::LLT<Eigen::MatrixXd> information(at.slope.transpose() * weighted + unit);
  return {.weighted = weighted, .inverse = information.solve(unit)};
}

}  // namespace

Eigen::MatrixXd posterior_covariance(const Linearised& at) {
  const Normal normal = normal_equations(at);
  const Eigen::MatrixXd spread = at.covariance + at.considered * at.considered.transpose();
  return passed_on(at, spread) + normal.inverse * normal.inverse;
}

Eigen::MatrixXd passed_on(const Linearised& at, const Eigen::MatrixXd& part) {
  const Normal normal = normal_equations(at);
  return normal.inverse * normal.weighted.transpose() * part * normal.weighted * normal.inverse;
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

std::vector<Eigen::Index> told_columns(const Eigen::MatrixXd& slope,
                                       const Eigen::MatrixXd& covariance,
                                       std::vector<Eigen::Index> candidates) {
  constexpr double most_left = 0.5;  // of the prior variance
  std::vector<Eigen::Index> told = std::move(candidates);
  while (!told.empty()) {
    std::vector<Eigen::Index> others;
    for (Eigen::Index c = 0; c < slope.cols(); ++c) {
      if (std::ranges::find(told, c) == told.end()) { others.push_back(c); }
    }
    const Eigen::VectorXd left = posterior_covariance({.slope = slope(Eigen::all, told),
                                                       .considered = slope(Eigen::all, others),
                                                       .covariance = covariance})
                                     .diagonal();
    Eigen::Index worst = 0;
    if (left.maxCoeff(&worst) < most_left) { break; }
    told.erase(told.begin() + worst);
  }
  return told;
}

namespace {

/// Step of finite differences in prior spreads, far above the discretisation of the ticks.
constexpr double difference = 0.1;

/// A free variable q represents log v = lower + (upper - lower) / (1 + exp(-q)).
double share_of(double q) { return 1.0 / (1.0 + std::exp(-q)); }

double from_free(const Parameter& p, double q) {
  return std::exp(std::lerp(std::log(p.lower), std::log(p.upper), share_of(q)));
}

double to_free(const Parameter& p, double value) {
  constexpr double edge = 1e-6;  // the gradient vanishes at a bound
  const double share = std::log(value / p.lower) / std::log(p.upper / p.lower);
  const double inside = std::clamp(share, edge, 1.0 - edge);
  return std::log(inside / (1.0 - inside));
}

/// Returns d x / d q of the standardised parameter.
double slope_of_free(const Parameter& p, double q) {
  const double share = share_of(q);
  return std::log(p.upper / p.lower) / p.spread * share * (1.0 - share);
}

}  // namespace

Search::Search(Forward& forward, const Pooled& data, std::vector<std::size_t> free)
    : forward_(forward),
      data_(data),
      free_(std::move(free)),
      rows_(data.present()),
      deviation_(data.covariance.diagonal()(rows_).cwiseSqrt()) {}

Eigen::VectorXd Search::misfits(const Observation& simulated) const {
  const Eigen::VectorXd seen = simulated(rows_);
  return (seen.array().isFinite().select(seen, 0.0) - data_.mean(rows_)).cwiseQuotient(deviation_);
}

Forward::Values Search::values_at(const Forward::Values& base, const Eigen::VectorXd& q) const {
  Forward::Values values = base;
  for (Eigen::Index n = 0; n < q.size(); ++n) {
    values[free_[static_cast<std::size_t>(n)]] = from_free(free_parameter(n), q[n]);
  }
  return values;
}

Eigen::VectorXd Search::residuals(const Forward::Values& at) const {
  Eigen::VectorXd priors(std::ssize(free_));
  for (Eigen::Index n = 0; n < priors.size(); ++n) {
    priors[n] = free_parameter(n).standardised(at[free_[static_cast<std::size_t>(n)]]);
  }
  Eigen::VectorXd all(std::ssize(rows_) + priors.size());
  all << misfits(forward_.at(at)), priors;
  return all;
}

Eigen::MatrixXd Search::slopes(const Forward::Values& at,
                               const std::vector<std::size_t>& of) const {
  std::vector<Forward::Values> places{at};
  std::vector<double> steps;
  for (const std::size_t index : of) {
    const Parameter& p = forward_.parameters()[index];
    const double x = p.standardised(at[index]);
    steps.push_back(x + difference > p.standardised(p.upper) ? -difference : difference);
    places.push_back(at);
    places.back()[index] = p.value(x + steps.back());
  }
  const std::vector<Observation> seen = forward_.at(places);
  Eigen::MatrixXd slope(std::ssize(rows_), std::ssize(of));
  for (std::size_t n = 0; n < of.size(); ++n) {
    Eigen::VectorXd moved = seen[n + 1](rows_);
    double step = steps[n];
    if (!moved.allFinite()) {  // the other side
      const Parameter& p = forward_.parameters()[of[n]];
      step = -step;
      places[n + 1][of[n]] = p.value(p.standardised(at[of[n]]) + step);
      moved = forward_.at(places[n + 1])(rows_);
    }
    const Eigen::VectorXd one = (moved - seen[0](rows_)) / step;
    slope.col(static_cast<Eigen::Index>(n)) = one.array().isFinite().select(one, 0.0);
  }
  return slope;
}

Eigen::MatrixXd Search::jacobian(const Forward::Values& at, const Eigen::VectorXd& q) const {
  const Eigen::Index rows = std::ssize(rows_);
  const Eigen::Index count = std::ssize(free_);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(rows + count, count);
  all.topRows(rows) = deviation_.cwiseInverse().asDiagonal() * slopes(at, free_);
  all.bottomRows(count).setIdentity();
  for (Eigen::Index n = 0; n < count; ++n) { all.col(n) *= slope_of_free(free_parameter(n), q[n]); }
  return all;
}

Search::Found Search::from(const Forward::Values& start,
                           const reference::LeastSquaresRule& rule) const {
  if (free_.empty()) {
    return {.values = start, .cost = residuals(start).squaredNorm(), .converged = true};
  }
  Eigen::VectorXd q(std::ssize(free_));
  for (Eigen::Index n = 0; n < q.size(); ++n) {
    q[n] = to_free(free_parameter(n), start[free_[static_cast<std::size_t>(n)]]);
  }
  const reference::LeastSquaresProblem problem{
      .residuals = [&](const Eigen::VectorXd& at) { return residuals(values_at(start, at)); },
      .jacobian = [&](const Eigen::VectorXd& at) { return jacobian(values_at(start, at), at); }};
  const reference::LeastSquaresSolution solution = reference::least_squares(problem, q, rule);
  return {.values = values_at(start, solution.x),
          .cost = solution.cost(),
          .iterations = solution.iterations,
          .converged = solution.converged};
}

namespace {

constexpr double level = 0.95;

std::vector<std::size_t> all_of(const Forward& forward) {
  std::vector<std::size_t> all(forward.parameters().size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

std::vector<std::size_t> besides(const Forward& forward, const std::vector<std::size_t>& told) {
  std::vector<std::size_t> others = all_of(forward);
  std::erase_if(others, [&](std::size_t n) { return std::ranges::find(told, n) != told.end(); });
  return others;
}

/// Returns the effect of one prior spread on all rows, in their uncertainties.
Eigen::VectorXd sensitivities(const Eigen::MatrixXd& slopes, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd weight = covariance.diagonal().cwiseSqrt().cwiseInverse();
  return (weight.asDiagonal() * slopes).colwise().norm().transpose();
}

/// Returns the `candidates` that the data constrain, with the others at their priors.
std::vector<std::size_t> choose(const Search& search, const Forward& forward,
                                const Forward::Values& at,
                                const std::vector<std::size_t>& candidates) {
  const std::vector<Eigen::Index> columns(candidates.begin(), candidates.end());
  const auto told = told_columns(search.slopes(at, all_of(forward)), search.covariance(), columns);
  return {told.begin(), told.end()};
}

/// Selects constrained parameters at the begin, and again at the fit, until all fitted parameters
/// are constrained. Removed parameters do not return, so the loop ends.
Search::Found search_told(Forward& forward, const Pooled& data, const Forward::Values& begin,
                          const reference::LeastSquaresRule& rule, Fit& result) {
  const Forward::Values priors = forward.priors();
  result.told = choose(Search(forward, data, {}), forward, begin, all_of(forward));
  Search::Found found{.values = begin};
  for (;;) {
    const Search search(forward, data, result.told);
    Forward::Values start = found.values;
    for (const std::size_t n : besides(forward, result.told)) { start[n] = priors[n]; }
    found = search.from(start, rule);
    result.iterations += found.iterations;
    const std::vector<std::size_t> still = choose(search, forward, found.values, result.told);
    if (still == result.told) { return found; }
    result.told = still;
  }
}

/// Returns the factor on uncertainties if the misfit is larger than in one of a hundred cases by
/// chance: uncertainties were too small (R. T. Birge 1932), or the model is inadequate.
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

/// Returns Student's t if only a part of the variance was estimated from n subjects; degrees of
/// freedom (n - 1) (all / part)^2 (Welch and Satterthwaite; GUM, annex G.4).
double factor_of(double all, double sampled, std::size_t degrees_of_freedom) {
  constexpr double many = 1e4;  // as good as normal
  if (degrees_of_freedom == 0 || !(sampled > 0.0)) { return normal_factor; }
  const double effective =
      static_cast<double>(degrees_of_freedom) * (all / sampled) * (all / sampled);
  return comparison::student_factor(level, static_cast<std::size_t>(std::fmin(effective, many)));
}

void conclude_told(Fit& result, const Search& search, const Forward& forward,
                   const Search::Found& found) {
  const Linearised at{.slope = search.slopes(found.values, result.told),
                      .considered = search.slopes(found.values, besides(forward, result.told)),
                      .covariance = search.covariance()};
  const Eigen::MatrixXd covariance = posterior_covariance(at);
  const std::size_t freedom = result.data.degrees_of_freedom();
  const Eigen::VectorXd sampled =
      freedom == 0 ? Eigen::VectorXd::Zero(covariance.rows())
                   : Eigen::VectorXd(
                         passed_on(at, result.data.sampled(result.rows, result.rows)).diagonal());
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
    each.interval = {std::max(p.lower, p.value(middle - reach)),
                     std::min(p.upper, p.value(middle + reach))};
    each.at_bound =
        middle - p.standardised(p.lower) < 0.05 || p.standardised(p.upper) - middle < 0.05;
  }
}

}  // namespace

std::string_view name_of(Telling telling) {
  constexpr std::array<std::string_view, 3> names{"told", "insensitive", "wide"};
  return names[static_cast<std::size_t>(telling)];
}

Forward::Values Fit::values() const {
  Forward::Values values;
  for (const FittedParameter& each : parameters) { values.push_back(each.value); }
  return values;
}

Fit fit(Forward& forward, const Pooled& data, const Forward::Values& start,
        const reference::LeastSquaresRule& rule) {
  Fit result{.rows = data.present(), .data = data};
  if (result.rows.empty() || forward.parameters().empty()) {
    throw std::invalid_argument("calibration: no observable or no parameter is left to fit");
  }
  const Forward::Values priors = forward.priors();
  const Search search(forward, data, {});
  result.before = forward.at(priors);
  const Eigen::VectorXd sensitivity =
      sensitivities(search.slopes(priors, all_of(forward)), search.covariance());
  const Search::Found found =
      search_told(forward, data, start.empty() ? priors : start, rule, result);
  result.after = forward.at(found.values);
  result.converged = found.converged;
  result.misfit_before = search.misfits(result.before).squaredNorm();
  result.misfit_after = search.misfits(result.after).squaredNorm();
  result.widening = widening_of(result.misfit_after, result.rows.size());
  for (std::size_t n = 0; n < forward.parameters().size(); ++n) {
    result.parameters.push_back(
        untold(forward.parameters()[n], sensitivity[static_cast<Eigen::Index>(n)]));
  }
  if (!result.told.empty()) { conclude_told(result, search, forward, found); }
  return result;
}

namespace {

/// Corrects the depth of a group whose BMI differs from that of the fitted groups.
void move_depth(Observation& predicted, const Pooled& fitted, const Pooled& held) {
  if (!fitted.body_mass_index || !held.body_mass_index) { return; }
  predicted[index_of(Observable::depth_of_loss)] +=
      depth_per_body_mass_index * (*held.body_mass_index - *fitted.body_mass_index);
}

}  // namespace

Profile profile_of_worst(Forward& forward, const Fit& fit) {
  Profile profile;
  if (fit.told.empty()) { return profile; }
  profile.parameter = *std::ranges::max_element(
      fit.told, {}, [&](std::size_t n) { return fit.parameters[n].deviation; });
  const FittedParameter& worst = fit.parameters[profile.parameter];
  std::vector<std::size_t> others = fit.told;
  std::erase(others, profile.parameter);
  const double middle = worst.parameter.standardised(worst.value);
  const double lowest = worst.parameter.standardised(worst.parameter.lower);
  const double highest = worst.parameter.standardised(worst.parameter.upper);
  const Search search(forward, fit.data, others);
  const auto cost_at = [&](double x) {
    Forward::Values start = fit.values();
    start[profile.parameter] = worst.parameter.value(x);
    return search.from(start, {.most_iterations = 6}).cost + x * x;  // its own prior is a row too
  };
  const double least = cost_at(middle);
  for (const double deviations : {-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double x = middle + deviations * worst.deviation;
    if (x < lowest || x > highest) { continue; }
    profile.value.push_back(worst.parameter.value(x));
    profile.growth.push_back(cost_at(x) - least);
  }
  return profile;
}

std::vector<std::string> groups_of(std::span<const ObservedRecording> subjects) {
  std::vector<std::string> groups;
  for (const ObservedRecording& subject : subjects) {
    if (std::ranges::find(groups, subject.recording.group) == groups.end()) {
      groups.push_back(subject.recording.group);
    }
  }
  return groups;
}

std::vector<HeldOut> leave_groups_out(Forward& forward, const Fit& fit,
                                      std::span<const ObservedRecording> subjects,
                                      const SharedUncertainty& shared) {
  std::vector<HeldOut> all;
  const std::vector<std::string> groups = groups_of(subjects);
  if (groups.size() < 2) { return all; }
  for (const std::string& group : groups) {
    std::vector<ObservedRecording> held;
    std::vector<ObservedRecording> others;
    for (const ObservedRecording& subject : subjects) {
      (subject.recording.group == group ? held : others).push_back(subject);
    }
    const Pooled fitted = pool(others, shared);
    HeldOut out{.group = group, .subjects = held.size(), .seen = pool(held, shared)};
    const Search::Found found = Search(forward, fitted, fit.told).from(fit.values());
    out.converged = found.converged;
    out.predicted = forward.at(found.values);
    out.error_fitted = root_mean_square(relative_errors(out.predicted, fitted.mean));
    move_depth(out.predicted, fitted, out.seen);
    out.error_predicted = root_mean_square(relative_errors(out.predicted, out.seen.mean));
    all.push_back(std::move(out));
  }
  return all;
}

Eigen::VectorXd relative_errors(const Observation& simulated, const Observation& seen) {
  return (simulated - seen).cwiseQuotient(seen);
}

double root_mean_square(const Eigen::VectorXd& values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double v : values) {
    if (std::isfinite(v)) { sum += v * v, count += 1.0; }
  }
  return std::sqrt(sum / count);
}

double Calibration::shortcut_cost() const {
  Largest worst;
  for (const Eigen::Index row : fit.rows) {
    worst.add(std::abs(whole[row] - fit.after[row]) / std::sqrt(fit.data.covariance(row, row)));
  }
  return worst.value();
}

Outcome Calibration::outcome() const {
  Outcome outcome{
      .name = "calibration",
      .suite = "calibration",
      .claim = "The recordings constrain parameters of the scene, and the fit is sound."};
  const auto at_bound = std::ranges::count_if(fit.parameters, &FittedParameter::at_bound);
  outcome.judge_true("search converged", fit.converged, "an unfinished search has no minimum");
  outcome.judge_at_least("constrained parameters", fit.told.size(), 1.0,
                         "without any nothing was fitted");
  outcome.judge_at_most("parameters at a bound", at_bound, 0.0, "nothing is known beyond a bound");
  outcome.judge_at_most("misfit after the fit", fit.misfit_after, fit.misfit_before,
                        "the misfit before it");
  outcome.judge_at_most("widening of the intervals", fit.widening, 2.0,
                        "root mean square of the deviations in uncertainties; 95 % lie within two "
                        "if the model can follow");
  outcome.judge_at_most("largest effect of the shortcuts", shortcut_cost(),
                        std::nextafter(1.0, 0.0), "the uncertainty of the observable");
  palpate::conclude(outcome);
  return outcome;
}

namespace {

/// Returns the coarsest of three forms in which the scene can be simulated.
Coarsening coarsest(const Scene& scene, const CalibrationOptions& options) {
  Coarsening gentler = options.coarsening;
  gentler.block = false;
  for (const Coarsening& how : {options.coarsening, gentler}) {
    const Scene coarse = coarser(scene, how);
    const ObservedInsertion seen =
        options.simulate ? options.simulate(coarse) : simulate_insertion(coarse, options.stop);
    if (seen.refusal.empty()) { return how; }
  }
  gentler.step_factor = 1.0;
  return gentler;
}

}  // namespace

Calibration calibrate(const Scene& scene, const std::vector<Parameter>& parameters,
                      std::span<const ObservedRecording> recordings,
                      const CalibrationOptions& options) {
  const std::vector<ObservedRecording> subjects = by_subject(recordings);
  const auto tell = [&](const char* stage) {
    if (options.progress) { options.progress(stage); }
  };
  Forward forward(coarser(scene, coarsest(scene, options)), parameters, options.jobs, options.stop,
                  options.simulate);
  Calibration result;
  tell("fitting");
  result.fit = fit(forward, pool(subjects, options.shared));
  tell("profile of the least certain parameter");
  result.profile = profile_of_worst(forward, result.fit);
  tell("leaving groups out");
  result.held_out = leave_groups_out(forward, result.fit, subjects, options.shared);
  tell("the fitted scene without shortcuts");
  result.fitted = with_values(scene, parameters, result.fit.values());
  const Coarsening none{.block = false, .step_factor = 1.0, .after = options.coarsening.after};
  Forward whole(coarser(result.fitted, none), {}, 1, options.stop, options.simulate);
  result.whole = whole.at(Forward::Values{});
  result.simulations = forward.simulations();
  return result;
}

}  // namespace palpate::calibration

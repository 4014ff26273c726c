// SPDX-License-Identifier: MIT

#include "validation/calibration/fit.hpp"

#include <Eigen/Eigenvalues>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"
#include "validation/calibration/observation.hpp"

namespace {

using namespace palpate::calibration;
using namespace palpate;

constexpr SharedUncertainty nothing{.transducer = {.zero = 0.0, .gain = 0.0},
                                    .plunger_friction = 0.0,
                                    .force_gain = 0.0,
                                    .depth = 0.0,
                                    .drop_time = 0.0,
                                    .model = 0.0};

ObservedRecording subject(double pressure, double force) {
  ObservedRecording made{.seen = {.value = Observation::Constant(observable_count, force),
                                  .force = ForceSource::plunger}};
  made.seen.value[0] = pressure;
  return made;
}

TEST("the spread of a mean is the standard error") {
  const std::vector<ObservedRecording> subjects{subject(1.0, 5.0), subject(2.0, 6.0),
                                                subject(6.0, 7.0)};
  const Pooled pooled = pool(subjects, nothing);
  CHECK_NEAR(pooled.mean[0], 3.0, 1e-15);
  CHECK_NEAR(pooled.covariance(0, 0), 7.0 / 3.0, 1e-14);  // variance 7 of three
  CHECK_NEAR(pooled.covariance(0, 4), 2.5 / 3.0, 1e-14);  // covariance 2.5 of three
  CHECK(pooled.degrees_of_freedom() == 2);
}

TEST("several recordings of one subject count as their mean, and only within a group") {
  std::vector<ObservedRecording> recordings{subject(1.0, 5.0), subject(4.0, 6.0), subject(3.0, 7.0),
                                            subject(9.0, 8.0)};
  for (const std::size_t n : {0U, 2U, 3U}) { recordings[n].recording.subject = "A"; }
  recordings[3].recording.group = "another";
  recordings[2].seen.value[3] = std::nan("");
  recordings[2].seen.force = ForceSource::none;
  const std::vector<ObservedRecording> people = by_subject(recordings);
  REQUIRE(people.size() == 3);
  CHECK_NEAR(people[0].seen.value[0], 2.0, 0.0);
  CHECK_NEAR(people[0].seen.value[3], 5.0, 0.0);  // value of the only recording that has it
  CHECK(people[0].seen.force == ForceSource::plunger);
  CHECK_NEAR(people[1].seen.value[0], 4.0, 0.0);
  CHECK_NEAR(people[2].seen.value[0], 9.0, 0.0);
  const std::vector<ObservedRecording> nameless{subject(1.0, 5.0), subject(1.0, 5.0)};
  CHECK(by_subject(nameless).size() == 2);
}

TEST("two recordings give no spread, and the zero of a transducer is shared by all its values") {
  const std::vector<ObservedRecording> subjects{subject(50e3, 8.0), subject(60e3, 10.0)};
  SharedUncertainty only_zero = nothing;
  only_zero.transducer.zero = 57.0;
  const Pooled pooled = pool(subjects, only_zero);
  CHECK(pooled.degrees_of_freedom() == 0);
  CHECK_NEAR(pooled.covariance(0, 0), 57.0 * 57.0, 1e-9);
  const double area = subjects[0].recording.plunger_area;
  CHECK_NEAR(pooled.covariance(0, 5), 57.0 * 57.0 * area, 1e-12);  // fully correlated
}

TEST("observables of few recordings are left out, and no eigenvalue is negative") {
  std::vector<ObservedRecording> subjects{subject(1.0, 5.0), subject(2.0, 7.0), subject(6.0, 6.0),
                                          subject(4.0, 6.5)};
  subjects[0].seen.value[2] = subjects[1].seen.value[2] = std::nan("");
  subjects[3].seen.value[5] = std::nan("");
  const Pooled pooled = pool(subjects, nothing);
  CHECK(std::isnan(pooled.mean[2]));
  CHECK(pooled.count[2] == 2);
  CHECK(pooled.covariance(2, 2) == 0.0);
  CHECK_NEAR(pooled.mean[5], 6.0, 1e-15);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(pooled.covariance,
                                                              Eigen::EigenvaluesOnly);
  CHECK(solver.eigenvalues().minCoeff() > -1e-12);
}

TEST("depths are moved to the mean body mass by the published slope") {
  std::vector<ObservedRecording> subjects{subject(1.0, 5.0), subject(2.0, 5.0), subject(6.0, 5.0)};
  for (std::size_t n = 0; n < 3; ++n) {
    subjects[n].recording.body_mass_index = 20.0 + 10.0 * static_cast<double>(n);
    subjects[n].seen.value[3] =
        0.04 + depth_per_body_mass_index * (*subjects[n].recording.body_mass_index - 20.0);
  }
  const Pooled pooled = pool(subjects, nothing);
  CHECK_NEAR(pooled.mean[3], 0.04 + 10.0 * depth_per_body_mass_index, 1e-15);
  CHECK_NEAR(pooled.covariance(3, 3), 0.0, 1e-18);  // rounding: nothing but body mass differs
}

TEST("correlated rows count less, and the uncertainty of a parameter that is not fitted is added") {
  const auto variance = [](double slope, const Eigen::MatrixXd& considered,
                           const Eigen::MatrixXd& covariance) {
    const Eigen::Index rows = covariance.rows();
    return posterior_covariance({.slope = Eigen::MatrixXd::Constant(rows, 1, slope),
                                 .considered = considered,
                                 .covariance = covariance})(0, 0);
  };
  const Eigen::MatrixXd four = Eigen::MatrixXd::Constant(1, 1, 4.0);
  // One row and one parameter leave 1 / (1 + s^2) of the prior variance, s = 6 / 2.
  CHECK_NEAR(variance(6.0, Eigen::MatrixXd(1, 0), four), 0.1, 1e-15);
  // G = (1 / 10) 6 / 4, and G^2 2^2 more than before.
  CHECK_NEAR(variance(6.0, Eigen::MatrixXd::Constant(1, 1, 2.0), four), 0.1 + 0.0225 * 4.0, 1e-15);
  const Eigen::MatrixXd none(4, 0);
  const Eigen::MatrixXd apart = Eigen::MatrixXd::Identity(4, 4);
  CHECK_NEAR(variance(3.0, none, apart), 1.0 / 37.0, 1e-14);  // H = 4 9 + 1
  const Eigen::MatrixXd together = Eigen::MatrixXd::Ones(4, 4) + 1e-12 * apart;
  CHECK_NEAR(variance(3.0, none, together), (12.0 * 12.0 + 1.0) / (37.0 * 37.0),
             1e-10);  // the 1e-12 above
}

TEST("of two parameters with equal slopes one is left out, and so is one without influence") {
  using Columns = std::vector<Eigen::Index>;
  Eigen::MatrixXd slope{{5.0, 5.0, 0.0, 0.0}, {0.0, 0.0, 7.0, 0.1}};
  const auto told = [&](const Columns& columns) {
    return told_columns(slope, Eigen::MatrixXd::Identity(2, 2), columns);
  };
  CHECK(told({0, 1, 2, 3}) == Columns{2});  // either of the two has the other's uncertainty
  slope(0, 1) = 1.0;
  CHECK(told({0, 1, 2, 3}) == Columns({0, 2}));
  CHECK(told({1, 2}) == Columns{2});
}

TEST("correlation has ones on its diagonal") {
  const Eigen::MatrixXd covariance{{4.0, -3.0}, {-3.0, 9.0}};
  CHECK_NEAR(correlation_of(covariance)(0, 1), -0.5, 1e-15);
  CHECK_NEAR(correlation_of(covariance)(1, 1), 1.0, 1e-15);
}

std::size_t thumb_index(const Forward& forward) {
  const auto& all = forward.parameters();
  const auto thumb = std::ranges::find(all, "syringe.thumb_force", &Parameter::key);
  return static_cast<std::size_t>(thumb - all.begin());
}

TEST("a value between prior and datum minimises the sum of both misfits") {
  Forward forward = lawful_forward();
  const Pooled data = lawful_data(with_thumb_force(22.0), 0.2);
  const std::size_t thumb = thumb_index(forward);
  const auto found = Search(forward, data, {thumb}).from(forward.priors());
  // Zero of the derivative of ((v / 22 - 1) / 0.2)^2 + (log(v / 11) / spread)^2, by bisection.
  const double spread = forward.parameters()[thumb].spread;
  double low = 11.0, high = 22.0;
  for (int n = 0; n < 60; ++n) {
    const double v = 0.5 * (low + high);
    const double slope =
        (v / 22.0 - 1.0) / (0.04 * 22.0) + std::log(v / 11.0) / (spread * spread * v);
    (slope < 0.0 ? low : high) = v;
  }
  CHECK(found.converged);
  // Forward differences over a tenth of the spread make slopes 1.8 % high, and move the place by as
  // much of the way between datum and prior that is weighed: below 1 %.
  CHECK_NEAR(found.values[thumb] / low, 1.0, 0.01);
}

TEST("a parameter that is not free keeps its value, and values keep their bounds") {
  Forward forward = lawful_forward();
  const std::size_t thumb = thumb_index(forward);
  Forward::Values start = forward.priors();
  start[0] *= 1.1;
  const auto found = Search(forward, lawful_data(with_thumb_force(1e4), 0.01), {thumb}).from(start);
  CHECK(found.values[0] == start[0]);
  CHECK(found.values[thumb] <= forward.parameters()[thumb].upper);
}

TEST("slopes are those of the law, in spreads of the prior") {
  Forward forward = lawful_forward();
  const std::size_t thumb = thumb_index(forward);
  const Search search(forward, lawful_data(three_layers(), 0.01), {});
  const Eigen::MatrixXd slopes = search.slopes(forward.priors(), {thumb});
  const double spread = forward.parameters()[thumb].spread;
  const double peak = 11.0 / Syringe{}.plunger_area;
  CHECK_NEAR(slopes(0, 0) / (peak * spread), std::expm1(0.1 * spread) / (0.1 * spread),
             1e-12);  // rounding
  CHECK_NEAR(slopes.col(0).tail(slopes.rows() - 1).norm(), 0.0, 1e-15);
}

const FittedParameter& of(const Fit& fit, std::string_view key) {
  return *std::ranges::find_if(fit.parameters,
                               [&](const FittedParameter& p) { return p.parameter.key == key; });
}

Scene stronger_thumb() {
  Scene truth = three_layers();
  truth.syringe->thumb_force *= 1.3;
  truth.materials[1].cutting_force *= 0.7;
  truth.syringe->compliance *= 1.8;
  return truth;
}

TEST("exact data give back their parameters, and one without influence is reported") {
  Forward forward = lawful_forward(2);
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 1e-3));
  CHECK(found.converged);
  CHECK(found.misfit_after < 0.1);
  CHECK(found.misfit_before > 1e4);
  // A prior of 0.35 pulls data of 0.001 by (0.001 / 0.35)^2 of the way, 3e-6; 1e-4 is the step
  // tolerance.
  CHECK_NEAR(of(found, "syringe.thumb_force").value / 14.3, 1.0, 1e-4);
  CHECK_NEAR(of(found, "material.ligament.cutting_force").value / 3.5, 1.0, 1e-4);
  CHECK_NEAR(of(found, "syringe.compliance").value / 3.6e-12, 1.0, 1e-4);
  CHECK(of(found, "material.ligament.friction").telling == Telling::insensitive);
  CHECK(of(found, "material.ligament.friction").value == 80.0);
  CHECK(of(found, "layer.0.thickness").telling == Telling::told);
}

TEST("intervals are those of the law: the thumb force is known as well as the peak") {
  Forward forward = lawful_forward();
  const Fit found = fit(forward, lawful_data(three_layers(), 0.01));
  const FittedParameter& thumb = of(found, "syringe.thumb_force");
  const double told = thumb.parameter.spread / 0.01;  // slope over uncertainty
  // Forward differences of an exponential over a tenth of a spread of 0.35: half of 0.035 high.
  CHECK_NEAR(thumb.deviation * std::sqrt(1.0 + told * told), 1.0, 0.03);
  CHECK(thumb.interval.holds(11.0));
  CHECK(!thumb.interval.holds(11.3));
}

TEST("a bound that the data exceed is reported") {
  std::vector<Parameter> parameters = parameters_of(three_layers());
  for (Parameter& p : parameters) {
    if (p.key == "syringe.thumb_force") { p.upper = 12.0; }
  }
  Forward forward(three_layers(), parameters, 1, nullptr, lawful);
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 1e-2));
  CHECK(of(found, "syringe.thumb_force").at_bound);
  CHECK(of(found, "syringe.thumb_force").value <= 12.0);
  CHECK(found.widening > 1.0);  // 14.3 N cannot be reached: more than chance
}

TEST("data that constrain nothing leave every parameter at its prior") {
  Forward forward = lawful_forward();
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 50.0));
  CHECK(found.told.empty());
  CHECK(found.values() == forward.priors());
}

}  // namespace

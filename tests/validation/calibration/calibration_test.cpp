// SPDX-License-Identifier: MIT

#include <Eigen/Eigenvalues>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::calibration;
using namespace palpate;

void add_group(std::vector<ObservedRecording>& subjects, const char* name, double thumb) {
  for (const double factor : {0.98, 1.0, 1.02}) {
    Scene scene = with_thumb_force(thumb * factor);
    scene.syringe->epidural_resistance *= factor;
    scene.materials[1].cutting_force *= factor;
    subjects.push_back({.recording = {.group = name}, .seen = lawful(scene)});
  }
}

TEST("the misfit is a parabola around the fit if the other parameters are fitted again") {
  Forward forward = lawful_forward();
  const Fit found = fit(forward, lawful_data(three_layers(), 0.01));
  const calibration::Profile profile = profile_of_worst(forward, found);
  CHECK(profile.value.size() == 9);
  CHECK_NEAR(profile.growth[4], 0.0, 1e-6);  // the fit itself
  // One deviation grows it by 1 where observables are independent; slopes are 2 % high (fit_test).
  CHECK_NEAR(profile.growth[0], 1.0, 0.1);
  CHECK_NEAR(profile.growth[8], 1.0, 0.1);
}

TEST("an interval that a large misfit widens ends at the bounds of its parameter") {
  Forward forward = lawful_forward();
  Pooled data = lawful_data(three_layers(), 0.01);
  for (Eigen::Index n = 0; n < data.mean.size(); ++n) { data.mean(n) *= n % 2 == 0 ? 3.0 : 0.3; }
  const Fit found = fit(forward, data);
  CHECK(found.widening > 10.0);
  REQUIRE(!found.told.empty());
  for (const FittedParameter& each : found.parameters) {
    CHECK(each.interval.lower >= each.parameter.lower);
    CHECK(each.interval.upper <= each.parameter.upper);
  }
}

TEST("a group that differs is predicted worse than the fitted ones, by as much as it differs") {
  std::vector<ObservedRecording> all;
  add_group(all, "a", 11.0);
  const std::vector<ObservedRecording> one_group = all;
  add_group(all, "b", 11.0);
  add_group(all, "c", 22.0);
  Forward forward = lawful_forward();
  const Fit found = fit(forward, pool(all));
  const std::vector<HeldOut> held = leave_groups_out(forward, found, all);
  REQUIRE(held.size() == 3);
  CHECK(held[2].group == "c");
  CHECK(held[2].subjects == 3);
  // One observable of ten, the peak, is halved: sqrt(0.25 / 10). 0.005: effect of the prior.
  CHECK_NEAR(held[2].error_predicted, std::sqrt(0.025), 0.005);
  CHECK(held[2].error_fitted < 0.01);
  CHECK(leave_groups_out(forward, found, one_group).empty());
}

TEST("relative errors leave out absent observables") {
  const Eigen::VectorXd errors =
      relative_errors(Eigen::Vector3d(1.1, 2.0, 5.0), Eigen::Vector3d(1.0, std::nan(""), 4.0));
  CHECK_NEAR(root_mean_square(errors), std::sqrt((0.01 + 0.0625) / 2.0), 1e-15);
}

/// Calibration of the scene from one recording of another.
Calibration calibrated_from(const Scene& truth, const CalibrationOptions& options) {
  const std::vector<ObservedRecording> one{{.recording = {.name = "one"}, .seen = lawful(truth)}};
  return calibrate(three_layers(), parameters_of(three_layers()), one, options);
}

TEST("a calibration ends with a scene whose simulation gives the observations") {
  int stages = 0;
  const Calibration found = calibrated_from(
      with_thumb_force(9.0), {.progress = [&](const char*) { ++stages; }, .simulate = lawful});
  CHECK(found.outcome().status == Status::pass);
  CHECK(stages == 4);
  // With a gain of 1 % and a prior of 0.35, (0.01 / 0.35)^2 of the difference remains: < 0.1 %.
  CHECK_NEAR(found.fitted.syringe->thumb_force / 9.0, 1.0, 1e-3);
  CHECK_NEAR(found.shortcut_cost(), 0.0, 1e-12);  // the law has no shortcuts
}

TEST("shortcuts whose error exceeds the uncertainty of the data do not pass") {
  const auto with_shortcut = [](const Scene& at) {
    ObservedInsertion seen = lawful(at);
    if (at.simulation.step > 1.5e-3) { seen.value[0] *= 1.1; }  // the coarser one alone
    return seen;
  };
  const Calibration found = calibrated_from(three_layers(), {.simulate = with_shortcut});
  CHECK(found.shortcut_cost() > 5.0);
  CHECK(found.outcome().status != Status::pass);
}

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

TEST("a fit is not sound if more than two uncertainties remain") {
  Calibration result;
  result.fit.converged = true;
  result.fit.told = {0};
  CHECK(result.outcome().status == Status::pass);
  result.fit.widening = 2.1;
  CHECK(result.outcome().status == Status::fail);
}

TEST("data that constrain nothing leave every parameter at its prior") {
  Forward forward = lawful_forward();
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 50.0));
  CHECK(found.told.empty());
  CHECK(found.values() == forward.priors());
}

const Parameter* find(const std::vector<Parameter>& all, std::string_view key) {
  const auto found = std::ranges::find(all, key, &Parameter::key);
  return found == all.end() ? nullptr : &*found;
}

TEST("parameters are those of the layers before the epidural space and of the syringe") {
  const std::vector<Parameter> all = parameters_of(three_layers());
  CHECK(all.size() == 3 + 3 + 1 + 4);
  CHECK(find(all, "material.ligament.cutting_force") != nullptr);
  CHECK(find(all, "layer.0.thickness") != nullptr);
  CHECK(find(all, "material.epidural-space.youngs_modulus") == nullptr);
  CHECK(find(all, "material.ligament.cutting_force")->prior == 5.0);
}

TEST("one spread is one spread of the logarithm, and default bounds are four") {
  Parameter p{.key = "x", .prior = 2.0, .spread = 0.5};
  set_default_bounds(p);
  CHECK_NEAR(p.value(1.0), 2.0 * std::exp(0.5), 1e-14);  // rounding
  CHECK_NEAR(p.standardised(p.value(-2.5)), -2.5, 1e-14);
  CHECK_NEAR(p.standardised(p.upper), 4.0, 1e-14);
}

TEST("a thicker layer makes the drive as much deeper and the scene longer") {
  const Scene scene = three_layers();
  const std::vector<Parameter> all = parameters_of(scene);
  const Scene changed = with_values(scene, {*find(all, "layer.0.thickness")}, {0.015});
  CHECK_NEAR(*changed.drive->depth, 0.038, 1e-15);  // rounding
  CHECK_NEAR(changed.simulation.duration, 9.0, 1e-12);
  const auto keys = changes(scene, changed);
  REQUIRE(keys.size() == 3);
  CHECK(keys[0].first == "layer.0.thickness");
  CHECK(keys[1].first == "drive.depth");
  CHECK(changes(scene, scene).empty());
}

TEST("a scene that cannot be calibrated has a reason") {
  CHECK(why_not_calibrated(three_layers()).empty());
  const std::pair<const char*, void (*)(Scene&)> faults[] = {
      {"syringe", [](Scene& scene) { scene.syringe.reset(); }},
      {"drive.depth", [](Scene& scene) { scene.drive->depth = 0.029; }},
      {"layer", [](Scene& scene) { scene.tissue.layers.pop_back(); }}};
  for (const auto& [key, change] : faults) {
    Scene scene = three_layers();
    change(scene);
    CHECK(why_not_calibrated(scene).starts_with(key));
  }
}

TEST("bins of a force linear in depth are its values at their middles") {
  const ObservedInsertion seen = observe(straight_insertion());
  CHECK(seen.force == ForceSource::recorded);
  CHECK(seen.refusal.empty());
  // Two samples at 1 mm/s, and 100 N/m of these.
  CHECK_NEAR(seen.value[index_of(Observable::depth_of_loss)], 20e-3, 2e-5);
  CHECK_NEAR(seen.value[index_of(Observable::force)], 2.0 + 100.0 * 11e-3, 2e-3);
  CHECK_NEAR(seen.value[index_of(Observable::force) + 3], 2.0 + 100.0 * 17e-3, 2e-3);
}

TEST("without a recorded force the plunger gives it in the continuous technique alone") {
  Recording recording = straight_insertion();
  recording.force.clear();
  const ObservedInsertion driven = observe(recording);
  CHECK(driven.force == ForceSource::plunger);
  // Eq. 1, a level pressure.
  CHECK_NEAR(driven.value[index_of(Observable::force)], 60e3 * recording.plunger_area, 1e-9);
  recording.technique = "intermittent";
  const ObservedInsertion pushed = observe(recording);
  CHECK(pushed.force == ForceSource::none);
  CHECK(std::isnan(pushed.value[index_of(Observable::force)]));
  CHECK_NEAR(pushed.value[index_of(Observable::plateau)], 2000.0, 1e-6);  // rounding: constant
}

TEST("a pressure that is not lost is refused, and without depth there are no bins") {
  CHECK_CONTAINS(observe(straight_insertion(60e3, 20e-3, 59e3)).refusal, "no loss of resistance");
  Recording recording = straight_insertion();
  recording.depth.clear();
  const ObservedInsertion seen = observe(recording);
  CHECK(seen.refusal.empty());
  CHECK(std::isnan(seen.value[index_of(Observable::force)]));
  CHECK(std::isfinite(seen.value[index_of(Observable::force_peak)]));
  CHECK(observe(Trace{.time = {0.0, 1.0}}).refusal == "has no syringe or no tool");
}

TEST("every observable has a name and a unit of its own kind") {
  CHECK(name_of(0) == "pressure.peak");
  CHECK(name_of(observable_count - 1) == "force.-2_to_-0.5_mm");
  CHECK(unit_of(0) == "Pa");
  CHECK(unit_of(observable_count - 1) == "N");
  CHECK(unit_of(index_of(Observable::drop_time)) == "s");
  CHECK(unit_of(index_of(Observable::depth_of_loss)) == "m");
}

TEST("the coarser block is as wide, and its duration ends a given time after the motion") {
  Scene scene = three_layers();
  scene.tissue.block = {.nodes = {9, 9}, .spacing = 0.005};
  const Scene coarse = coarser(scene, {.after = 3.0});
  CHECK(coarse.tissue.block.nodes[0] == 3);
  CHECK_NEAR(coarse.tissue.block.spacing * 2.0, 0.005 * 8.0, 1e-15);
  CHECK_NEAR(coarse.simulation.step, 4.0 * scene.simulation.step, 1e-15);
  CHECK_NEAR(coarse.simulation.duration, 0.033 / 0.005 + 3.0, 1e-12);
  scene.tissue.block.nodes = {8, 8};  // no node in the middle
  CHECK(coarser(scene).tissue.block.nodes[0] == 8);
}

TEST("equal parameter values are simulated once, whatever the number of threads") {
  const Scene scene = three_layers();
  for (const int jobs : {1, 3}) {
    std::atomic<int> calls{0};
    Forward forward(scene, parameters_of(scene), jobs, nullptr, [&](const Scene& at) {
      ++calls;
      return lawful(at);
    });
    Forward::Values other = forward.priors();
    other.back() *= 2.0;
    const auto seen = forward.at({forward.priors(), other, forward.priors()});
    CHECK(calls == 2);
    CHECK(forward.simulations() == 2);
    CHECK(seen[0] == seen[2]);
    CHECK(seen[1][1] == 2.0 * seen[0][1]);
  }
}

TEST("parameter values at which the scene fails are named, and a stop ends it") {
  Forward forward(three_layers(), parameters_of(three_layers()), 1, nullptr,
                  [](const Scene&) { return ObservedInsertion{.refusal = "diverges"}; });
  Forward::Values place = forward.priors();
  place[0] = 0.75;
  CHECK_THROWS_AS(std::runtime_error, forward.at(place),
                  "material.firm-fat.cutting_force = 0.75 N diverges");
  const std::atomic<bool> stop{true};
  Forward stopped(three_layers(), parameters_of(three_layers()), 1, &stop, lawful);
  CHECK_THROWS(stopped.at(stopped.priors()), "interrupted");
}

}  // namespace PALPATE_FILE

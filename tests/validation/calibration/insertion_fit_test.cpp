// SPDX-License-Identifier: MIT

#include "validation/calibration/insertion_fit.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::calibration;
using comparison::Feature;

constexpr double speed = 2e-3;
constexpr double stroke = 20e-3;
constexpr double hold = 5.0;
constexpr double rate = 1000.0;  // so fine that features are smooth in the parameters

/// Phantom of one material.
Scene phantom(const std::string& material, double friction) {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.layers = {{.tissue = material, .material = material, .thickness = 0.03}};
  Material& tissue = scene.materials.emplace_back();
  tissue.name = material;
  tissue.youngs_modulus = 3e5;
  tissue.density = 1000.0;
  tissue.cutting_force = 0.4;
  tissue.puncture_force = 4.0;
  tissue.friction = friction;
  scene.needle.emplace();
  scene.drive.emplace();
  scene.drive->kind = Drive::Kind::trajectory;
  scene.drive->speed = scene.drive->withdraw_speed = speed;
  scene.drive->depth = stroke;
  return scene;
}

/// An insertion in closed form: a power of the depth up to the puncture, then cutting and friction;
/// the friction falls while the needle rests and is reversed on its way out. All is `factor` times
/// the usual: forces, dent, exponent and relaxation.
Trace insertion_of(const Scene& scene, double factor) {
  Trace trace{.columns = {{"tool.force_n", "N", {}}, {"tool.depth_m", "m", {}}}};
  const Material& tissue = scene.materials.front();
  const double usual = 2.4e3 * *tissue.puncture_force / tissue.youngs_modulus;  // 32 mm for 4 N
  const double dent = 0.3 * factor * usual;
  const double advance = stroke / speed;
  for (double t = -1.0; t < 2.0 * advance + hold; t += 1.0 / rate) {
    const double depth = t < advance          ? speed * t
                         : t < advance + hold ? stroke
                                              : stroke - speed * (t - advance - hold);
    const double friction = factor * tissue.friction * std::max(depth, 0.0);
    const double cutting = factor * tissue.cutting_force;
    double force = 0.0;
    if (t < advance && depth > 0.0) {
      force = depth < dent ? factor * *tissue.puncture_force * std::pow(depth / dent, 1.4 * factor)
                           : cutting + friction;
    } else if (t >= advance && t < advance + hold) {
      const double left = std::exp(-(t - advance) / factor);
      force = cutting + friction * (1.0 - 0.3 * factor * (1.0 - left));
    } else if (t >= advance + hold) {
      force = -friction;
    }
    trace.time.push_back(t);
    trace.columns[0].values.push_back(force);
    trace.columns[1].values.push_back(depth);
  }
  return trace;
}
Trace insertion(const Scene& scene) { return insertion_of(scene, 1.0); }

/// Recordings of insertions into the tissue with two needles that differ by 4 %.
std::vector<Recording> recorded(const Scene& truth) {
  std::vector<Recording> all;
  for (const int needle : {2, 3}) {
    for (const double repeat : {-0.02, 0.0, 0.02}) {
      const Trace trace = insertion_of(truth, 1.0 + repeat + (needle == 2 ? -0.02 : 0.02));
      Recording& one = all.emplace_back();
      one.name = std::to_string(needle) + "/" + std::to_string(repeat);
      one.kind = Recording::Kind::measured_phantom;
      one.subject = std::to_string(needle);
      one.sample_rate = rate;
      one.time = trace.time;
      one.force = trace.columns[0].values;
      one.depth = trace.columns[1].values;
    }
  }
  return all;
}

std::vector<Condition> conditions(double friction_of_predicted = 90.0) {
  const Scene skin = phantom("skin", 60.0);
  const Scene muscle = phantom("muscle", 60.0);
  const Scene truth_skin = phantom("skin", 90.0);
  const Scene truth_muscle = phantom("muscle", 45.0);
  const Scene predicted = phantom("skin", friction_of_predicted);
  return {{.name = "skin", .scene = skin, .recordings = recorded(truth_skin)},
          {.name = "muscle", .scene = muscle, .recordings = recorded(truth_muscle)},
          {.name = "again", .scene = skin, .recordings = recorded(predicted), .fitted = false}};
}

InsertionFit fitted(const std::vector<Condition>& given, InsertionFitOptions options = {}) {
  options.simulate = insertion;
  return fit_insertions(given, parameters_of(given), options);
}

const FittedParameter& of(const InsertionFit& result, const std::string& key) {
  return *std::ranges::find(result.fit.parameters, key,
                            [](const FittedParameter& one) { return one.parameter.key; });
}

TEST("insertions of two tissues give their parameters back, and predict others") {
  const InsertionFit result = fitted(conditions(), {.starts = 3});
  CHECK(result.fit.converged);
  // 95 % intervals contain the truth, to which the mean of the recordings is equal.
  CHECK(of(result, "material.skin.friction").interval.holds(90.0));
  CHECK(of(result, "material.muscle.friction").interval.holds(45.0));
  CHECK_NEAR(of(result, "material.skin.friction").value, 90.0, 1.0);
  CHECK_NEAR(of(result, "material.muscle.friction").value, 45.0, 1.0);
  CHECK_NEAR(of(result, "material.skin.puncture_force").value, 4.0, 0.1);
  CHECK(result.misfits.size() == 3);
  for (const double misfit : result.misfits) { CHECK_NEAR(misfit, result.misfits[0], 0.1); }
  REQUIRE(result.conditions.size() == 3);
  CHECK(result.conditions[2].group().features.size() > 9);
  CHECK(result.outcome().status == Status::pass);
  REQUIRE(result.left_out.size() == 2);
  CHECK(result.left_out[0].needle == "2");
  CHECK(result.left_out[0].conditions.size() == 3);
}

TEST("values beyond which a scene diverges do not narrow an interval") {
  const auto given = conditions();
  const InsertionFit free = fitted(given);
  const InsertionFit limited =
      fit_insertions(given, parameters_of(given), {.simulate = [](const Scene& scene) {
                       Trace trace = insertion(scene);
                       // A step of the slopes above the fit of 90 N/m is 2.5 N/m.
                       trace.diverged = scene.materials.front().name == "skin" &&
                                        scene.materials.front().friction > 91.0;
                       return trace;
                     }});
  const auto width = [](const InsertionFit& result) {
    const FittedParameter& one = of(result, "material.skin.friction");
    return one.interval.upper - one.interval.lower;
  };
  CHECK_NEAR(of(limited, "material.skin.friction").value, 90.0, 1.0);
  // One-sided differences to either side differ by the curvature over a step of 3 %.
  CHECK_NEAR(width(limited) / width(free), 1.0, 0.1);
}

TEST("a condition that differs from its prediction fails and says in what") {
  const InsertionFit result = fitted(conditions(120.0));
  const Outcome outcome = result.outcome();
  CHECK(outcome.status == Status::fail);
  const auto failed = [&](const std::string& name) {
    return std::ranges::any_of(outcome.quantities, [&](const Quantity& one) {
      return one.name == name && one.value > one.upper;
    });
  };
  CHECK(failed("again: withdrawal_force"));
  CHECK(!failed("again: puncture_force"));
}

TEST("without predicted conditions the fitted ones are judged") {
  std::vector<Condition> given = conditions();
  given.pop_back();
  const Outcome outcome = fitted(given).outcome();
  CHECK(outcome.status == Status::pass);
  CHECK(outcome.quantities.size() > 10);
}

TEST("a fit of nothing, and a condition without features, show nothing") {
  InsertionFit result = fitted(conditions());
  CHECK(result.outcome().status == Status::pass);
  InsertionFit blind = result;
  for (comparison::FeatureSummary& one : blind.conditions.back().comparison.groups[0].features) {
    one.deviation = std::numeric_limits<double>::quiet_NaN();
  }
  CHECK(judged_features(blind.conditions.back()).empty());
  CHECK(blind.outcome().status == Status::fail);
  result.fit.told.clear();
  CHECK(result.outcome().status == Status::fail);
}

TEST("a condition needs a needle that is withdrawn, and recordings with force and depth") {
  Condition one = conditions().front();
  CHECK(why_not_calibrated(one).empty());
  one.recordings.front().depth.clear();
  CHECK(why_not_calibrated(one).find("lacks the depth") != std::string::npos);
  one = conditions().front();
  one.scene.drive->withdraw_speed = 0.0;
  CHECK(why_not_calibrated(one).find("withdraw_speed") != std::string::npos);
  one.recordings.clear();
  one.scene.drive->withdraw_speed = speed;
  CHECK(why_not_calibrated(one).find("no recording") != std::string::npos);
}

TEST("a simulated insertion without a puncture has the largest force in its place") {
  Scene scene = phantom("skin", 60.0);
  scene.materials.front().puncture_force = 20.0;  // 48 mm deep, beyond the stroke
  const Observation seen = simulated_features(insertion(scene));
  CHECK(std::isfinite(seen[0]));
  CHECK(seen[0] == seen[4]);
  // From the contact at 0.1 N.
  CHECK_NEAR(seen[1], stroke - 0.048 * std::pow(0.1 / 20.0, 1.0 / 1.4), 0.3e-3);
}

}  // namespace PALPATE_FILE

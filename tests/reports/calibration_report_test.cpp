// SPDX-License-Identifier: MIT

#include "reports/calibration_report.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

namespace {

using namespace palpate::calibration;
using namespace palpate;

bool warns(const CalibrationReport& report, std::string_view part) {
  for (const std::string& each : calibration_warnings(report)) {
    if (check::contains(each, part)) { return true; }
  }
  return false;
}

CalibrationReport sample(Recording::Kind kind) {
  const Scene scene = three_layers();
  CalibrationReport report{
      .scene = "<scene>.toml", .scene_hash = "abc", .command = "palpate calibrate a.h5"};
  std::vector<ObservedRecording> subjects;
  for (const char* group : {"a", "a", "a", "b", "b", "b"}) {
    Scene other = scene;
    const double factor = 1.0 + 0.01 * static_cast<double>(subjects.size());
    other.syringe->thumb_force *= factor;
    other.materials[1].cutting_force *= factor;
    subjects.push_back(
        {.recording = {.name = "one", .kind = kind, .group = group, .technique = "continuous"},
         .seen = lawful(other)});
    subjects.back().seen.force = ForceSource::plunger;
    report.recordings.push_back({.file = "a.h5", .hash = "f00", .observed = subjects.back()});
  }
  report.result = calibrate(scene, parameters_of(scene), subjects, {.simulate = lawful});
  return report;
}

TEST("calibration.json says what was told, what was not, and to which recordings") {
  const CalibrationReport report = sample(Recording::Kind::measured);
  const auto json = nlohmann::json::parse(to_json(report));
  CHECK(json["schema"] == 1);
  CHECK(json["held"] == true);
  CHECK(json["parameters"].size() == 11);
  CHECK(json["parameters"][0]["status"] == "insensitive");
  CHECK(json["recordings"][0]["hash"] == "f00");
  CHECK(json["leave_one_group_out"].size() == 2);
  CHECK(json["leave_one_group_out"][1]["group"] == "b");
  CHECK(json["correlation"]["matrix"].size() == json["correlation"]["parameters"].size());
  CHECK(json["profile"]["value"].size() == json["profile"]["growth"].size());
  CHECK(to_json(report) == to_json(sample(Recording::Kind::measured)));
}

TEST("the page begins with the verdict, escapes names and names what is left") {
  const CalibrationReport report = sample(Recording::Kind::measured);
  const std::string page = to_html(report);
  CHECK(page.find(calibration_verdict(report)) < page.find("<table"));
  CHECK_CONTAINS(page, "&lt;scene&gt;.toml");
  CHECK(!check::contains(page, "<scene>"));
  CHECK(warns(report, "material.ligament.friction"));
  CHECK_CONTAINS(page, "palpate calibrate a.h5");
}

TEST("reconstructed recordings are never taken for measured ones") {
  const CalibrationReport made_up = sample(Recording::Kind::reconstructed);
  CHECK_CONTAINS(calibration_detail(made_up), "no evidence about patients");
  CHECK(warns(made_up, "give back what was put into them"));
  CHECK(!check::contains(calibration_detail(sample(Recording::Kind::measured)), "no evidence"));
}

TEST("what nobody reads in a verdict is said: another plunger, no BMI, a search that failed, NaN") {
  CalibrationReport report = sample(Recording::Kind::measured);
  CHECK(!warns(report, "plunger of another area"));
  CHECK(!warns(report, "Without b"));
  CHECK(!warns(report, "no BMI"));
  report.recordings[2].observed.recording.plunger_area *= 0.5;
  report.result.held_out[1].converged = false;
  CHECK(
      warns(report, "1 recording is of a plunger of another area than the scene's 0.0001767 m^2"));
  CHECK(warns(report, "Without b the search did not converge"));
  report.recordings[0].observed.recording.body_mass_index = 30.0;
  CHECK(warns(report, "5 of 6 recordings have no BMI: no depth was moved"));
  for (CalibratedRecording& each : report.recordings) {
    each.observed.recording.body_mass_index = 30.0;
  }
  CHECK(!warns(report, "no BMI"));
  report.result.whole[0] = std::nan("");
  CHECK(report.result.outcome().status != Status::pass);
  CHECK(warns(report, "too coarse"));
}

TEST("a parameter that moves what was seen by half its uncertainty is not said to move nothing") {
  const CalibrationReport report = sample(Recording::Kind::measured);
  CHECK(!warns(report, "nothing that was seen depends"));
  CHECK(warns(report, "moves what was seen by less than that is uncertain: "));
}

TEST("a fit that does not hold says so first") {
  CalibrationReport report = sample(Recording::Kind::measured);
  report.result.fit.converged = false;
  CHECK(calibration_verdict(report).starts_with("Fell short"));
  CHECK(warns(report, "did not converge"));
  report.result.fit.told.clear();
  CHECK(calibration_verdict(report).starts_with("Nothing fitted"));
}

}  // namespace

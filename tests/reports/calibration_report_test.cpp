// SPDX-License-Identifier: MIT

#include "reports/calibration_report.hpp"

#include <nlohmann/json.hpp>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::calibration;
using namespace palpate;

std::string warnings(const CalibrationReport& report) {
  std::string all;
  for (const std::string& each : calibration_warnings(report)) { all += each + "\n"; }
  return all;
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

TEST("calibration.json has each parameter with its status, and the recordings") {
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

TEST("the page begins with the verdict, escapes names and lists unfitted parameters") {
  const CalibrationReport report = sample(Recording::Kind::measured);
  const std::string page = to_html(report);
  CHECK_ORDER(page, calibration_verdict(report), "<table");
  CHECK_CONTAINS(page, "&lt;scene&gt;.toml", "palpate calibrate a.h5");
  CHECK_LACKS(page, "<scene>");
  CHECK_CONTAINS(warnings(report), "material.ligament.friction");
}

TEST("reconstructed recordings are never taken for measured ones") {
  const CalibrationReport made_up = sample(Recording::Kind::reconstructed);
  CHECK_CONTAINS(calibration_detail(made_up), "no evidence about patients");
  CHECK_CONTAINS(warnings(made_up), "give back what was put into them");
  CHECK_LACKS(calibration_detail(sample(Recording::Kind::measured)), "no evidence");
}

TEST("the page warns of another plunger, missing BMI, a failed search and NaN") {
  CalibrationReport report = sample(Recording::Kind::measured);
  CHECK_LACKS(warnings(report), "plunger of another area", "Without b", "no BMI",
              "nothing that was seen depends");
  // A parameter that moves the data by half their uncertainty is not said to move nothing.
  CHECK_CONTAINS(warnings(report), "moves what was seen by less than that is uncertain: ");
  report.recordings[2].observed.recording.plunger_area *= 0.5;
  report.result.held_out[1].converged = false;
  report.recordings[0].observed.recording.body_mass_index = 30.0;
  CHECK_CONTAINS(warnings(report),
                 "1 recording is of a plunger of another area than the scene's 0.0001767 m^2",
                 "Without b the search did not converge",
                 "5 of 6 recordings have no BMI: no depth was moved");
  for (CalibratedRecording& each : report.recordings) {
    each.observed.recording.body_mass_index = 30.0;
  }
  CHECK_LACKS(warnings(report), "no BMI");
  report.result.whole[0] = std::nan("");
  CHECK(report.result.outcome().status != Status::pass);
  CHECK_CONTAINS(warnings(report), "too coarse");
}

TEST("the verdict of a fit that fails begins with the failure") {
  CalibrationReport report = sample(Recording::Kind::measured);
  report.result.fit.converged = false;
  CHECK(calibration_verdict(report).starts_with("Fell short"));
  CHECK_CONTAINS(warnings(report), "did not converge");
  report.result.fit.told.clear();
  CHECK(calibration_verdict(report).starts_with("Nothing fitted"));
}

}  // namespace PALPATE_FILE

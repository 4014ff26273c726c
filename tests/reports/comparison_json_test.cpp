// SPDX-License-Identifier: MIT
#include "reports/comparison_json.hpp"

#include <nlohmann/json.hpp>

#include "tests/check.hpp"
#include "tests/reports/comparison_sample.hpp"

using namespace palpate;

namespace {

using Json = nlohmann::json;

Json json_of(const ComparisonReport& report) { return Json::parse(to_json(report)); }

std::vector<ComparedRecording> three() {
  return {sample::compared_recording("a", 0.98), sample::compared_recording("b", 1.0),
          sample::compared_recording("c", 1.02, Recording::Kind::measured)};
}

}  // namespace

TEST("comparison.json has the documented keys") {
  const Json json = json_of(sample::compared(three()));
  for (const char* key :
       {"schema", "verdict", "holds", "sentence", "reasons", "quantity", "unit", "simulation", "options",
        "recordings", "groups", "credibility", "command", "provenance"}) {
    CHECK(json.contains(key));
  }
  const Json& one = json["recordings"][0];
  for (const char* key :
       {"file",          "format",          "fnv1a",          "kind",      "regime",
        "name",          "source",          "note",           "group",     "technique",     "subject",
        "bmi_kg_per_m2", "plunger_area_m2", "sample_rate_hz", "samples",   "defects",
        "warnings",      "verdict",         "reasons",        "alignment", "cutoff_hz",
        "overlap_s",     "features",        "distances",      "rating",    "unfiltered_rating",
        "rated_share"}) {
    CHECK(one.contains(key));
  }
  CHECK(one["features"].size() == comparison::feature_count);
  CHECK(one["kind"] == "reconstructed" && json["recordings"][2]["kind"] == "measured");
}

TEST("numbers are those of the comparison, in SI") {
  const ComparisonReport report = sample::compared(three());
  const Json json = json_of(report);
  const comparison::Comparison& one = report.found.recordings[1];
  const Json& peak = json["recordings"][1]["features"][1];
  CHECK(peak["name"] == "peak" && peak["unit"] == "Pa");
  CHECK(peak["recorded"].get<double>() == *one.features[1].recorded.value);
  CHECK(peak["u_val"].get<double>() == one.features[1].uncertainty.total());
  CHECK(json["recordings"][1]["rating"]["overall"].get<double>() == one.rating->overall);
  CHECK(json["recordings"][1]["alignment"]["lag_s"].get<double>() == one.alignment.lag);
  const Json& group = json["groups"][0];
  CHECK(group["recordings"] == 3 && group["measured"] == 1 && group["reconstructed"] == 2);
  CHECK(group["corridor"]["recordings"] == 3 && group["corridor"]["subjects"] == 3);
  CHECK(group["subjects"] == 3 && group["subjects_agree"] == 3);
  CHECK_NEAR(group["corridor"]["half_width_sd"].get<double>(), 4.968,
             1e-3);  // t(0.975, 2) sqrt(4/3), four digits
  CHECK(json["verdict"] == "agrees" && json["holds"] == true);
}

TEST("what cannot be compared has a reason and no numbers") {
  const Json json = json_of(sample::compared({sample::compared_recording("flat", 0.0)}));
  const Json& one = json["recordings"][0];
  CHECK(json["verdict"] == "not comparable" && json["holds"] == false);
  CHECK(one["verdict"] == "not comparable" && !one["reasons"].empty() && !one.contains("features"));
  CHECK(json["groups"][0]["corridor"].contains("refused"));
  CHECK(json["groups"][0]["agree_share"] == "nan" && json["groups"][0]["agree_interval_95"].is_null());
}

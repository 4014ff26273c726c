// SPDX-License-Identifier: MIT
/// Synthetic insertions compared with each other, in the form that the command passes to its
/// reports.

#include "reports/comparison_report.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "model/problem/recording.hpp"
#include "tests/check.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace {

using namespace palpate;
using comparison::Feature;
using comparison::QuantityKind;
using comparison::Tolerance;
using Json = nlohmann::json;

/// Recording of the analytic signal at 120 Hz times a factor, with a depth that increases at 5
/// mm/s.
RecordingFile compared_recording(const std::string& name, double factor,
                                 Recording::Kind kind = Recording::Kind::reconstructed) {
  const std::vector<double> time = clinical::instants(14.0, 120.0);
  std::vector<double> pressure = clinical::pressures({}, time);
  for (double& p : pressure) { p *= factor; }
  RecordingFile one{.file = name + ".h5", .hash = "0123"};
  one.input.recording = clinical::recording_of(time, pressure);
  one.input.recording.name = name;
  one.input.recording.kind = kind;
  one.input.recording.group = "BMI <18>";
  for (const double t : time) { one.input.recording.depth.push_back(5e-3 * t); }
  return one;
}

Trace compared_trace() {
  const std::vector<double> time = clinical::instants(14.0, 1000.0);
  Trace trace = clinical::trace_of(time, clinical::pressures({}, time));
  Column depth{"tool.depth_m", "m", {}};
  Column force{"tool.force_n", "N", {}};
  TextColumn layer{"tool.layer", {}};
  for (const double t : time) {
    depth.values.push_back(5e-3 * t);
    force.values.push_back(t < 6.0 ? t : 1.0);
    layer.values.push_back(t < 6.0 ? "flavum" : "epidural <space>");
  }
  trace.columns.push_back(depth);
  trace.columns.push_back(force);
  trace.text_columns = {layer};
  trace.events = {{6.0, "loss-of-resistance", "epidural <space>"}};
  return trace;
}

ComparisonReport compared(std::vector<RecordingFile> recordings, Trace trace = compared_trace()) {
  ComparisonReport report{
      .recordings = std::move(recordings),
      .simulation = {.file = "trace.h5", .hash = "4567", .trace = std::move(trace)},
      .provenance = {{"version", "0.1.0"}},
      .command = "palpate compare <x> --trace trace.h5"};
  std::vector<Recording> all;
  for (const RecordingFile& one : report.recordings) { all.push_back(one.input.recording); }
  report.found = comparison::compare_all(all, report.simulation.trace, report.options);
  report.credibility = comparison::credibility({}, &report.found);
  return report;
}

TEST("a width is a share, a number with its unit, their sum or a factor") {
  const Tolerance share = tolerance_from("peak=15%", QuantityKind::pressure);
  CHECK(share.feature == Feature::peak);
  CHECK(share.absolute == 0.0);
  CHECK_NEAR(share.relative, 0.15, 1e-15);
  CHECK_NEAR(tolerance_from("plateau=7mmHg", QuantityKind::pressure).absolute,
             7.0 * pascals_per_mmhg, 1e-9);
  const Tolerance both = tolerance_from("slope_before=30%+5mmHg/s", QuantityKind::pressure);
  CHECK_NEAR(both.relative, 0.3, 1e-15);
  CHECK_NEAR(both.absolute, 5.0 * pascals_per_mmhg, 1e-9);
  CHECK(tolerance_from("drop_time=x2.5", QuantityKind::pressure).factor == 2.5);
  CHECK(tolerance_from("relative_drop=0.1", QuantityKind::pressure).absolute == 0.1);
  CHECK_NEAR(tolerance_from("depth_of_loss=3mm", QuantityKind::force).absolute, 3e-3, 1e-15);
  CHECK_NEAR(tolerance_from("time_of_loss=250ms", QuantityKind::force).absolute, 0.25, 1e-15);
}

TEST("what is no tolerance is refused with what is allowed") {
  const auto refused = [](const std::string& text, const char* message) {
    CHECK_THROWS(tolerance_from(text, QuantityKind::pressure), message);
  };
  refused("peak", "must be such as peak=15%");
  refused("peak=", "must be such as peak=15%");
  refused("peek=3%", "did you mean peak");
  refused("loss_of_resistance=1", "found or not, which has no width");
  refused("peak=7", "must be % or a unit of Pa");  // mmHg or Pa?
  refused("drop_time=0.5", "must be % or a unit of s");
  refused("peak=much", "must be such as");
  refused("peak=-5%", "must be such as");
  refused("peak=5mm", "must be % or a unit of Pa");
  refused("plateau=1N", "must be % or a unit of Pa");
  refused("drop_time=x1", "a factor must be a number > 1");
  refused("drop_time=xs", "must be such as");
}

TEST("the defaults that --help shows are those in force") {
  for (const QuantityKind quantity : {QuantityKind::pressure, QuantityKind::force}) {
    std::istringstream lines(tolerance_help(quantity));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      const Tolerance shown = tolerance_from(line.substr(2), quantity);
      const Tolerance used =
          comparison::default_tolerances(quantity).at(static_cast<std::size_t>(shown.feature));
      // Three digits are shown.
      CHECK_NEAR(shown.absolute, used.absolute, 5e-3 * used.absolute + 1e-300);
      CHECK_NEAR(shown.relative, used.relative, 5e-3 * used.relative + 1e-300);
      CHECK(shown.factor == used.factor);
    }
    CHECK(count == comparison::feature_count - 1);
  }
}

Json json_of(const ComparisonReport& report) { return Json::parse(to_json(report)); }

std::vector<RecordingFile> three() {
  return {compared_recording("a", 0.98), compared_recording("b", 1.0),
          compared_recording("c", 1.02, Recording::Kind::measured)};
}

TEST("comparison.json has the documented keys") {
  const Json json = json_of(compared(three()));
  for (const char* key :
       {"schema", "verdict", "holds", "sentence", "reasons", "quantity", "unit", "simulation",
        "options", "recordings", "groups", "credibility", "command", "provenance"}) {
    CHECK(json.contains(key));
  }
  const Json& one = json["recordings"][0];
  for (const char* key : {"file",
                          "format",
                          "fnv1a",
                          "kind",
                          "regime",
                          "name",
                          "source",
                          "note",
                          "group",
                          "technique",
                          "subject",
                          "bmi_kg_per_m2",
                          "plunger_area_m2",
                          "sample_rate_hz",
                          "samples",
                          "defects",
                          "warnings",
                          "verdict",
                          "reasons",
                          "alignment",
                          "cutoff_hz",
                          "overlap_s",
                          "features",
                          "distances",
                          "rating",
                          "unfiltered_rating",
                          "rated_share"}) {
    CHECK(one.contains(key));
  }
  CHECK(one["features"].size() == comparison::feature_count);
  CHECK(one["kind"] == "reconstructed");
  CHECK(json["recordings"][2]["kind"] == "measured");
}

TEST("numbers are those of the comparison, in SI") {
  const ComparisonReport report = compared(three());
  const Json json = json_of(report);
  const comparison::Comparison& one = report.found.recordings[1];
  const Json& peak = json["recordings"][1]["features"][1];
  CHECK(peak["name"] == "peak");
  CHECK(peak["unit"] == "Pa");
  CHECK(peak["recorded"].get<double>() == *one.features[1].recorded.value);
  CHECK(peak["u_val"].get<double>() == one.features[1].uncertainty.total());
  CHECK(json["recordings"][1]["rating"]["overall"].get<double>() == one.rating->overall);
  CHECK(json["recordings"][1]["alignment"]["lag_s"].get<double>() == one.alignment.lag);
  const Json& group = json["groups"][0];
  CHECK(group["recordings"] == 3);
  CHECK(group["measured"] == 1);
  CHECK(group["reconstructed"] == 2);
  CHECK(group["corridor"]["recordings"] == 3);
  CHECK(group["corridor"]["subjects"] == 3);
  CHECK(group["subjects"] == 3);
  CHECK(group["subjects_agree"] == 3);
  CHECK_NEAR(group["corridor"]["half_width_sd"].get<double>(), 4.968,
             1e-3);  // t(0.975, 2) sqrt(4/3), four digits
  CHECK(json["verdict"] == "agrees");
  CHECK(json["holds"] == true);
}

TEST("what cannot be compared has a reason and no numbers") {
  const Json json = json_of(compared({compared_recording("flat", 0.0)}));
  const Json& one = json["recordings"][0];
  CHECK(json["verdict"] == "not comparable");
  CHECK(json["holds"] == false);
  CHECK(one["verdict"] == "not comparable");
  CHECK(!one["reasons"].empty());
  CHECK(!one.contains("features"));
  CHECK(json["groups"][0]["corridor"].contains("refused"));
  CHECK(json["groups"][0]["agree_share"] == "nan");
  CHECK(json["groups"][0]["agree_interval_95"].is_null());
}

std::vector<RecordingFile> subjects(std::size_t count) {
  std::vector<RecordingFile> all;
  for (std::size_t n = 0; n < count; ++n) {
    const double middle = 0.5 * static_cast<double>(count - 1);
    all.push_back(compared_recording("subject-" + std::to_string(n),
                                     1.0 + 0.02 * (static_cast<double>(n) - middle)));
  }
  return all;
}

TEST("only what agrees and could all be compared holds") {
  CHECK(holds(compared(subjects(1))));
  CHECK(!holds(compared({compared_recording("loud", 1.5)})));
  std::vector<RecordingFile> with_a_constant = subjects(1);
  with_a_constant.push_back(compared_recording("flat", 0.0));
  const ComparisonReport mixed = compared(with_a_constant);
  CHECK(mixed.found.outcome.status == Status::pass);
  CHECK(!holds(mixed));
  CHECK(verdict_text(mixed) == "Agrees, but 1 recording cannot be compared");
  CHECK(!holds(compared({})));
}

TEST("the figures of a recording show both over time and depth, with layers, and the residual") {
  const ComparisonReport report = compared(subjects(1));
  const std::vector<Figure> figures = recording_figures(report, 0);
  REQUIRE(figures.size() == 5);
  for (const Figure& figure : figures) {
    CHECK(figure.zones.size() == 2);
    CHECK(figure.marks.size() == 1);
  }
  CHECK(figures[0].id == "pressure-over-time");
  CHECK(figures[2].id == "pressure-over-depth");
  CHECK(figures[0].series[0].label == "recorded");
  CHECK(figures[0].series[1].label == "simulated");
  const double peak_mmhg =
      60.0 * pascals_per_mmhg / pascals_per_mmhg;  // peak of the analytic signal
  CHECK_NEAR(figures[0].series[1].y[6000], peak_mmhg, 1e-6);
  CHECK_NEAR(figures[2].series[0].x.back(), 5.0 * 14.0, 1e-9);  // mm
  // Both were sampled from one law, which is a straight line at 3 s: the filter passes it
  // unchanged.
  CHECK(std::abs(figures[4].series[0].y[360]) < 1e-6);
}

TEST("every figure that shows a reconstructed recording says so, and none of a measured one does") {
  const ComparisonReport report = compared(subjects(3));
  for (const Figure& figure : recording_figures(report, 0)) {
    CHECK_CONTAINS(figure.caption, "reconstructed from published summary values, not measured");
  }
  for (const Figure& figure : group_figures(report, 0)) {
    CHECK(check::contains(figure.caption,
                          "3 of 3 recordings: reconstructed from published summary values"));
  }
  const ComparisonReport measured =
      compared({compared_recording("patient", 1.0, Recording::Kind::measured)});
  for (const Figure& figure : recording_figures(measured, 0)) {
    CHECK(!check::contains(figure.caption, "reconstructed"));
  }
  CHECK(!check::contains(verdict_sentence(measured), "reconstructed"));
}

TEST("the corridor is the mean and its factor of deviations either way") {
  const ComparisonReport report = compared(subjects(3));
  const std::vector<Figure> figures = group_figures(report, 0);
  REQUIRE(figures.size() == 2);
  CHECK(figures[0].series.size() == 3);
  const Series& band = figures[0].series[0];
  const Series& mean = figures[0].series[1];
  // Three subjects with factors 0.98, 1, 1.02: SD 2 %; t(0.975, 2) sqrt(4/3) = 4.303 x 1.1547
  // = 4.968.
  const std::size_t early = 60;  // before the rise, 20 mmHg
  CHECK_NEAR(band.y2[early] - mean.y[early], 4.968 * 0.02 * mean.y[early], 1e-3 * mean.y[early]);
  CHECK(group_figures(compared(subjects(2)), 0).empty());
}

TEST("a recording without depth, and a trace without it, have no figures over depth") {
  std::vector<RecordingFile> one = subjects(1);
  one[0].input.recording.depth.clear();
  CHECK(recording_figures(compared(one), 0).size() == 3);
  Trace trace = compared_trace();
  std::erase_if(trace.columns, [](const Column& column) { return column.name == "tool.depth_m"; });
  trace.events.clear();
  CHECK(recording_figures(compared(subjects(1), trace), 0).size() == 3);
}

TEST(
    "the page answers in order, makes no request, escapes what it shows and gives the same bytes "
    "twice") {
  const ComparisonReport report = compared(subjects(4));
  const std::string html = to_html(report);
  std::size_t last = 0;
  for (const char* heading :
       {"class=\"verdict pass\"", "Key facts", "What was compared", "Groups of subjects",
        "Every recording", "Ratings and distances", "What was found wrong", "Tolerances in force",
        "Credibility factors", "To see it again"}) {
    const std::size_t at = html.find(heading);
    CHECK(at != std::string::npos);
    CHECK(at > last);
    last = at;
  }
  for (const char* request : {"src=\"http", "href=\"http", "url(http", "@import", "BMI <18>",
                              "compare <x>", "epidural <space>"}) {
    CHECK(!check::contains(html, request));
  }
  CHECK(html == to_html(report));
}

TEST("the page tells recordings from subjects") {
  std::vector<RecordingFile> all = subjects(6);
  for (std::size_t n = 0; n < 6; ++n) { all[n].input.recording.subject = std::to_string(n / 2); }
  const std::string html = to_html(compared(all));
  CHECK_CONTAINS(html, "6 recordings reconstructed");
  CHECK_CONTAINS(html, "3 subjects (6 recordings)");
  CHECK_CONTAINS(html, "data-label=\"subjects\">3<");
  CHECK_CONTAINS(html, "data-label=\"recordings\">6<");
}

TEST("what cannot be compared still has a page, which says why") {
  const std::string html = to_html(compared({compared_recording("flat", 0.0)}));
  CHECK_CONTAINS(html, "class=\"verdict fail\"");
  CHECK_CONTAINS(html, "Not comparable");
  CHECK_CONTAINS(html, "constant");
}

TEST("what was found wrong is counted in words") {
  CHECK(shown(RecordingDefects{}) == "nothing");
  CHECK(shown(RecordingDefects{.missing = 12, .gaps = 3}) == "12 missing samples, 3 gaps");
}

}  // namespace

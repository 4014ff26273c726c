// SPDX-License-Identifier: MIT
/// Synthetic insertions compared with each other, as the command passes them to its reports.

#include "reports/comparison_report.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "model/problem/recording.hpp"
#include "tests/check.hpp"
#include "tests/validation/comparison/insertion_law.hpp"
#include "validation/claims/clinical_fixture.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using comparison::Feature;
using comparison::QuantityKind;
using comparison::Tolerance;
using Json = nlohmann::json;

/// Recording of the analytic signal at 120 Hz times a factor; the depth increases at 5 mm/s.
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
  trace.columns.push_back({"tool.depth_m", "m", {}});
  trace.columns.push_back({"tool.force_n", "N", {}});
  trace.text_columns = {{"tool.layer", {}}};
  for (const double t : time) {
    trace.columns[1].values.push_back(5e-3 * t);
    trace.columns[2].values.push_back(t < 6.0 ? t : 1.0);
    trace.text_columns[0].values.push_back(t < 6.0 ? "flavum" : "epidural <space>");
  }
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

TEST("a tolerance is a share, a number with its unit, their sum or a factor") {
  using enum QuantityKind;
  struct {
    const char* text;
    QuantityKind quantity;
    double absolute, relative, factor;
  } const rows[] = {
      {"peak=15%", pressure, 0.0, 0.15, 0.0},
      {"plateau=7mmHg", pressure, 7.0 * pascals_per_mmhg, 0.0, 0.0},
      {"slope_before=30%+5mmHg/s", pressure, 5.0 * pascals_per_mmhg, 0.3, 0.0},
      {"drop_time=x2.5", pressure, 0.0, 0.0, 2.5},
      {"relative_drop=0.1", pressure, 0.1, 0.0, 0.0},
      {"depth_of_loss=3mm", force, 3e-3, 0.0, 0.0},
      {"time_of_loss=250ms", force, 0.25, 0.0, 0.0},
  };
  for (const auto& row : rows) {
    const Tolerance read = tolerance_from(row.text, row.quantity);
    CHECK_NEAR(read.absolute, row.absolute, 1e-15 * std::max(1.0, row.absolute));
    CHECK_NEAR(read.relative, row.relative, 1e-15);
    CHECK(read.factor == row.factor);
  }
  CHECK(tolerance_from("peak=15%", pressure).feature == Feature::peak);
}

TEST("a text that is no tolerance is refused with the allowed ones") {
  for (const auto& [text, message] : {
           std::pair{"peak", "must be such as peak=15%"},
           std::pair{"peak=", "must be such as peak=15%"},
           std::pair{"peek=3%", "did you mean peak"},
           std::pair{"loss_of_resistance=1", "found or not, which has no width"},
           std::pair{"peak=7", "must be % or a unit of Pa"},  // mmHg or Pa?
           std::pair{"drop_time=0.5", "must be % or a unit of s"},
           std::pair{"peak=much", "must be such as"},
           std::pair{"peak=-5%", "must be such as"},
           std::pair{"peak=5mm", "must be % or a unit of Pa"},
           std::pair{"plateau=1N", "must be % or a unit of Pa"},
           std::pair{"drop_time=x1", "a factor must be a number > 1"},
           std::pair{"drop_time=xs", "must be such as"},
       }) {
    CHECK_THROWS(tolerance_from(text, QuantityKind::pressure), message);
  }
}

TEST("the defaults that --help shows are those in force") {
  for (const QuantityKind quantity :
       {QuantityKind::pressure, QuantityKind::force, QuantityKind::insertion}) {
    std::istringstream lines(tolerance_help(quantity));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      const Tolerance shown = tolerance_from(line.substr(2), quantity);
      const Tolerance used = comparison::tolerance_of(shown.feature, {.quantity = quantity});
      // Three digits are shown.
      CHECK_NEAR(shown.absolute, used.absolute, 5e-3 * used.absolute + 1e-300);
      CHECK_NEAR(shown.relative, used.relative, 5e-3 * used.relative + 1e-300);
      CHECK(shown.factor == used.factor);
    }
    CHECK(count == features_of(quantity).size() - 1);
  }
}

Json json_of(const ComparisonReport& report) { return Json::parse(to_json(report)); }

void check_keys(const Json& json, const char* keys) {
  std::istringstream words(keys);
  for (std::string key; words >> key;) {
    if (!json.contains(key)) { std::printf("  %s\n", key.c_str()); }
    CHECK(json.contains(key));
  }
}

TEST("comparison.json has the documented keys and the numbers of the comparison, in SI") {
  const ComparisonReport report =
      compared({compared_recording("a", 0.98), compared_recording("b", 1.0),
                compared_recording("c", 1.02, Recording::Kind::measured)});
  const Json json = json_of(report);
  check_keys(json,
             "schema verdict holds sentence reasons quantity unit simulation options recordings "
             "groups credibility command provenance");
  const Json& first = json["recordings"][0];
  check_keys(first,
             "file format fnv1a kind regime name source note group technique subject "
             "bmi_kg_per_m2 plunger_area_m2 sample_rate_hz samples defects warnings verdict "
             "reasons alignment cutoff_hz overlap_s features distances rating unfiltered_rating "
             "rated_share");
  CHECK(first["features"].size() == features_of(QuantityKind::pressure).size());
  CHECK(first["kind"] == "reconstructed");
  CHECK(json["recordings"][2]["kind"] == "measured");
  const comparison::Comparison& one = report.found.recordings[1];
  const Json& peak = json["recordings"][1]["features"][1];
  CHECK(peak["name"] == "peak");
  CHECK(peak["unit"] == "Pa");
  CHECK(peak["recorded"].get<double>() == *one.features[1].recorded.value);
  CHECK(peak["u_val"].get<double>() == one.features[1].uncertainty.total());
  CHECK(json["recordings"][1]["rating"]["overall"].get<double>() == one.rating->overall);
  CHECK(json["recordings"][1]["alignment"]["lag_s"].get<double>() == one.alignment.lag);
  const Json& group = json["groups"][0];
  for (const char* key : {"recordings", "subjects", "subjects_agree"}) { CHECK(group[key] == 3); }
  CHECK(group["measured"] == 1);
  CHECK(group["reconstructed"] == 2);
  CHECK(group["corridor"]["recordings"] == 3);
  CHECK(group["corridor"]["subjects"] == 3);
  // t(0.975, 2) sqrt(4/3), four digits
  CHECK_NEAR(group["corridor"]["half_width_sd"].get<double>(), 4.968, 1e-3);
  CHECK(json["verdict"] == "agrees");
  CHECK(json["holds"] == true);
}

TEST("a recording that cannot be compared has a reason, no numbers and a page with the reason") {
  const ComparisonReport report = compared({compared_recording("flat", 0.0)});
  const Json json = json_of(report);
  const Json& one = json["recordings"][0];
  CHECK(json["verdict"] == "not comparable");
  CHECK(json["holds"] == false);
  CHECK(one["verdict"] == "not comparable");
  CHECK(!one["reasons"].empty());
  CHECK(!one.contains("features"));
  CHECK(json["groups"][0]["corridor"].contains("refused"));
  CHECK(json["groups"][0]["agree_share"] == "nan");
  CHECK(json["groups"][0]["agree_interval_95"].is_null());
  CHECK_CONTAINS(to_html(report), "class=\"verdict fail\"", "Not comparable", "constant");
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

TEST("a report holds only if all recordings could be compared and agree") {
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
  CHECK_NEAR(figures[0].series[1].y[6000], 60.0, 1e-6);  // peak of the analytic signal [mmHg]
  CHECK_NEAR(figures[2].series[0].x.back(), 5.0 * 14.0, 1e-9);  // mm
  // Both were sampled from one law, which is a straight line at 3 s: the filter passes it
  // unchanged.
  CHECK(std::abs(figures[4].series[0].y[360]) < 1e-6);
}

TEST("every figure that shows a reconstructed recording says so, and none of a measured one does") {
  const ComparisonReport report = compared(subjects(3));
  const char* note = "reconstructed from published summary values, not measured";
  for (const Figure& figure : recording_figures(report, 0)) {
    CHECK_CONTAINS(figure.caption, note);
  }
  for (const Figure& figure : group_figures(report, 0)) {
    CHECK_CONTAINS(figure.caption,
                   "3 of 3 recordings: reconstructed from published summary values");
  }
  const ComparisonReport measured =
      compared({compared_recording("patient", 1.0, Recording::Kind::measured)});
  for (const Figure& figure : recording_figures(measured, 0)) {
    CHECK_LACKS(figure.caption, "reconstructed");
  }
  CHECK_LACKS(verdict_sentence(measured), "reconstructed");
}

TEST("the corridor is the mean and its factor of deviations either way") {
  const ComparisonReport report = compared(subjects(3));
  const std::vector<Figure> figures = group_figures(report, 0);
  REQUIRE(figures.size() == 2);
  CHECK(figures[0].series.size() == 3);
  const Series& band = figures[0].series[0];
  const Series& mean = figures[0].series[1];
  // Factors 0.98, 1, 1.02: SD 2 %; t(0.975, 2) sqrt(4/3) = 4.303 x 1.1547 = 4.968.
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

TEST("the page has its order, makes no request, escapes its text and is the same twice") {
  const ComparisonReport report = compared(subjects(4));
  const std::string html = to_html(report);
  CHECK_ORDER(html, "class=\"verdict pass\"", "Key facts", "What was compared",
              "Groups of subjects", "Every recording", "Ratings and distances",
              "What was found wrong", "Tolerances in force", "Credibility factors",
              "To see it again");
  CHECK_LACKS(html, "src=\"http", "href=\"http", "url(http", "@import", "BMI <18>", "compare <x>",
              "epidural <space>");
  CHECK(html == to_html(report));
}

TEST("insertions into a phantom have their figures, their table, and no claim about patients") {
  std::vector<RecordingFile> all;
  for (const double factor : {0.97, 0.98, 0.99, 1.01, 1.02, 1.03}) {
    RecordingFile one{.file = "a.h5", .hash = "0123"};
    one.input.recording = recording_of(InsertionLaw{.dent = 12e-3 * factor,
                                                    .relaxed = 0.4 * factor,
                                                    .relaxation_time = 1.2 * factor,
                                                    .pulled_at = 15e-3 * factor,
                                                    .factor = factor},
                                       std::to_string(factor));
    one.input.recording.group = "skin";
    all.push_back(std::move(one));
  }
  Trace trace = trace_of(InsertionLaw{});
  trace.text_columns = {{"tool.layer", std::vector<std::string>(trace.time.size(), "skin")}};
  ComparisonReport report{.options = {.comparison = {.quantity = QuantityKind::insertion}},
                          .recordings = std::move(all),
                          .simulation = {.trace = std::move(trace)}};
  std::vector<Recording> recordings;
  for (const RecordingFile& one : report.recordings) { recordings.push_back(one.input.recording); }
  report.found = comparison::compare_all(recordings, report.simulation.trace, report.options);
  report.credibility = comparison::credibility({}, &report.found);
  const std::vector<Figure> figures = group_figures(report, 0);
  REQUIRE(figures.size() == 2);
  CHECK(figures[0].x.label == "depth below the contact (mm)");
  CHECK(figures[1].x.label == "time from the contact (s)");
  // Corridor, six recordings, their mean, the simulation; all begin at the contact.
  for (const Figure& figure : figures) {
    REQUIRE(figure.series.size() == 9);
    CHECK(figure.series[0].style == Series::Style::band);
    CHECK(figure.series[1].label == "measured phantom, each");
    CHECK(figure.series[2].label.empty());
    CHECK(figure.series[8].label == "simulated");
    for (const Series& series : figure.series) {
      CHECK(std::ranges::min(series.x) >= 0.0);
      CHECK(std::ranges::min(series.x) <= 0.1);  // a step of the grid of the depth, in mm
    }
  }
  const std::string html = to_html(report);
  CHECK_ORDER(html, "6 recordings of a measured phantom", "A phantom is no evidence about patients",
              "Groups of recordings", "Force over depth", "Force over time", ">puncture force<",
              ">relaxation time<", "Every recording");
  CHECK_CONTAINS(html, "measured phantom: no patient", "two SD", "of a measured phantom are no");
  CHECK_LACKS(html, "6 measured recordings", "thumb");
  const Json json = json_of(report);
  CHECK(json["groups"][0]["measured"] == 0);
  CHECK(json["groups"][0]["measured_phantom"] == 6);
  CHECK(json["groups"][0]["reconstructed"] == 0);
  CHECK(json["options"]["insertion"]["least_drop"] == 0.15);
  CHECK(json["recordings"][0]["kind"] == "measured-phantom");
}

TEST("a verdict says where only the curve differs") {
  Trace trace = compared_trace();
  for (std::size_t n = 0; n < trace.time.size(); ++n) {
    if (trace.time[n] < 3.0 || trace.time[n] > 11.5) {  // where no feature is measured
      trace.columns[0].values[n] = 58.0 * pascals_per_mmhg;
    }
  }
  ComparisonReport report = compared(subjects(1), trace);
  CHECK(!holds(report));
  CHECK(verdict_text(report) == "Features agree, curve does not");
  CHECK_CONTAINS(verdict_sentence(report), ": features agree, curve does not: rated 0.");
  CHECK(json_of(report)["verdict"] == "features agree, curve does not");
  CHECK(json_of(report)["recordings"][0]["verdict"] == "features agree, curve does not");
  CHECK(json_of(report)["groups"][0]["verdict"] == "features agree, curve does not");
}

TEST("a verdict names the parts of a curve's rating that are poor where the features agree") {
  Trace trace = compared_trace();
  CHECK(verdict_sentence(compared(subjects(1), trace)).find("poor") == std::string::npos);
  for (std::size_t n = 0; n < trace.time.size(); ++n) {  // hum while the pressure rises
    if (trace.time[n] > 1.0 && trace.time[n] < 5.0) {
      trace.columns[0].values[n] +=
          3.0 * pascals_per_mmhg * std::sin(2.0 * std::numbers::pi * 6.0 * trace.time[n]);
    }
  }
  const ComparisonReport report = compared(subjects(1), trace);
  const comparison::IsoRating rating = report.found.recordings.front().rating.value();
  CHECK(comparison::grade_of(rating.slope) == "poor");
  CHECK(comparison::grade_of(rating.overall) != "poor");
  CHECK(holds(report));
  CHECK_CONTAINS(verdict_sentence(report), " ISO/TS 18571 rates the whole curve as poor in slope.");
}

TEST("the page counts recordings and their subjects, and the defects of each") {
  CHECK(shown(RecordingDefects{}) == "nothing");
  CHECK(shown(RecordingDefects{.missing = 12, .gaps = 3}) == "12 missing samples, 3 gaps");
  std::vector<RecordingFile> all = subjects(6);
  for (std::size_t n = 0; n < 6; ++n) { all[n].input.recording.subject = std::to_string(n / 2); }
  const std::string html = to_html(compared(all));
  CHECK_CONTAINS(html, "6 recordings reconstructed", "3 subjects (6 recordings)",
                 "data-label=\"subjects\">3<", "data-label=\"recordings\">6<");
}

}  // namespace PALPATE_FILE

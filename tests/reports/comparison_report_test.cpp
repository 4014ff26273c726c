// SPDX-License-Identifier: MIT
#include "reports/comparison_report.hpp"

#include <cmath>

#include "model/dynamics/pressure_units.hpp"
#include "reports/comparison_figures.hpp"
#include "reports/comparison_words.hpp"
#include "tests/check.hpp"
#include "tests/reports/comparison_sample.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

std::vector<ComparedRecording> subjects(std::size_t count) {
  std::vector<ComparedRecording> all;
  for (std::size_t n = 0; n < count; ++n) {
    const double middle = 0.5 * static_cast<double>(count - 1);
    all.push_back(sample::compared_recording("subject-" + std::to_string(n),
                                             1.0 + 0.02 * (static_cast<double>(n) - middle)));
  }
  return all;
}

}  // namespace

TEST("only what agrees and could all be compared holds") {
  CHECK(holds(sample::compared(subjects(1))));
  CHECK(!holds(sample::compared({sample::compared_recording("loud", 1.5)})));
  std::vector<ComparedRecording> with_a_constant = subjects(1);
  with_a_constant.push_back(sample::compared_recording("flat", 0.0));
  const ComparisonReport mixed = sample::compared(with_a_constant);
  CHECK(mixed.found.verdict == comparison::Verdict::agrees && !holds(mixed));
  CHECK(verdict_text(mixed) == "Agrees, but 1 recording cannot be compared");
  CHECK(!holds(sample::compared({})));
}

TEST("the figures of a recording show both over time and depth, with layers, and the residual") {
  const ComparisonReport report = sample::compared(subjects(1));
  const std::vector<Figure> figures = recording_figures(report, 0);
  CHECK(figures.size() == 5);
  for (const Figure& figure : figures) { CHECK(figure.zones.size() == 2 && figure.marks.size() == 1); }
  CHECK(figures[0].id == "pressure-over-time" && figures[2].id == "pressure-over-depth");
  CHECK(figures[0].series[0].label == "recorded" && figures[0].series[1].label == "simulated");
  const double peak_mmhg = 60.0 * pascals_per_mmhg / pascals_per_mmhg;  // of the law
  CHECK_NEAR(figures[0].series[1].y[6000], peak_mmhg, 1e-6);
  CHECK_NEAR(figures[2].series[0].x.back(), 5.0 * 14.0, 1e-9);  // mm
  // Both were sampled from one law, which is a straight line at 3 s: the filter passes it unchanged.
  CHECK(std::abs(figures[4].series[0].y[360]) < 1e-6);
}

TEST("every figure that shows a reconstructed recording says so, and none of a measured one does") {
  const ComparisonReport report = sample::compared(subjects(3));
  for (const Figure& figure : recording_figures(report, 0)) {
    CHECK(contains(figure.caption, "reconstructed from published summary values, not measured"));
  }
  for (const Figure& figure : group_figures(report, 0)) {
    CHECK(contains(figure.caption, "3 of 3 recordings: reconstructed from published summary values"));
  }
  const ComparisonReport measured =
      sample::compared({sample::compared_recording("patient", 1.0, Recording::Kind::measured)});
  for (const Figure& figure : recording_figures(measured, 0)) {
    CHECK(!contains(figure.caption, "reconstructed"));
  }
  CHECK(!contains(verdict_sentence(measured), "reconstructed"));
}

TEST("the corridor is the mean and its factor of deviations either way") {
  const ComparisonReport report = sample::compared(subjects(3));
  const std::vector<Figure> figures = group_figures(report, 0);
  CHECK(figures.size() == 2 && figures[0].series.size() == 3);
  const Series& band = figures[0].series[0];
  const Series& mean = figures[0].series[1];
  // Three subjects with factors 0.98, 1, 1.02: SD 2 %; t(0.975, 2) sqrt(4/3) = 4.303 x 1.1547 = 4.968.
  const std::size_t early = 60;  // before the rise, 20 mmHg
  CHECK_NEAR(band.y2[early] - mean.y[early], 4.968 * 0.02 * mean.y[early], 1e-3 * mean.y[early]);
  CHECK(group_figures(sample::compared(subjects(2)), 0).empty());
}

TEST("a recording without depth, and a trace without it, have no figures over depth") {
  std::vector<ComparedRecording> one = subjects(1);
  one[0].input.recording.depth.clear();
  CHECK(recording_figures(sample::compared(one), 0).size() == 3);
  Trace trace = sample::compared_trace();
  std::erase_if(trace.columns, [](const Column& column) { return column.name == "tool.depth_m"; });
  trace.events.clear();
  CHECK(recording_figures(sample::compared(subjects(1), trace), 0).size() == 3);
}

TEST("the page answers in order, makes no request, escapes what it shows and gives the same bytes twice") {
  const ComparisonReport report = sample::compared(subjects(4));
  const std::string html = to_html(report);
  std::size_t last = 0;
  for (const char* heading :
       {"class=\"verdict pass\"", "Key facts", "What was compared", "Groups of subjects", "Every recording",
        "Ratings and distances", "What was found wrong", "Tolerances in force", "Credibility factors",
        "To see it again"}) {
    const std::size_t at = html.find(heading);
    CHECK(at != std::string::npos && at > last);
    last = at;
  }
  for (const char* request :
       {"src=\"http", "href=\"http", "url(http", "@import", "BMI <18>", "compare <x>", "epidural <space>"}) {
    CHECK(!contains(html, request));
  }
  CHECK(html == to_html(report));
}

TEST("the page tells recordings from subjects") {
  std::vector<ComparedRecording> all = subjects(6);
  for (std::size_t n = 0; n < 6; ++n) { all[n].input.recording.subject = std::to_string(n / 2); }
  const std::string html = to_html(sample::compared(all));
  CHECK(contains(html, "6 recordings reconstructed"));
  CHECK(contains(html, "3 subjects (6 recordings)"));
  CHECK(contains(html, "data-label=\"subjects\">3<") && contains(html, "data-label=\"recordings\">6<"));
}

TEST("what cannot be compared still has a page, which says why") {
  const std::string html = to_html(sample::compared({sample::compared_recording("flat", 0.0)}));
  CHECK(contains(html, "class=\"verdict fail\"") && contains(html, "Not comparable"));
  CHECK(contains(html, "constant"));
}

TEST("what was found wrong is counted in words") {
  CHECK(shown(RecordingDefects{}) == "nothing");
  CHECK(shown(RecordingDefects{.missing = 12, .gaps = 3}) == "12 missing samples, 3 gaps");
}

// SPDX-License-Identifier: MIT

#include "reports/results/baseline_file.hpp"

#include "reports/gate_report.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "tests/reports/sample_results.hpp"

namespace {

using namespace palpate;

gate::Baseline sample_baseline() {
  gate::Acceptance acceptance{.command = "palpate validate",
                              .provenance = {{"commit", "abc"}},
                              .date = "2026-01-01T00:00:00Z",
                              .reason = "first",
                              .outcomes = {sample::results().outcomes.front()}};
  acceptance.variants = {acceptance.outcomes};
  return gate::accept({}, acceptance);
}

TEST("a baseline is read as it was written, curves and all, and has the same bytes twice") {
  const scratch::Folder folder;
  const gate::Baseline written = sample_baseline();
  write_baseline(folder / "b.json", written);
  write_baseline(folder / "c.json", written);
  const gate::Baseline read = read_baseline(folder / "b.json");
  const gate::Candidate candidate{.command = written.command,
                                  .outcomes = {written.cases[0].outcome}};
  CHECK(gate::compare(read, candidate).counts().identical == 1);
  REQUIRE(read.ledger.size() == 1);
  CHECK(read.ledger[0].reason == "first");
  CHECK(read.ledger[0].commit == "abc");
  CHECK(read.cases[0].spread.runs == 1);
  for (const std::string ending : {".h5", ".json"}) {
    CHECK(io::read_bytes(folder / ("b" + ending), 1U << 24U) ==
          io::read_bytes(folder / ("c" + ending), 1U << 24U));
  }
  CHECK_THROWS(write_baseline(folder / "d.h5", written), "another ending");
}

TEST("every damage to the files of a baseline is refused") {
  const auto tried = try_damaged_files();
  CHECK(tried.size() >= 15);
  for (const auto& [damage, refusal] : tried) {
    if (refusal.empty()) { std::printf("  %s: taken for sound\n", damage.c_str()); }
    CHECK(!refusal.empty());
  }
}

TEST("page, table and JUnit name what regressed") {
  GateReport report{.command = "palpate gate", .baseline = sample_baseline()};
  report.candidate = {.command = "palpate validate",
                      .outcomes = {report.baseline.cases[0].outcome}};
  Figure& figure = report.candidate.outcomes[0].figures[0];
  figure.series[0].y[2] *= 10.0;
  report.result = gate::compare(report.baseline, report.candidate);
  CHECK(verdict_text(report.result) == "FAIL: 1 of 1 cases regressed");
  CHECK_CONTAINS(changes_text(report.result), figure.id);
  CHECK_CONTAINS(to_junit(report), "<failure");
  CHECK_CONTAINS(to_json(report), "\"verdict\": \"fail\"");
  const std::string page = to_html(report);
  CHECK_CONTAINS(page, "Curves that moved", "<svg");
}

}  // namespace

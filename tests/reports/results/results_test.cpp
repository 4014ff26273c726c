// SPDX-License-Identifier: MIT

#include "reports/results/results.hpp"

#include <cstdlib>
#include <functional>

#include "reports/gate_report.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "tests/reports/sample_results.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("only a quantity that is a number passes, and only a case that judged one") {
  CHECK(!sample::bounded("x", std::nan(""), "1", -1e300, 1e300).holds());
  CHECK(!sample::bounded("x", 1.0, "1", std::nan(""), 2.0).holds());
  for (const double bound : {0.0, unbounded}) {
    Outcome outcome;
    outcome.judge(sample::bounded("x", std::nan(""), "1", -bound, bound));
    conclude(outcome);
    CHECK(outcome.status == Status::fail);
  }
  Outcome empty;
  empty.judge({.name = "only for information", .value = 1.0});
  conclude(empty);
  CHECK(empty.status == Status::fail);
  Outcome skipped;
  skipped.skip("absent");
  conclude(skipped);
  CHECK(skipped.status == Status::skip);
  CHECK(skipped.reason() == "absent");
}

TEST("an uncertainty that contains a bound makes a quantity and its case inconclusive") {
  Outcome outcome{.name = "case", .suite = "accuracy"};
  outcome.judge({.name = "a", .value = 0.5, .upper = 1.0, .bound_from = "theory"});
  outcome.judge(
      {.name = "b", .value = 0.95, .upper = 1.0, .bound_from = "theory", .uncertainty = 0.1});
  conclude(outcome);
  CHECK(outcome.status == Status::inconclusive);
  CHECK(!tally({outcome}).holds());
  const Results read = results_from_json(to_json(Results{.outcomes = {outcome}}), "results.json");
  CHECK(read.outcomes.at(0).status == Status::inconclusive);
  CHECK(read.outcomes.at(0).quantities.at(1).uncertainty == 0.1);
  CHECK_CONTAINS(to_junit(read), "<failure type=\"inconclusive\"");
  outcome.quantities[1].uncertainty = std::nan("");
  CHECK(outcome.quantities[1].status() == Status::fail);
}

TEST("results hold only if a case passed and none failed") {
  CHECK(!tally({}).holds());
  CHECK(!tally({Outcome{.status = Status::skip}}).holds());
  CHECK(!tally({Outcome{.status = Status::pass}, Outcome{.status = Status::error}}).holds());
  CHECK(tally({Outcome{.status = Status::pass}, Outcome{.status = Status::skip}}).holds());
}

TEST("results.json is read back and written again with the same bytes, zones and marks included") {
  const std::string json = to_json(sample::results());
  CHECK(to_json(sample::results()) == json);
  const Results again = results_from_json(json, "results.json");
  CHECK(to_json(again) == json);
  const Figure& figure = again.outcomes[0].figures[2];
  REQUIRE(figure.zones.size() == 3);
  CHECK(figure.zones[1].label == "ligamentum flavum");
  CHECK(figure.zones[1].begin == 2.0);
  CHECK(figure.zones[1].end == 9.0);
  REQUIRE(figure.marks.size() == 3);
  CHECK(figure.marks[2].label == "puncture & more");
  CHECK(figure.marks[2].x == 9.0);
  CHECK(figure.series[0].style == Series::Style::area);
  CHECK(again.outcomes[0].figures[0].zones.empty());
  CHECK(again.outcomes[0].figures[0].marks.empty());
}

TEST("traces of another length than their figure needs are refused by name") {
  for (const bool area : {false, true}) {
    const scratch::Folder folder;
    Outcome outcome = sample::results().outcomes[0];
    if (area) { outcome.figures[2].series[1].y2.clear(); }
    if (!area) { outcome.figures[0].series[0].y.pop_back(); }
    write_figure_data(folder.path(), outcome);
    CHECK_THROWS(read_figure_data(folder.path(), outcome), area ? "series_1" : "series_0");
  }
}

TEST("a results folder renders the same report from its files alone, also with bytes of no UTF-8") {
  for (const char* note : {"plain", "caf\xe9"}) {
    const scratch::Folder folder;
    Results results = sample::results();
    results.outcomes[0].notes = {note};
    write_results_folder(folder.path(), results);
    const Results again = read_results_folder(folder.path());
    CHECK(to_html(again) == to_html(results));
    CHECK(to_json(again) == to_json(results));
    CHECK(to_html(again) == io::read_text(folder.path() / "report.html", 1U << 24U));
    CHECK(to_json(again) == io::read_text(folder.path() / "results.json", 1U << 24U));
  }
}

TEST("a results.json that is cut, of another schema or without its traces is refused") {
  const scratch::Folder folder;
  write_results_folder(folder.path(), sample::results());
  const std::string json = to_json(sample::results());
  CHECK_THROWS(results_from_json(json.substr(0, json.size() / 2), "results.json"), "results.json");
  struct {
    std::string_view found, changed, reason;
  } const rows[] = {{"\"schema\": 1", "\"schema\": 7", "schema 7"},
                    {"\"value\": 4.01", "\"value\": \"nan\"", "by its value and bounds \"fail\""},
                    {"\"claim\"", "\"clam\"", "claim"}};
  for (const auto& [found, changed, reason] : rows) {
    std::string other = json;
    other.replace(other.find(found), found.size(), changed);
    CHECK_THROWS(results_from_json(other, "results.json"), reason);
  }
  CHECK_THROWS(results_from_json("{\"schema\": 1, \"cases\": []}", "results.json"),
               "it lacks title, command, provenance");
  CHECK_THROWS(results_from_json("{\"schema\": 1, \"title\": \"\", \"command\": \"\", "
                                 "\"provenance\": {}, \"cases\": [{\"name\": \"a\", "
                                 "\"quantities\": [{\"name\": \"b\", \"value\": 1}]}]}",
                                 "results.json"),
               "cases[0] lacks suite, claim, status, skipped, message, seconds, tables, figures, "
               "notes, timings; cases[0].quantities[0] lacks unit, lower, upper, bound_from");
  std::filesystem::remove_all(folder.path() / "traces");
  CHECK_THROWS(read_results_folder(folder.path()), "oscillator-order-rk4.h5");
  CHECK_THROWS(read_results_folder(folder.path() / "absent"), "absent");
}

TEST("a status against the numbers of its quantity or case is refused") {
  const Results results{.outcomes = {{.name = "a/b",
                                      .status = Status::pass,
                                      .quantities = {{.name = "q", .value = 1.0, .upper = 2.0}}}}};
  const std::string json = to_json(results);
  const auto with = [&](const std::string& before, const std::string& after) {
    const std::size_t at = json.rfind(before);
    REQUIRE(at != json.npos);
    return std::string(json).replace(at, before.size(), after);
  };
  CHECK_THROWS(results_from_json(with("\"status\": \"pass\"", "\"status\": \"fail\""), "r.json"),
               "quantity q has the status \"fail\", and by its value and bounds \"pass\"");
  CHECK_THROWS(results_from_json(with("\"skipped\": null", "\"skipped\": \"why\""), "r.json"),
               "case a/b has the status \"pass\", and a reason why it was skipped");
  CHECK_THROWS(
      results_from_json(with("\"upper\": 2.0,", "\"upper\": 0.5, \"uncertainty\": -1,"), "r.json"),
      "quantity q has an uncertainty that is no number >= 0");
}

TEST("what varies between runs is left out and nothing else") {
  Results a = sample::results();
  Results b = a;
  b.provenance["date"] = "tomorrow";
  b.outcomes[0].seconds = 7.0;
  b.outcomes[0].timings[0].value = 9.0;
  CHECK(to_json(a) != to_json(b));
  CHECK(to_json(without_what_varies(a)) == to_json(without_what_varies(b)));
  b.outcomes[0].quantities[0].value += 1e-15;
  CHECK(to_json(without_what_varies(a)) != to_json(without_what_varies(b)));
}

bool well_formed(const std::string& xml) {
  const scratch::Folder folder;
  const std::string file = folder.file("results.xml", xml).string();
  return std::system(("xmllint --noout '" + file + "'").c_str()) == 0;
}

TEST("JUnit is well formed, counts every case once and has quantities with their bounds") {
  const std::string xml = to_junit(sample::results());
  CHECK(well_formed(xml));
  CHECK_CONTAINS(
      xml, "tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"1\"",
      "<testsuite name=\"stability\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\"",
      "<property name=\"observed_order\" value=\"4.01\"/>",
      "<property name=\"observed_order.upper\" value=\"4.15\"/>");
  CHECK_LACKS(xml, "rungs.upper");
  CHECK_CONTAINS(xml, "message=\"modulus = nan Pa; allowed 1 to 2 (theory)\"",
                 "<skipped message=\"the folder lumbar_network is absent\"/>");
  Results hostile = sample::results();
  hostile.outcomes[3].reasons = {"]]> <a b='\"'> & \x01 \xff end"};
  hostile.outcomes[1].claim = "</failure><x>";
  CHECK(well_formed(to_junit(hostile)));
}

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
  const auto bytes = [](const std::filesystem::path& file) {
    return io::read_bytes(file, 1U << 24U);
  };
  CHECK(bytes(folder / "b.json") == bytes(folder / "c.json"));
  CHECK(bytes(read.curves) == bytes(read_baseline(folder / "c.json").curves));
  CHECK(read.curves.filename().string().size() == std::string("b.0123456789ab.h5").size());
  CHECK_THROWS(write_baseline(folder / "d.h5", written), "another ending");
}

TEST("a new baseline replaces its own curves only, and one that cannot be written leaves the old") {
  namespace fs = std::filesystem;
  const scratch::Folder folder;
  io::replace_file(folder / "b.h5", "of somebody else");
  write_baseline(folder / "b.json", sample_baseline());
  gate::Baseline changed = read_baseline(folder / "b.json");
  const fs::path first = changed.curves;
  changed.cases[0].outcome.figures[0].series[0].y[0] += 1.0;
  write_baseline(folder / "b.json", changed);
  CHECK(!fs::exists(first));
  const fs::path second = read_baseline(folder / "b.json").curves;
  CHECK(fs::exists(second));
  CHECK(io::read_bytes(folder / "b.h5", 100) == "of somebody else");
  // A folder in place of the file: the rename at the end fails.
  fs::create_directory(folder / "c.json");
  CHECK_THROWS(write_baseline(folder / "c.json", changed), "c.json");
  CHECK(fs::exists(second));
  CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{}) == 4);
}

TEST("a baseline of the older version is refused although its seal fits") {
  const scratch::Folder folder;
  write_baseline(folder / "b.json", sample_baseline());
  const std::string bytes = io::read_bytes(read_baseline(folder / "b.json").curves, 1U << 24U);
  io::replace_file(folder / "old.h5", bytes);
  auto json = nlohmann::ordered_json::parse(io::read_text(folder / "b.json", 1U << 24U));
  json["schema"] = 1;
  json["curves"] = io::content_hash(bytes);
  json.erase("seal");
  json["seal"] = io::content_hash(json_text(json));
  io::replace_file(folder / "old.json", json_text(json));
  CHECK_THROWS(read_baseline(folder / "old.json"), "schema 1");
  CHECK_THROWS(read_baseline(folder / "old.json"), "approve the results again");
}

TEST("a baseline whose parts contradict each other is refused although its seal fits") {
  const scratch::Folder folder;
  write_baseline(folder / "b.json", sample_baseline());
  const std::string text = io::read_text(folder / "b.json", 1U << 24U);
  const auto changed = [&](const std::function<void(nlohmann::ordered_json&)>& change) {
    auto json = nlohmann::ordered_json::parse(text);
    change(json);
    json.erase("seal");
    json["seal"] = io::sha256(json_text(json));
    io::replace_file(folder / "b.json", json_text(json));
    return read_baseline(folder / "b.json").cases.size();
  };
  using Json = nlohmann::ordered_json;
  CHECK(changed([](Json&) {}) == 1);
  CHECK_THROWS(changed([](Json& j) { j["ledger"] = Json::array(); }), "has no approval");
  CHECK_THROWS(changed([](Json& j) { j["ledger"][0]["cases"] = {"other"}; }),
               "which no approval names");
  CHECK_THROWS(changed([](Json& j) { j["ledger"][0]["cases"].push_back("no/such"); }),
               "lacks the case no/such");
  CHECK_THROWS(changed([](Json& j) { j["ledger"][0]["reason"] = " "; }), "without a reason");
  for (const char* date : {"yesterday", "2026-01-01", "2026-13-01T00:00:00Z",
                           "2026-01-01T00:00:00Z or later", "2026-1-1T00:00:00Z"}) {
    check::row = date;
    CHECK_THROWS(changed([&](Json& j) { j["ledger"][0]["date"] = date; }), "which is no date as");
  }
  CHECK_THROWS(changed([](Json& j) { j["provenance"]["commit"] = "zzz"; }),
               "has the commit zzz, which no approval has");
  CHECK_THROWS(changed([](Json& j) {
                 Json& all = j["cases"][0]["quantities"];
                 all.push_back(all[0]);
               }),
               "twice");
  CHECK_THROWS(changed([](Json& j) {
                 Json& all = j["cases"][0]["figures"];
                 all.push_back(all[0]);
               }),
               "twice");
  CHECK_THROWS(changed([](Json& j) {
                 j["cases"][0]["status"] = "skip";
                 j["cases"][0]["skipped"] = "because";
               }),
               "was skipped");
  CHECK_THROWS(changed([](Json& j) { j["cases"][0]["spread"]["runs"] = -5; }), "-5 runs");
}

TEST(
    "baselines with other endings have curves of their own, and those of a version before are "
    "read") {
  namespace fs = std::filesystem;
  const scratch::Folder folder;
  const gate::Baseline written = sample_baseline();
  write_baseline(folder / "needle-0.5mm", written);
  write_baseline(folder / "needle-0.6mm", written);
  gate::Baseline changed = read_baseline(folder / "needle-0.5mm");
  changed.cases[0].outcome.figures[0].series[0].y[0] += 1.0;
  write_baseline(folder / "needle-0.5mm", changed);
  CHECK(read_baseline(folder / "needle-0.6mm").cases.size() == 1);
  const fs::path now = read_baseline(folder / "needle-0.6mm").curves;
  const std::string name = now.filename().string();
  const fs::path before = folder / ("needle-0" + name.substr(std::string("needle-0.6mm").size()));
  fs::rename(now, before);
  const gate::Baseline old = read_baseline(folder / "needle-0.6mm");
  CHECK(old.curves == before);
  write_baseline(folder / "needle-0.6mm", old);
  CHECK(fs::exists(before));  // may be of needle-0.7mm too
  CHECK(read_baseline(folder / "needle-0.6mm").curves == now);
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

}  // namespace PALPATE_FILE

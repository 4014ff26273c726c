// SPDX-License-Identifier: MIT

#include "reports/results/results.hpp"

#include <cstdlib>
#include <filesystem>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "tests/reports/sample_results.hpp"

namespace {

using namespace palpate;

TEST("a quantity that is not a number never passes, whatever its bounds") {
  for (const double bound : {0.0, unbounded}) {
    Outcome outcome;
    outcome.judge({.name = "x",
                   .value = std::nan(""),
                   .lower = -bound,
                   .upper = bound,
                   .bound_from = "theory"});
    conclude(outcome);
    CHECK(outcome.status == Status::fail);
  }
}

TEST("a case that judged nothing fails, and a skipped one keeps its reason") {
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

TEST("results hold only when something passed and nothing fell short") {
  CHECK(!tally({}).holds());
  CHECK(!tally({Outcome{.status = Status::skip}}).holds());
  CHECK(!tally({Outcome{.status = Status::pass}, Outcome{.status = Status::error}}).holds());
  CHECK(tally({Outcome{.status = Status::pass}, Outcome{.status = Status::skip}}).holds());
}

TEST("results.json read back and written again has the same bytes") {
  const std::string json = to_json(sample::results());
  CHECK(to_json(results_from_json(json, "results.json")) == json);
  CHECK(to_json(sample::results()) == json);
}

TEST("zones, marks and areas come back from results.json, and files without them are read") {
  const Results again = results_from_json(to_json(sample::results()), "results.json");
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

TEST("an area without its upper edge is refused by name") {
  const scratch::Folder folder;
  Results results = sample::results();
  results.outcomes[0].figures[2].series[1].y2.clear();
  for (Outcome& outcome : results.outcomes) { write_figure_data(folder.path(), outcome); }
  CHECK_THROWS(read_figure_data(folder.path(), results.outcomes[0]), "series_1");
}

TEST("a results folder renders the same report from its files alone") {
  const scratch::Folder folder;
  const Results results = sample::results();
  write_results_folder(folder.path(), results);
  const Results again = read_results_folder(folder.path());
  CHECK(to_html(again) == io::read_text(folder.path() / "report.html", 1U << 24U));
  CHECK(to_json(again) == io::read_text(folder.path() / "results.json", 1U << 24U));
}

TEST(
    "a results.json that is truncated, of another schema or without its traces is refused by "
    "name") {
  const scratch::Folder folder;
  write_results_folder(folder.path(), sample::results());
  const std::string json = to_json(sample::results());
  CHECK_THROWS(results_from_json(json.substr(0, json.size() / 2), "results.json"), "results.json");
  std::string other = json;
  other.replace(other.find("\"schema\": 1"), 11, "\"schema\": 7");
  CHECK_THROWS(results_from_json(other, "results.json"), "schema 7");
  std::string boast = json;
  boast.replace(boast.find("\"value\": 4.01"), 13, "\"value\": \"nan\"");
  CHECK_THROWS(results_from_json(boast, "results.json"), "says pass");
  std::string bare = json;
  bare.replace(bare.find("\"claim\""), 7, "\"clam\"");
  CHECK_THROWS(results_from_json(bare, "results.json"), "claim");
  std::filesystem::remove_all(folder.path() / "traces");
  CHECK_THROWS(read_results_folder(folder.path()), "oscillator-order-rk4.h5");
  CHECK_THROWS(read_results_folder(folder.path() / "absent"), "absent");
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

TEST("traces of another length than their figure needs are refused by name") {
  const scratch::Folder folder;
  Results results = sample::results();
  results.outcomes[0].figures[0].series[0].y.pop_back();
  for (Outcome& outcome : results.outcomes) { write_figure_data(folder.path(), outcome); }
  CHECK_THROWS(read_figure_data(folder.path(), results.outcomes[0]), "series_0");
}

TEST("text that is no UTF-8 does not stop a report, and comes back the same") {
  const scratch::Folder folder;
  Results results = sample::results();
  results.outcomes[0].notes = {"caf\xe9"};
  write_results_folder(folder.path(), results);
  const Results again = read_results_folder(folder.path());
  CHECK(to_html(again) == to_html(results));
  CHECK(to_json(again) == to_json(results));
}

bool well_formed(const std::string& xml) {
  const scratch::Folder folder;
  io::replace_file(folder.path() / "results.xml", xml);
  const std::string command = "xmllint --noout '" + (folder.path() / "results.xml").string() + "'";
  return std::system(command.c_str()) == 0;
}

TEST("JUnit is well formed and counts every case once") {
  const std::string xml = to_junit(sample::results());
  CHECK(well_formed(xml));
  CHECK_CONTAINS(xml, "tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"1\"");
  CHECK_CONTAINS(
      xml, "<testsuite name=\"stability\" tests=\"1\" failures=\"0\" errors=\"1\" skipped=\"0\"");
}

TEST("every quantity is a property with its bounds, and a fallen one is the message") {
  const std::string xml = to_junit(sample::results());
  CHECK_CONTAINS(xml, "<property name=\"observed_order\" value=\"4.01\"/>");
  CHECK_CONTAINS(xml, "<property name=\"observed_order.upper\" value=\"4.15\"/>");
  CHECK(!check::contains(xml, "rungs.upper"));
  CHECK_CONTAINS(xml, "message=\"modulus = nan Pa; allowed 1 to 2 (theory)\"");
  CHECK_CONTAINS(xml, "<skipped message=\"the folder lumbar_network is absent\"/>");
}

TEST("hostile text stays text") {
  Results results = sample::results();
  results.outcomes[3].reasons = {"]]> <a b='\"'> & \x01 \xff end"};
  results.outcomes[1].claim = "</failure><x>";
  CHECK(well_formed(to_junit(results)));
}

}  // namespace

// SPDX-License-Identifier: MIT

#include "fixtures/io/file_bytes.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/history.hpp"
#include "reports/timing/paired_runs.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::timing;
using namespace palpate;

/// Output in the format of callgrind 3.19.
std::string part(int number, const std::string& trigger, const std::string& totals,
                 int thread = 1) {
  return "# callgrind format\nversion: 1\ncreator: callgrind-3.19.0\npid: 9\ncmd:  palpate steps "
         "x\npart: " +
         std::to_string(number) + "\nthread: " + std::to_string(thread) +
         "\n\n\ndesc: Timerange: Basic block 0 - 2005\ndesc: Trigger: " + trigger +
         "\n\npositions: line\nevents: Ir\nsummary: 11025\n\n\n0 11010\n" + totals;
}

TEST("a part has its number, the label that the program gave, and its instructions") {
  const CallgrindPart read =
      part_from(part(3, "Client Request: springs-damped-double", "\ntotals: 11025\n"), "part.3");
  CHECK(read.number == 3);
  CHECK(read.label == "springs-damped-double");
  CHECK(read.instructions == 11025);
  CHECK(read.creator == "callgrind-3.19.0");
}

TEST("a file that is cut short, or counts something else, or holds no number is refused by name") {
  const std::string whole = part(1, "Client Request: x", "\ntotals: 11025\n");
  CHECK_THROWS_AS(InputError, part_from(whole.substr(0, whole.size() - 15), "part.1"),
                  "part.1: ends without totals");
  std::string other = whole;
  other.replace(other.find("events: Ir"), 10, "events: Dr");
  CHECK_THROWS_AS(InputError, part_from(other, "part.1"), "part.1: counts Dr");
  CHECK_THROWS_AS(InputError, part_from(part(1, "x", "\ntotals: 1e9\n"), "part.1"),
                  "\"1e9\" where a count should be");
}

TEST("only parts of the main thread that the program requested are read, in its order") {
  const io::ScratchFolder folder;
  io::replace_file(folder.path() / "part.10", part(10, "Client Request: b", "\ntotals: 2\n"));
  io::replace_file(folder.path() / "part.2-01", part(2, "Client Request: a", "\ntotals: 1\n"));
  io::replace_file(folder.path() / "part.2-02",
                   part(2, "Client Request: a", "\ntotals: 1779\n", 2));
  io::replace_file(folder.path() / "part", part(11, "Program termination", "\ntotals: 9\n"));
  const std::vector<CallgrindPart> parts = labelled_parts(folder.path());
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].label == "a");
  CHECK(parts[1].label == "b");
  CHECK(parts[1].instructions == 2);
}

TEST("a child gives its output, errors and status, or its signal, and ends at once if stopped") {
  const ChildEnd end = run_child(
      {"/bin/sh", "-c",
       "echo out; echo '==1== x' >&2; echo 'palpate: why' >&2; echo '==1== y' >&2; exit 3"},
      nullptr);
  CHECK(end.status == 3);
  CHECK(!end.stopped);
  CHECK(end.output == "out\n");
  CHECK(end.last_words() == "why");
  const std::atomic<bool> stop{true};
  CHECK(run_child({"/bin/sleep", "60"}, &stop).stopped);
  CHECK(run_child({"/bin/sh", "-c", "kill -TERM $$"}, nullptr).status == 128 + 15);
  CHECK(find_program("sh").filename() == "sh");
  CHECK(find_program("no-such-program-anywhere").empty());
  CHECK(run_child({"/no/such/program"}, nullptr).status == 127);
}

HistoryLine run_of(double instructions, const std::string& compiler = "g++ 12") {
  return {.date = "2026-01-01T00:00:00Z",
          .commit = "abc",
          .compiler = compiler,
          .quantities = {{"cube: per_tick", {instructions, "instructions"}},
                         {"cube: ratio", {1.5, "1"}}}};
}

std::vector<HistoryLine> creeping(double growth) {
  std::vector<HistoryLine> history;
  for (int n = 0; n < 40; ++n) { history.push_back(run_of(1e6 * std::pow(growth, n))); }
  return history;
}

TEST("lines are appended and read back to the last digit; damaged or unwritable ones are named") {
  const io::ScratchFolder folder;
  const auto file = folder.path() / "history.jsonl";
  CHECK(read_history(file).empty());
  append_line(file, to_text(run_of(1.0 / 3.0)));
  append_line(file, to_text(run_of(2.0)));
  const std::vector<HistoryLine> history = read_history(file);
  REQUIRE(history.size() == 2);
  CHECK(history[0].commit == "abc");
  CHECK(history[0].quantities.size() == 2);
  CHECK_NEAR(history[0].quantities.at("cube: per_tick").value, 1.0 / 3.0, 0.0);
  CHECK(history[1].quantities.at("cube: per_tick").unit == "instructions");
  io::replace_file(file, to_text(run_of(1.0)) + to_text(run_of(1.0)).substr(0, 40) + "\n");
  CHECK_THROWS_AS(InputError, read_history(file), "history.jsonl:2: ");
  CHECK_THROWS_AS(InputError, append_line(folder.path() / "no" / "folder", to_text(run_of(1.0))),
                  "cannot be written");
}

TEST("only finite results are kept in the history") {
  Results results{.provenance = {{"commit", "abc"}, {"compiler", "g++"}, {"date", "now"}}};
  Outcome& outcome = results.outcomes.emplace_back(Outcome{.name = "bench/x"});
  outcome.judge({.name = "a", .value = 2.0, .unit = "instructions"});
  outcome.judge({.name = "b", .value = std::nan("")});
  const HistoryLine line = history_line_of(results);
  CHECK(line.quantities.size() == 1);
  CHECK(line.quantities.contains("bench/x: a"));
  CHECK(line.commit == "abc");
}

TEST("slow creep fails, steady runs and another compiler do not") {
  CHECK(history_outcome(creeping(1.001)).status == Status::fail);
  CHECK(history_outcome(creeping(1.0)).status == Status::pass);
  CHECK(history_outcome({run_of(1.0)}).status == Status::pass);
  CHECK(history_outcome(creeping(1.001)).figures.size() == 1);
  // Another compiler begins another series, and what is not counted none.
  std::vector<HistoryLine> history = creeping(1.0);
  for (int n = 0; n < 20; ++n) { history.push_back(run_of(2e6, "g++ 13")); }
  const std::vector<Trend> trends = trends_of(history);
  REQUIRE(trends.size() == 1);
  CHECK(trends.front().values.size() == 20);
  CHECK(history_outcome(history).status == Status::pass);
}

TEST("pairs come back from their text to the last bit, and half a text is refused") {
  const PairedReport report{
      .start = {.pairs = {{1e-3 / 3.0, 2e-3, 1e-3, 2e-3}, {0.1, 0.2, 0.3, 0.4}},
                .batch_deadline = 0.02},
      .same_motion = true};
  const PairedReport read = paired_report_from(to_text(report));
  CHECK(read.same_motion);
  REQUIRE(read.start.pairs.size() == 2);
  CHECK_NEAR(read.start.pairs[0].base, 1e-3 / 3.0, 0.0);
  CHECK_NEAR(read.start.pairs[1].head_wall, 0.4, 0.0);
  CHECK_NEAR(read.start.batch_deadline, 0.02, 0.0);
  for (const std::string& text : {to_text(report).substr(0, to_text(report).size() - 5),
                                  std::string("same\n0.1 -3\n"), std::string()}) {
    CHECK_THROWS_AS(InputError, paired_report_from(text), "");
  }
}

}  // namespace PALPATE_FILE

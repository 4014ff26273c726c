// SPDX-License-Identifier: MIT
#include "reports/timing/history.hpp"

#include <cmath>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scratch_folder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/paired_steps.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::timing;

HistoryLine run_of(double instructions, const std::string& compiler = "g++ 12") {
  return {.date = "2026-01-01T00:00:00Z",
          .commit = "abc",
          .compiler = compiler,
          .quantities = {{"cube: per_tick", {instructions, "instructions"}}, {"cube: ratio", {1.5, "1"}}}};
}

std::vector<HistoryLine> creeping(double growth) {
  std::vector<HistoryLine> history;
  for (int n = 0; n < 40; ++n) { history.push_back(run_of(1e6 * std::pow(growth, n))); }
  return history;
}

TEST("lines are appended, and read back to the last digit") {
  const io::ScratchFolder folder;
  const auto file = folder.path() / "history.jsonl";
  CHECK(read_history(file).empty());
  append_history(file, run_of(1.0 / 3.0));
  append_history(file, run_of(2.0));
  const std::vector<HistoryLine> history = read_history(file);
  CHECK(history.size() == 2 && history[0].commit == "abc" && history[0].quantities.size() == 2);
  CHECK_NEAR(history[0].quantities.at("cube: per_tick").value, 1.0 / 3.0, 0.0);
  CHECK(history[1].quantities.at("cube: per_tick").unit == "instructions");
}

TEST("a damaged line is named, and a file that cannot be written is refused") {
  const io::ScratchFolder folder;
  const auto file = folder.path() / "history.jsonl";
  io::replace_file(file, to_text(run_of(1.0)) + to_text(run_of(1.0)).substr(0, 40) + "\n");
  const auto said = [](auto&& work) -> std::string {
    try {
      work();
    } catch (const InputError& error) { return error.what(); }
    return "";
  };
  CHECK(said([&] { read_history(file); }).find("history.jsonl:2: ") != std::string::npos);
  CHECK(said([&] { append_history(folder.path() / "no" / "folder", run_of(1.0)); }).find("cannot be written") !=
        std::string::npos);
}

TEST("of results only what is finite is kept") {
  Results results{.provenance = {{"commit", "abc"}, {"compiler", "g++"}, {"date", "now"}}};
  Outcome& outcome = results.outcomes.emplace_back(Outcome{.name = "bench/x"});
  outcome.judge({.name = "a", .value = 2.0, .unit = "instructions"});
  outcome.judge({.name = "b", .value = std::nan("")});
  const HistoryLine line = history_line_of(results);
  CHECK(line.quantities.size() == 1 && line.quantities.contains("bench/x: a") && line.commit == "abc");
}

TEST("slow creep falls, steady runs do not") {
  CHECK(history_outcome(creeping(1.001)).status == Status::fail);
  CHECK(history_outcome(creeping(1.0)).status == Status::pass);
  CHECK(history_outcome({run_of(1.0)}).status == Status::pass);
  CHECK(history_outcome(creeping(1.001)).figures.size() == 1);
}

TEST("another compiler begins another series, and what is not counted none") {
  std::vector<HistoryLine> history = creeping(1.0);
  for (int n = 0; n < 20; ++n) { history.push_back(run_of(2e6, "g++ 13")); }
  const std::vector<Trend> trends = trends_of(history);
  CHECK(trends.size() == 1 && trends.front().values.size() == 20);
  CHECK(history_outcome(history).status == Status::pass);
}

TEST("pairs come back from their text to the last bit, and half a text is refused") {
  const PairedReport report{.start = {.pairs = {{1e-3 / 3.0, 2e-3, 1e-3, 2e-3}, {0.1, 0.2, 0.3, 0.4}}, .batch_deadline = 0.02},
                            .same_motion = true};
  const PairedReport read = paired_report_from(to_text(report));
  CHECK(read.same_motion && read.start.pairs.size() == 2);
  CHECK_NEAR(read.start.pairs[0].base, 1e-3 / 3.0, 0.0);
  CHECK_NEAR(read.start.pairs[1].head_wall, 0.4, 0.0);
  CHECK_NEAR(read.start.batch_deadline, 0.02, 0.0);
  for (const std::string& text :
       {to_text(report).substr(0, to_text(report).size() - 5), std::string("same\n0.1 -3\n"), std::string()}) {
    bool refused = false;
    try {
      (void)paired_report_from(text);
    } catch (const InputError&) { refused = true; }
    CHECK(refused);
  }
}

}  // namespace

// SPDX-License-Identifier: MIT

#include "reports/index_page.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
namespace fs = std::filesystem;

void write_summary(const fs::path& folder, double force, double tick,
                   const std::string& status = "ok") {
  fs::create_directories(folder);
  io::replace_file(folder / "summary.json", R"({"schema": 1, "title": "A <needle>", "status": ")" +
                                                status + R"(", "peak_force_n": )" +
                                                std::to_string(force) + R"(, "slowest_tick_s": )" +
                                                std::to_string(tick) + "}\n");
}

std::string page_in(const fs::path& parent) {
  return io::read_text(parent / "index.html", 1U << 24U);
}

TEST("the page names what changed since the run before, and no times of the machine") {
  const io::ScratchFolder scratch;
  const fs::path run = scratch.path() / "run";
  write_summary(run, 1.5, 0.001);
  add_to_index(run, "palpate run a.toml", 0);
  CHECK_CONTAINS(page_in(scratch.path()), "Nothing, or every result is the first of its folder.");
  write_summary(run, 1.5, 0.002);
  add_to_index(run, "palpate run a.toml", 0);
  CHECK_CONTAINS(page_in(scratch.path()), "Nothing, or every result is the first of its folder.");
  write_summary(run, 1.75, 0.002);
  add_to_index(run, "palpate run a.toml", 0);
  const std::string page = page_in(scratch.path());
  CHECK_CONTAINS(page, "run: peak force 1.75 N, before: 1.5 N");
  CHECK_CONTAINS(page, "A &lt;needle&gt;");
  CHECK_CONTAINS(page, "href=\"run/report.html\"");
  CHECK_CONTAINS(page, "aria-label=\"the last 3 runs\"");
  CHECK(read_index(scratch.path() / "index.jsonl").size() == 3);
}

TEST("a folder's result is what its newest file says; a folder without a result is not listed") {
  const io::ScratchFolder scratch;
  const fs::path folder = scratch.path() / "both";
  write_summary(folder, 1.0, 0.001, "diverged");
  CHECK(index_line_of(folder).kind == "run");
  CHECK(index_line_of(folder).exit_code == 1);
  io::replace_file(folder / "results.json",
                   R"({"title": "T", "cases": [{"status": "pass"}, {"status": "skip"}]})");
  fs::last_write_time(folder / "summary.json",
                      fs::file_time_type::clock::now() - std::chrono::hours(1));
  const IndexLine line = index_line_of(folder);
  CHECK(line.kind == "validate");
  CHECK(line.exit_code == 0);
  CHECK(line.values.size() == 3);  // pass, fail, skip
  CHECK(index_line_of(scratch.path()).kind.empty());
}

TEST("folders are found once, those that were deleted are omitted, and damage has its line") {
  const io::ScratchFolder scratch;
  write_summary(scratch.path() / "a", 1.0, 0.001);
  write_summary(scratch.path() / "b", 2.0, 0.001, "diverged");
  fs::create_directories(scratch.path() / "empty");
  CHECK(index_folders_in(scratch.path()) == 2);
  CHECK(index_folders_in(scratch.path()) == 2);
  CHECK(read_index(scratch.path() / "index.jsonl").size() == 2);
  CHECK_CONTAINS(page_in(scratch.path()), "One of them failed.");
  fs::remove_all(scratch.path() / "b");
  CHECK(index_folders_in(scratch.path()) == 1);
  CHECK_CONTAINS(page_in(scratch.path()), "None failed.");
  io::replace_file(scratch.path() / "index.jsonl", "{}\n{}\n");
  CHECK_THROWS_AS(InputError, index_folders_in(scratch.path()), "index.jsonl:1: not one result");
  io::replace_file(scratch.path() / "a/summary.json", "{");
  CHECK_THROWS_AS(InputError, index_line_of(scratch.path() / "a"), "summary.json:1: ");
}

}  // namespace PALPATE_FILE

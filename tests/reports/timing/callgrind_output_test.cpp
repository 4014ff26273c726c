// SPDX-License-Identifier: MIT
#include "reports/timing/callgrind_output.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scratch_folder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/timing/child_process.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::timing;

/// As callgrind 3.19 writes it.
std::string part(int number, const std::string& trigger, const std::string& totals) {
  return "# callgrind format\nversion: 1\ncreator: callgrind-3.19.0\npid: 9\ncmd:  palpate steps x\npart: " +
         std::to_string(number) + "\n\n\ndesc: Timerange: Basic block 0 - 2005\ndesc: Trigger: " + trigger +
         "\n\npositions: line\nevents: Ir\nsummary: 11025\n\n\n0 11010\n" + totals;
}

template <class Do>
bool refused(Do&& work, const std::string& what) {
  try {
    work();
  } catch (const InputError& error) { return std::string(error.what()).find(what) != std::string::npos; }
  return false;
}

TEST("a part has its number, the label that the program gave, and its instructions") {
  const CallgrindPart read =
      part_from(part(3, "Client Request: springs-damped-double", "\ntotals: 11025\n"), "part.3");
  CHECK(read.number == 3 && read.label == "springs-damped-double");
  CHECK(read.instructions == 11025 && read.creator == "callgrind-3.19.0");
}

TEST("a file that is cut short, or counts something else, or holds no number is refused by name") {
  const std::string whole = part(1, "Client Request: x", "\ntotals: 11025\n");
  CHECK(refused([&] { part_from(whole.substr(0, whole.size() - 15), "part.1"); }, "part.1: ends without totals"));
  std::string other = whole;
  other.replace(other.find("events: Ir"), 10, "events: Dr");
  CHECK(refused([&] { part_from(other, "part.1"); }, "part.1: counts Dr"));
  CHECK(refused([&] { part_from(part(1, "x", "\ntotals: 1e9\n"), "part.1"); }, "\"1e9\" where a count should be"));
}

TEST("of a folder only what the program asked for counts, in its order") {
  const io::ScratchFolder folder;
  io::replace_file(folder.path() / "part.10", part(10, "Client Request: b", "\ntotals: 2\n"));
  io::replace_file(folder.path() / "part.2", part(2, "Client Request: a", "\ntotals: 1\n"));
  io::replace_file(folder.path() / "part", part(11, "Program termination", "\ntotals: 9\n"));
  const std::vector<CallgrindPart> parts = labelled_parts(folder.path());
  CHECK(parts.size() == 2);
  CHECK(parts[0].label == "a" && parts[1].label == "b" && parts[1].instructions == 2);
}

TEST("a child gives its output, its errors and its status") {
  const ChildEnd end = run_child(
      {"/bin/sh", "-c", "echo out; echo '==1== x' >&2; echo 'palpate: why' >&2; echo '==1== y' >&2; exit 3"},
      nullptr);
  CHECK(end.status == 3 && !end.stopped);
  CHECK(end.output == "out\n");
  CHECK(end.last_words() == "why");
}

TEST("a child that is stopped is gone at once, and one that dies tells its signal") {
  const std::atomic<bool> stop{true};
  CHECK(run_child({"/bin/sleep", "60"}, &stop).stopped);
  CHECK(run_child({"/bin/sh", "-c", "kill -TERM $$"}, nullptr).status == 128 + 15);
}

TEST("a program that is not there is not found") {
  CHECK(find_program("sh").filename() == "sh");
  CHECK(find_program("no-such-program-anywhere").empty());
  CHECK(run_child({"/no/such/program"}, nullptr).status == 127);
}

}  // namespace

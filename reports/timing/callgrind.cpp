// SPDX-License-Identifier: MIT

#include "reports/timing/callgrind.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>
#include <valgrind/callgrind.h>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/timing/child_process.hpp"

namespace palpate::timing {

namespace {

constexpr std::size_t most_bytes = 1U << 26U;
constexpr std::string_view request = "desc: Trigger: Client Request: ";

/// Returns the text after a key at the start of a line.
std::optional<std::string> after(const std::string& line, std::string_view key) {
  if (!line.starts_with(key)) { return std::nullopt; }
  return line.substr(key.size());
}

template <class Integer> Integer number_from(const std::string& text, const std::string& file) {
  Integer number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || rest != end) {
    throw InputError(file + ": \"" + text + "\" where a count should be; a whole number");
  }
  return number;
}

}  // namespace

CallgrindPart part_from(const std::string& text, const std::string& file) {
  CallgrindPart part;
  bool counted = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (const auto creator = after(line, "creator: ")) { part.creator = *creator; }
    if (const auto label = after(line, request)) { part.label = *label; }
    if (const auto number = after(line, "part: ")) {
      part.number = number_from<int>(*number, file);
    }
    if (const auto events = after(line, "events: "); events && *events != "Ir") {
      throw InputError(file + ": counts " + *events + "; Ir alone");
    }
    if (const auto totals = after(line, "totals: ")) {
      part.instructions = number_from<std::int64_t>(*totals, file);
      counted = true;
    }
  }
  if (!counted) { throw InputError(file + ": ends without totals; a whole file of callgrind"); }
  return part;
}

std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder) {
  std::vector<CallgrindPart> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    parts.push_back(part_from(io::read_text(entry.path(), most_bytes), entry.path().string()));
  }
  std::erase_if(parts, [](const CallgrindPart& part) { return part.label.empty(); });
  std::ranges::sort(parts, {}, &CallgrindPart::number);
  return parts;
}

void run_counted(const std::string& label, const std::function<void()>& work) {
  const char* const text = label.c_str();
  CALLGRIND_START_INSTRUMENTATION;
  CALLGRIND_ZERO_STATS;
  work();
  CALLGRIND_DUMP_STATS_AT(text);
  CALLGRIND_STOP_INSTRUMENTATION;
}

namespace {

constexpr int bad_input = 2;  // exit code of `palpate` for bad input

std::string why_not(const std::filesystem::path& valgrind) {
#ifdef PALPATE_SANITIZED
  return "a program with sanitizers does not run under valgrind";
#endif
  return valgrind.empty() ? "valgrind is not installed (the package valgrind)" : "";
}

std::vector<std::string> command_of(const std::filesystem::path& valgrind,
                                    const std::filesystem::path& folder,
                                    const std::vector<std::string>& words) {
  std::vector<std::string> command{
      valgrind.string(),      "--tool=callgrind",
      "--instr-atstart=no",   "--callgrind-out-file=" + (folder / "part").string(),
      own_program().string(), "steps"};
  command.insert(command.end(), words.begin(), words.end());
  return command;
}

}  // namespace

InstructionCount count_steps(const std::vector<std::string>& words, const std::atomic<bool>* stop) {
  InstructionCount count;
  const std::filesystem::path valgrind = find_program("valgrind");
  count.refusal = why_not(valgrind);
  if (!count.refusal.empty()) { return count; }
  const io::ScratchFolder folder;
  const ChildEnd end = run_child(command_of(valgrind, folder.path(), words), stop);
  if (end.stopped) {
    count.refusal = "interrupted";
  } else if (end.status == bad_input) {
    throw InputError(end.last_words());
  } else if (end.status != 0) {
    count.refusal = "valgrind ended with " + std::to_string(end.status) + ": " + end.last_words();
  } else {
    for (const CallgrindPart& part : labelled_parts(folder.path())) {
      count.passes.push_back(part.instructions);
      count.kernel = part.label;
      count.counter = part.creator;
    }
    if (count.passes.empty()) { count.refusal = "callgrind counted nothing"; }
  }
  return count;
}

InstructionCounter callgrind_counter(const std::atomic<bool>* stop) {
  // Each count starts a new process. A second count in one process would use other memory
  // addresses, which changes the instruction count.
  return [stop](const std::string& workload) {
    InstructionCount count = count_steps({workload}, stop);
    if (!count.refusal.empty()) { return count; }
    const InstructionCount again = count_steps({workload}, stop);
    count.refusal = again.refusal;
    count.passes.insert(count.passes.end(), again.passes.begin(), again.passes.end());
    return count;
  };
}

}  // namespace palpate::timing

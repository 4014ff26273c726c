// SPDX-License-Identifier: MIT
#include "reports/timing/instruction_counter.hpp"

#include "fixtures/io/scratch_folder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/timing/callgrind_output.hpp"
#include "reports/timing/child_process.hpp"

namespace palpate::timing {

namespace {

constexpr int bad_input = 2;  // what `palpate` ends with then

std::string why_not(const std::filesystem::path& valgrind) {
#ifdef PALPATE_SANITIZED
  return "a program with sanitizers does not run under valgrind";
#endif
  return valgrind.empty() ? "valgrind is not installed (the package valgrind)" : "";
}

std::vector<std::string> command_of(const std::filesystem::path& valgrind, const std::filesystem::path& folder,
                                    const std::vector<std::string>& words) {
  std::vector<std::string> command{valgrind.string(),      "--tool=callgrind",
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
  // In one process a second time would begin at other places in memory, where loops over it start otherwise.
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

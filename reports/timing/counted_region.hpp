// SPDX-License-Identifier: MIT
#pragma once
/// The stretch of a program that a profiler is to look at.

#include <functional>
#include <string>

namespace palpate::timing {

/// Does the work. Under `valgrind --tool=callgrind --instr-atstart=no` its instructions, and nothing else, are
/// counted into a part with that label (callgrind_output.hpp); without, it costs nothing.
void run_counted(const std::string& label, const std::function<void()>& work);

}  // namespace palpate::timing

// SPDX-License-Identifier: MIT
#include "reports/timing/counted_region.hpp"

#include <valgrind/callgrind.h>

namespace palpate::timing {

void run_counted(const std::string& label, const std::function<void()>& work) {
  const char* const text = label.c_str();
  CALLGRIND_START_INSTRUMENTATION;
  CALLGRIND_ZERO_STATS;
  work();
  CALLGRIND_DUMP_STATS_AT(text);
  CALLGRIND_STOP_INSTRUMENTATION;
}

}  // namespace palpate::timing

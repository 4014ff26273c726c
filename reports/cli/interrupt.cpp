// SPDX-License-Identifier: MIT
#include "reports/cli/interrupt.hpp"

#include <csignal>

namespace palpate::cli {

std::atomic<bool> interrupted{false};

void catch_interrupts() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  const auto note = [](int signal) {
    interrupted.store(true);
    std::signal(signal, SIG_DFL);  // whoever asks twice does not want to wait
  };
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

}  // namespace palpate::cli

// SPDX-License-Identifier: MIT
// falcon_client PATH REQUESTS DEADLINE_S: polls a Falcon on a terminal at 1 kHz and prints how many
// replies came in time.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <thread>

#include "device/byte_link.hpp"
#include "device/falcon/driver.hpp"

namespace {

using namespace palpate::device;
using namespace palpate::device::falcon;

long long poll_device(const char* path, int requests, double deadline_s) {
  TerminalLink link(path);
  Driver driver(link, {.reply_deadline = deadline_s});
  const double begin = link.now();
  for (int n = 0; n < requests; ++n) {
    (void)driver.exchange({.words = {10, -10, 4096}, .leds = {.green = true}});
    const double rest = begin + 1e-3 * (n + 1) - link.now();
    if (rest > 0.0) { std::this_thread::sleep_for(std::chrono::duration<double>(rest)); }
  }
  return driver.counts().replies;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) { return 2; }
  try {
    std::printf("%lld\n", poll_device(argv[1], std::atoi(argv[2]), std::atof(argv[3])));
    return 0;
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 2;
  }
}

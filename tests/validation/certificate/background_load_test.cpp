// SPDX-License-Identifier: MIT
#include "validation/certificate/background_load.hpp"

#include <chrono>

#include "device/real_time.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::certificate;

TEST("every load but idle works until it is gone") {
  const std::vector<int> processors = palpate::device::allowed_processors();
  for (const char* name : {"cpu", "cache", "memory"}) {
    BackgroundLoad load(name, {processors.back()}, 1U << 20U);
    for (int n = 0; n < 500 && load.rounds() < 2; ++n) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    CHECK(load.threads() == 1 && load.rounds() >= 2);
  }
  CHECK(BackgroundLoad("idle", processors, 1U << 20U).threads() == 0);
}

TEST("names that are no load are known as such") {
  CHECK(is_own_load("idle") && is_own_load("memory"));
  CHECK(!is_own_load("gpu") && !is_own_load(""));
}

}  // namespace

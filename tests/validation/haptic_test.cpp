// SPDX-License-Identifier: MIT
/// Faults planted in haptic loops must turn the verdicts of group "haptics" red; without a fault the
/// same cases are green.
#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

TEST("one tick of delay too much is seen") {
  const Mutation fault{.name = "one more tick of delay", .loop_delay = 1};
  check_red(fault, {"haptics/wall/boundary", "haptics/wall/z-width", "haptics/wall/passivity",
                    "haptics/falcon/reference"});
}

TEST("a stiffness that is 1 % too high is seen through the device") {
  const Mutation fault{.name = "stiffness +1 %", .model = [](Scene&, SpringNetwork& network) {
                         network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
                       }};
  check_red(fault, {"haptics/falcon/reference"});
}

}  // namespace

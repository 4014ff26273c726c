// SPDX-License-Identifier: MIT
/// Tests that faults planted in insertions fail the verdicts of needle and probe, which pass
/// without a fault.

#include <cstdio>
#include <limits>

#include "tests/validation/planted_faults.hpp"
#include "validation/roll_out.hpp"

namespace {

using namespace palpate;

TEST("a stiffness that is 1 % too high is seen") {
  const Mutation fault{.name = "stiffness +1 %", .model = [](Scene&, SpringNetwork& network) {
                         network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
                       }};
  check_red(fault, {"needle/chain", "needle/order", "needle/rest", "needle/momentum"});
}

TEST("a damper that feeds energy in is seen") {
  const Mutation fault{
      .name = "damping turned round", .model = [](Scene&, SpringNetwork& network) {
        network.springs.change_each([&](Spring& s) { s.viscosity = -s.viscosity; });
      }};
  check_red(fault, {"needle/order", "needle/momentum", "needle/energy"});
}

TEST("a missing spring is seen") {
  const Mutation fault{
      .name = "one spring missing", .model = [](Scene&, SpringNetwork& network) {
        network.springs.edit([&](std::vector<Spring>& all) { all.erase(all.begin() + 3); });
      }};
  check_red(fault, {"needle/chain"});
}

TEST("a cutting force that is 1 % too high is seen") {
  const Mutation fault{.name = "cutting force +1 %", .model = [](Scene& scene, SpringNetwork&) {
                         for (Material& m : scene.materials) { m.cutting_force *= 1.01; }
                       }};
  check_red(fault, {"needle/chain", "needle/layers", "needle/loss-of-resistance", "needle/parts"});
}

TEST("a friction that is 5 % too high is seen") {
  const Mutation fault{.name = "friction +5 %", .model = [](Scene& scene, SpringNetwork&) {
                         for (Material& m : scene.materials) { m.friction *= 1.05; }
                       }};
  check_red(fault, {"needle/friction/loop", "needle/reference/continuous-20-mm-s"});
}

TEST("a layer that is half a millimetre too thick is seen") {
  const Mutation fault{.name = "layer too thick", .model = [](Scene& scene, SpringNetwork&) {
                         scene.tissue.layers.front().thickness += 5e-4;
                       }};
  check_red(fault, {"needle/chain", "needle/reference/continuous-20-mm-s", "needle/angles"});
}

TEST("a step used twice is seen") {
  const Mutation fault{.name = "step twice", .step_twice = true};
  check_red(fault, {"needle/order", "needle/momentum", "needle/reference/continuous-20-mm-s"});
}

TEST("a syringe that empties 1 % too slowly is seen") {
  const Mutation fault{.name = "compliance +1 %", .model = [](Scene& scene, SpringNetwork&) {
                         if (scene.syringe) { scene.syringe->compliance *= 1.01; }
                       }};
  check_red(fault, {"needle/loss-of-resistance"});
}

TEST("a force that is not a number is never a pass") {
  const Mutation fault{.name = "NaN", .trace = [](Trace& run) {
                         std::vector<double>& force = run.values("tool.force_n");
                         force[force.size() / 2] = std::numeric_limits<double>::quiet_NaN();
                         force.back() = std::numeric_limits<double>::quiet_NaN();
                       }};
  check_red(fault, {"needle/chain", "needle/momentum", "needle/parts", "needle/rest",
                    "needle/reference/continuous-20-mm-s", "needle/stress", "needle/bone"});
}

TEST("samples shifted by one are seen") {
  const Mutation fault{.name = "samples shifted by one", .trace = [](Trace& run) {
                         for (Column& column : run.columns) {
                           if (!column.name.starts_with("tool.")) { continue; }
                           std::shift_right(column.values.begin(), column.values.end(), 1);
                         }
                       }};
  check_red(fault, {"needle/momentum", "needle/order"});
}

TEST("an event that is missing, or two ticks late, is seen") {
  const Mutation missing{
      .name = "no loss of resistance", .trace = [](Trace& run) {
        std::erase_if(run.events, [](const Event& e) { return e.kind == "loss-of-resistance"; });
      }};
  check_red(missing, {"needle/layers", "needle/loss-of-resistance"});
  const Mutation late{.name = "events two ticks late", .trace = [](Trace& run) {
                        for (Event& e : run.events) { e.time += 2e-3; }
                      }};
  check_red(late, {"needle/reference/continuous-20-mm-s"});
}

TEST("a probe whose bone is soft is seen") {
  const Mutation fault{.name = "stiffness +1 %", .model = [](Scene&, SpringNetwork& network) {
                         network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
                       }};
  check_red(fault, {"probe/palpation-map"});
}

// Tests that faults planted in haptic loops fail the verdicts of group "haptics", which pass
// without a fault.

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

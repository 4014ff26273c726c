// SPDX-License-Identifier: MIT
#include <cmath>

#include "device/falcon/driver_profile.hpp"
#include "device/falcon/plant.hpp"
#include "tests/check.hpp"
#include "tests/model/allocation_count.hpp"

namespace {

using namespace palpate::device;
using namespace palpate::device::falcon;
using Vector = Eigen::Vector3d;

TEST("kinematics allocate nothing, whether they succeed or not") {
  const Kinematics kinematics;
  const long before = check::allocations;
  for (int n = 0; n < 100; ++n) {
    const auto angles = kinematics.inverse({0.0, 1e-4 * n, 0.12});
    const auto back = kinematics.forward(angles->theta1);
    CHECK(back.has_value());
    CHECK(!kinematics.inverse({0.0, 0.0, 0.4}) && !kinematics.forward({-2.0, 2.0, 0.5}));
  }
  CHECK_NEAR(static_cast<double>(check::allocations - before), 0.0, 0.0);
}

TEST("a tick of drivers, encoders, motors, plant, arm, intent and its stop allocates nothing") {
  const Vector start = Kinematics::centre();
  Plant plant;
  Motors motors;
  Encoders encoders(libnifalcon(), {}, 1);
  CorrectProfile correct;
  StockProfile stock;
  Hand hand{.arm = arm_stage,
            .intent = Intent({.actions = {Intermittent{}, Withdraw{}}, .tremor = 5e-5})};
  plant.place(start, hand);
  encoders.home();
  const long before = check::allocations;
  for (int n = 0; n < 1500; ++n) {
    encoders.sample(plant.theta1(), false);
    const Vector seen = correct.position(encoders.counts());
    stock.position(encoders.counts());
    const Vector force(0.0, 0.0, n > 700 ? 9.0 : std::sin(0.1 * n));
    motors.command((n % 2 == 0 ? correct.words(seen, force) : stock.words(seen, force)).sent);
    plant.advance(1e-3, motors, hand);
    if (n == 400) { hand.intent.loss_of_resistance(plant.time()); }
    (void)plant.energy(hand);
  }
  CHECK_NEAR(static_cast<double>(check::allocations - before), 0.0, 0.0);
}

}  // namespace

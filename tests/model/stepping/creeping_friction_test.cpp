// SPDX-License-Identifier: MIT

#include "model/stepping/creeping_friction.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

constexpr double v1 = CreepingFriction::reference_speed;

/// Friction after `time` at a velocity, in steps of h.
double moved(CreepingFriction law, double velocity, double time, double h) {
  const auto steps = std::lround(time / h);
  for (long n = 0; n < steps; ++n) { law.force = law.after(h, velocity).force; }
  return law.force;
}

TEST("a shaft that slides steadily has the friction of its speed") {
  for (const double exponent : {0.05, 0.2, 1.0}) {
    for (const double speed : {1e-4, 1e-3, 2e-3, -5e-3}) {
      const CreepingFriction law{
          .travel = 1e-3, .exponent = exponent, .friction = 1.5, .length = 1.0};
      const double steady = std::copysign(1.5 * std::pow(std::abs(speed) / v1, exponent), speed);
      // The slowest approach is exp(-v_1 t / delta), with the exponent 1.
      CHECK_NEAR(moved(law, speed, 40.0, 1e-3), steady, 1e-9);
    }
  }
}

TEST("the friction of a held shaft falls as the tissue recoils, to the order of the step") {
  const double nu = 0.2;
  const CreepingFriction law{
      .travel = 4e-3, .exponent = nu, .friction = 1.5, .length = 1.0, .force = 1.7};
  const double start = 1.7 / 1.5;
  const double time = 5.0;
  const double exact =
      1.7 * std::pow(1.0 + (1.0 / nu - 1.0) * std::pow(start, 1.0 / nu - 1.0) * v1 * time / 4e-3,
                     -nu / (1.0 - nu));
  const double coarse = moved(law, 0.0, time, 2e-3) - exact;
  const double fine = moved(law, 0.0, time, 1e-3) - exact;
  CHECK(exact < 0.7 * 1.7);
  CHECK(std::abs(fine) < 1e-3 * exact);
  CHECK_NEAR(coarse / fine, 2.0, 0.01);  // first order
}

TEST("without an exponent the tissue is dragged along up to the travel") {
  const CreepingFriction law{.travel = 2e-3, .exponent = 0.0, .friction = 1.5, .length = 1.0};
  CHECK_NEAR(moved(law, 1e-3, 1.0, 1e-3), 0.75, 1e-12);
  CHECK_NEAR(moved(law, 1e-3, 5.0, 1e-3), 1.5, 1e-12);
  CHECK_NEAR(
      moved({.travel = 2e-3, .friction = 1.5, .length = 1.0, .force = 1.5}, -1e-3, 4.0, 1e-3), -1.5,
      1e-12);
}

TEST("a step without a duration keeps the force, and without a limit there is none") {
  CHECK_NEAR((CreepingFriction{
                  .travel = 1e-3, .exponent = 0.2, .friction = 1.0, .length = 1.0, .force = 0.3})
                 .after(0.0, 1.0)
                 .force,
             0.3, 1e-15);
  CHECK((CreepingFriction{.travel = 1e-3}).after(1e-3, 1.0).force == 0.0);
}

TEST("the slope is the derivative of the force over the velocity") {
  for (const double exponent : {0.0, 0.1, 0.5}) {
    const CreepingFriction law{
        .travel = 2e-3, .exponent = exponent, .friction = 1.5, .length = 1.0, .force = 0.9};
    for (const double velocity : {-0.01, 0.001, 0.02}) {
      const double step = 1e-6;
      const double by_difference =
          (law.after(1e-3, velocity + step).force - law.after(1e-3, velocity - step).force) /
          (2.0 * step);
      // A central difference of second order, of a force of about one newton.
      CHECK_NEAR(law.after(1e-3, velocity).slope, by_difference, 1e-6 * by_difference + 1e-8);
    }
  }
}

TEST("shaft that enters has rubbed over its way, and shaft that leaves takes its share along") {
  CreepingFriction law{.travel = 2e-3, .exponent = 0.2, .friction = 100.0};
  law.reach(1e-3, 30e-3);  // half of the way belongs to the tissue, the other half is drag
  CHECK_NEAR(law.length, 0.5e-3, 1e-18);
  CHECK_NEAR(law.drag(), 0.5e-3, 1e-18);
  law.reach(12e-3, 30e-3);  // beyond the travel, all of the friction is there
  CHECK_NEAR(law.drag(), 12e-3 - law.length, 1e-17);
  CHECK_NEAR(law.force, 100.0 * (0.25 * 0.5e-3 + (law.length - 0.5e-3)), 1e-15);
  const double drag = law.drag();
  law.reach(6e-3, 30e-3);
  CHECK_NEAR(law.drag(), drag, 1e-17);
  CHECK_NEAR(law.length, 6e-3 - drag, 1e-17);
  law.reach(40e-3, 30e-3);  // the tip is beyond the tissue
  CHECK(law.length == 30e-3);
  law.reach(0.0, 0.0);
  CHECK(law.length == 0.0);
  CHECK(law.force == 0.0);
}

TEST("the border of the tissue is where the drag takes it, for any entry") {
  for (const double force : {-0.3, -0.01, 0.0, 0.02, 0.2}) {
    for (const double entry : {1e-6, 1e-4, 1e-3, 2e-3, 3e-3, 10e-3}) {
      CreepingFriction law{
          .travel = 2e-3, .exponent = 0.2, .friction = 100.0, .length = 5e-3, .force = force};
      const double entered = law.length + law.drag() + entry;
      law.reach(entered, 1.0);
      CHECK_NEAR(law.length, entered - law.drag(), 1e-16);
      CHECK(law.length > 5e-3);
      // Over the travel of 2 mm the new shaft builds up its friction.
      const double grown = law.length - 5e-3;
      CHECK_NEAR(law.force, force + 100.0 * grown * std::min(grown / 2e-3, 1.0), 1e-15);
    }
  }
}

TEST("a shaft without slip keeps its length in the tissue, in and out") {
  for (const double velocity : {1e-3, -1e-3}) {
    CreepingFriction law{.travel = 2e-3, .friction = 100.0, .length = 10e-3};
    double entered = law.length;
    for (int n = 0; n < 1000; ++n) {  // 1 mm: half of the travel
      law.force = law.after(1e-3, velocity).force;
      entered += velocity * 1e-3;
      law.reach(entered, 1.0);
    }
    CHECK_NEAR(law.length, 10e-3, 1e-14);
    CHECK_NEAR(law.force, std::copysign(0.5, velocity), 1e-12);
  }
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
#include "model/dynamics/tool.hpp"

#include "model/dynamics/scene.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;

TEST("needle gauges have the outer diameters of the Stubs needle scale") {
  CHECK_NEAR(diameter_of_gauge(16).value(), 0.065 * 0.0254, 1e-6);  // the scale is in inches;
  CHECK_NEAR(diameter_of_gauge(17).value(), 0.058 * 0.0254, 1e-6);  // rounded to a micrometre
  CHECK_NEAR(diameter_of_gauge(18).value(), 0.050 * 0.0254, 1e-6);
  CHECK_NEAR(diameter_of_gauge(27).value(), 0.01625 * 0.0254, 1e-6);
  CHECK_NEAR(Needle{}.diameter, diameter_of_gauge(16).value(), 1e-15);
}

TEST("needles get thinner from gauge 14 to 27, and no other gauge is made") {
  for (int gauge = 14; gauge < 27; ++gauge) {
    CHECK(diameter_of_gauge(gauge + 1).value() < diameter_of_gauge(gauge).value());
  }
  for (const int gauge : {-16, 0, 13, 28, 2147483647, -2147483647 - 1}) {
    CHECK(!diameter_of_gauge(gauge));
  }
}

TEST("a role is what the material states, else what its name says") {
  const auto named = [](const char* name) { return role_of({.name = name}); };
  CHECK(named("fat") == TissueRole::tissue && named("") == TissueRole::tissue);
  CHECK(named("epidural-space") == TissueRole::epidural_space);  // though it contains "dura"
  CHECK(named("soft-dura") == TissueRole::dura);
  CHECK(named("cortical-bone") == TissueRole::bone);
  CHECK(role_of({.name = "bone", .role = TissueRole::tissue}) == TissueRole::tissue);
}

TEST("air fills a syringe with more compliance, less resistance and the same full pressure") {
  const Syringe saline;
  const Syringe air = air_syringe();
  CHECK(air.compliance > 10.0 * saline.compliance);
  CHECK(air.tissue_resistance < saline.tissue_resistance);
  CHECK(air.thumb_force == saline.thumb_force && air.plunger_area == saline.plunger_area);
}

}  // namespace

// SPDX-License-Identifier: MIT
#include "model/dynamics/syringe.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate;

const Syringe syringe{};
const double limit = syringe.thumb_force / syringe.plunger_area;

TEST("in ligament the pressure rises to what the thumb can hold") {
  SyringePressure p(syringe);
  for (int n = 0; n < 20000; ++n) { p.advance(1e-3, true, TissueRole::tissue); }
  CHECK_NEAR(p.pressure(), limit, 1e-9 * limit);
  CHECK_NEAR(p.thumb(), syringe.thumb_force, 1e-9);
}

TEST("loss of resistance is a decay with R C to what the thumb's flow keeps up") {
  SyringePressure p(syringe);
  while (p.pressure() < limit) { p.advance(1e-3, true, TissueRole::tissue); }
  const double end = syringe.thumb_flow * syringe.epidural_resistance;
  const double rc = syringe.epidural_resistance * syringe.compliance;
  double t = 0.0;
  for (int n = 0; n < 50; ++n) {
    p.advance(1e-3, true, TissueRole::epidural_space);
    t += 1e-3;
    CHECK_NEAR(p.pressure(), end + (limit - end) * std::exp(-t / rc), 1e-9 * limit);
  }
}

TEST("the decay does not depend on the step") {
  SyringePressure coarse(syringe);
  SyringePressure fine(syringe);
  coarse.advance(0.05, true, TissueRole::tissue);
  for (int n = 0; n < 500; ++n) { fine.advance(1e-4, true, TissueRole::tissue); }
  CHECK_NEAR(coarse.pressure(), fine.pressure(), 1e-9 * limit);
}

TEST("a tip in open air holds almost no pressure") {
  SyringePressure p(syringe);
  for (int n = 0; n < 1000; ++n) { p.advance(1e-3, false, TissueRole::tissue); }
  CHECK_NEAR(p.pressure(), syringe.thumb_flow * syringe.open_resistance, 1e-6);
}

}  // namespace

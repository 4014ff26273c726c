// SPDX-License-Identifier: MIT
#include "validation/comparison/tolerance.hpp"

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

TEST("there is one tolerance for every feature, in order, and each says who says so") {
  for (const QuantityKind kind : {QuantityKind::pressure, QuantityKind::force}) {
    const std::vector<Tolerance> all = default_tolerances(kind);
    CHECK(all.size() == feature_count);
    for (std::size_t n = 0; n < all.size(); ++n) {
      CHECK(all[n].feature == static_cast<Feature>(n));
      CHECK(!all[n].origin.empty());
    }
  }
}

TEST("the peak may be off by what group means of the trial were apart") {
  const Tolerance peak = default_tolerances(QuantityKind::pressure)[static_cast<std::size_t>(Feature::peak)];
  // From the middle of 376 and 461 mmHg the tolerance reaches exactly both.
  CHECK_NEAR(peak.lower(418.5), 376.0, 1e-9);
  CHECK_NEAR(peak.upper(418.5), 461.0, 1e-9);
}

TEST("a factor allows as much above as below in ratio") {
  const Tolerance tolerance{.feature = Feature::drop_time, .factor = 2.0};
  CHECK_NEAR(tolerance.lower(0.1), 0.05, 1e-15);
  CHECK_NEAR(tolerance.upper(0.1), 0.2, 1e-15);
}

TEST("a relative part is of the size, also below zero") {
  const Tolerance tolerance{.absolute = 1.0, .relative = 0.1};
  CHECK_NEAR(tolerance.lower(-10.0), -12.0, 1e-15);
  CHECK_NEAR(tolerance.upper(-10.0), -8.0, 1e-15);
}

}  // namespace

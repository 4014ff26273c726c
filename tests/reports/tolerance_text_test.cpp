// SPDX-License-Identifier: MIT
#include "reports/tolerance_text.hpp"

#include <sstream>

#include "model/dynamics/pressure_units.hpp"
#include "tests/check.hpp"

using namespace palpate;
using comparison::Feature;
using comparison::QuantityKind;
using comparison::Tolerance;

TEST("a width is a share, a number with its unit, their sum or a factor") {
  const Tolerance share = tolerance_from("peak=15%", QuantityKind::pressure);
  CHECK(share.feature == Feature::peak && share.absolute == 0.0);
  CHECK_NEAR(share.relative, 0.15, 1e-15);
  CHECK_NEAR(tolerance_from("plateau=7mmHg", QuantityKind::pressure).absolute, 7.0 * pascals_per_mmhg, 1e-9);
  const Tolerance both = tolerance_from("slope_before=30%+5mmHg/s", QuantityKind::pressure);
  CHECK_NEAR(both.relative, 0.3, 1e-15);
  CHECK_NEAR(both.absolute, 5.0 * pascals_per_mmhg, 1e-9);
  CHECK(tolerance_from("drop_time=x2.5", QuantityKind::pressure).factor == 2.5);
  CHECK(tolerance_from("relative_drop=0.1", QuantityKind::pressure).absolute == 0.1);
  CHECK_NEAR(tolerance_from("depth_of_loss=3mm", QuantityKind::force).absolute, 3e-3, 1e-15);
  CHECK_NEAR(tolerance_from("time_of_loss=250ms", QuantityKind::force).absolute, 0.25, 1e-15);
}

TEST("what is no tolerance is refused with what is allowed") {
  const auto refused = [](const std::string& text, const char* message) {
    CHECK_THROWS(tolerance_from(text, QuantityKind::pressure), message);
  };
  refused("peak", "must be such as peak=15%");
  refused("peak=", "must be such as peak=15%");
  refused("peek=3%", "did you mean peak");
  refused("loss_of_resistance=1", "found or not, which has no width");
  refused("peak=7", "must be % or a unit of Pa");  // mmHg or Pa?
  refused("drop_time=0.5", "must be % or a unit of s");
  refused("peak=much", "must be such as");
  refused("peak=-5%", "must be such as");
  refused("peak=5mm", "must be % or a unit of Pa");
  refused("plateau=1N", "must be % or a unit of Pa");
  refused("drop_time=x1", "a factor must be a number > 1");
  refused("drop_time=xs", "must be such as");
}

TEST("the defaults that --help shows are those in force") {
  for (const QuantityKind quantity : {QuantityKind::pressure, QuantityKind::force}) {
    std::istringstream lines(tolerance_help(quantity));
    std::size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
      const Tolerance shown = tolerance_from(line.substr(2), quantity);
      const Tolerance used =
          comparison::default_tolerances(quantity).at(static_cast<std::size_t>(shown.feature));
      // Three digits are shown.
      CHECK_NEAR(shown.absolute, used.absolute, 5e-3 * used.absolute + 1e-300);
      CHECK_NEAR(shown.relative, used.relative, 5e-3 * used.relative + 1e-300);
      CHECK(shown.factor == used.factor);
    }
    CHECK(count == comparison::feature_count - 1);
  }
}

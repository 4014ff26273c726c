// SPDX-License-Identifier: MIT
#include "validation/comparison/feature_words.hpp"

#include "model/dynamics/pressure_units.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;

/// Spaces that do not break are spaces to the eye.
std::string eye(std::string text) {
  for (const std::string space : {"\u00a0", "\u202f"}) {
    for (std::size_t at = text.find(space); at != std::string::npos; at = text.find(space)) {
      text.replace(at, space.size(), " ");
    }
  }
  return text;
}

TEST("values are shown in the units of clinicians") {
  CHECK(eye(shown(Feature::peak, 461.0 * pascals_per_mmhg, "Pa")) == "461 mmHg");
  CHECK(eye(shown(Feature::depth_of_loss, 0.0393, "m")) == "39.3 mm");
  CHECK(eye(shown(Feature::relative_drop, 0.87, "1")) == "87 %");
  CHECK(eye(shown(Feature::slope_before, -2.5 * pascals_per_mmhg, "Pa/s")) == "−2.5 mmHg/s");
  CHECK(shown(Feature::loss_of_resistance, 0.0, "1") == "not found");
  CHECK(shown(Feature::peak, not_measured, "Pa") == "-");
}

TEST("what rounding leaves is shown as nothing, without a sign") {
  CHECK(eye(shown(Feature::slope_before, -1.058e-5 * pascals_per_mmhg, "Pa/s")) == "0 mmHg/s");
  CHECK(eye(shown(Feature::drop_time, -1e-9, "s")) == "0 s");
}

TEST("a sentence about the event says who shows it") {
  FeatureVerdict event{.feature = Feature::loss_of_resistance, .verdict = Verdict::differs};
  event.recorded.value = 1.0;
  event.simulated.value = 0.0;
  CHECK(sentence_of(event) ==
        "loss of resistance: not found in the simulated trace, found in the recorded one: differs");
}

TEST("a sentence has both numbers, what is allowed, how well they are known and the verdict") {
  FeatureVerdict drop{.feature = Feature::relative_drop, .unit = "1", .lower = 0.67, .upper = 1.07,
                      .expanded = 0.012, .verdict = Verdict::differs};
  drop.recorded.value = 0.87;
  drop.simulated.value = 0.5;
  CHECK(eye(sentence_of(drop)) ==
        "relative drop: 50 % simulated, 87 % recorded; 67 to 107 % allowed, known to ±1.2 %: differs");
}

TEST("a sentence about what is absent has the reason") {
  const FeatureVerdict depth{.feature = Feature::depth_of_peak, .verdict = Verdict::not_judged,
                             .reason = "in neither: depth was not recorded"};
  CHECK(sentence_of(depth) == "depth of peak: in neither: depth was not recorded: not judged");
}

TEST("tolerances are told in the same units") {
  const Tolerance plateau{.feature = Feature::plateau, .absolute = 7.0 * pascals_per_mmhg};
  CHECK(eye(shown(plateau, "Pa")) == "7 mmHg");
  CHECK(shown(Tolerance{.feature = Feature::drop_time, .factor = 2.0}, "s") == "a factor of 2");
  CHECK(shown(Tolerance{.feature = Feature::loss_of_resistance}, "1") == "the same");
}

}  // namespace

// SPDX-License-Identifier: MIT
#include "validation/calibration/observation.hpp"

#include <cmath>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

TEST("bins of a straight force are its values in their middles, however the hand moves") {
  const ObservedInsertion seen = observe(straight_insertion());
  CHECK(seen.force == ForceSource::recorded && seen.refusal.empty());
  CHECK_NEAR(seen.value[index_of(Observable::depth_of_loss)], 20e-3, 2e-5);        // two samples at 1 mm/s
  CHECK_NEAR(seen.value[index_of(Observable::force)], 2.0 + 100.0 * 11e-3, 2e-3);  // 2e-5 m of depth, 100 N/m
  CHECK_NEAR(seen.value[index_of(Observable::force) + 3], 2.0 + 100.0 * 17e-3, 2e-3);
}

TEST("without a recorded force the plunger tells it in the continuous technique alone") {
  Recording recording = straight_insertion();
  recording.force.clear();
  const ObservedInsertion driven = observe(recording);
  CHECK(driven.force == ForceSource::plunger);
  CHECK_NEAR(driven.value[index_of(Observable::force)], 60e3 * recording.plunger_area,
             1e-9);  // Eq. 1, a level pressure
  recording.technique = "intermittent";
  const ObservedInsertion pushed = observe(recording);
  CHECK(pushed.force == ForceSource::none && std::isnan(pushed.value[index_of(Observable::force)]));
  CHECK_NEAR(pushed.value[index_of(Observable::plateau)], 2000.0, 1e-6);  // rounding: it is constant
}

TEST("a pressure that is not lost is refused, and without depth there are no bins") {
  CHECK(observe(straight_insertion(60e3, 20e-3, 59e3)).refusal.find("no loss of resistance") !=
        std::string::npos);
  Recording recording = straight_insertion();
  recording.depth.clear();
  const ObservedInsertion seen = observe(recording);
  CHECK(seen.refusal.empty() && std::isnan(seen.value[index_of(Observable::force)]));
  CHECK(std::isfinite(seen.value[index_of(Observable::force_peak)]));
  CHECK(observe(Trace{.time = {0.0, 1.0}}).refusal == "has no syringe or no tool");
}

TEST("every observable has a name and a unit of its own kind") {
  CHECK(name_of(0) == "pressure.peak" && unit_of(0) == "Pa");
  CHECK(name_of(observable_count - 1) == "force.-2_to_-0.5_mm" && unit_of(observable_count - 1) == "N");
  CHECK(unit_of(index_of(Observable::drop_time)) == "s" &&
        unit_of(index_of(Observable::depth_of_loss)) == "m");
}

}  // namespace

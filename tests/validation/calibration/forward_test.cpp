// SPDX-License-Identifier: MIT

#include "validation/calibration/forward.hpp"

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"
#include "validation/calibration/observation.hpp"
#include "validation/calibration/parameter.hpp"

namespace {

using namespace palpate::calibration;
using namespace palpate;

const Parameter* find(const std::vector<Parameter>& all, std::string_view key) {
  const auto found = std::ranges::find(all, key, &Parameter::key);
  return found == all.end() ? nullptr : &*found;
}

TEST("parameters are those of the layers before the epidural space and of the syringe") {
  const std::vector<Parameter> all = parameters_of(three_layers());
  CHECK(all.size() == 3 + 3 + 1 + 4);
  CHECK(find(all, "material.ligament.cutting_force") != nullptr);
  CHECK(find(all, "layer.0.thickness") != nullptr);
  CHECK(find(all, "material.epidural-space.youngs_modulus") == nullptr);
  CHECK(find(all, "material.ligament.cutting_force")->prior == 5.0);
}

TEST("one spread is one spread of the logarithm, and default bounds are four") {
  Parameter p{.key = "x", .prior = 2.0, .spread = 0.5};
  set_default_bounds(p);
  CHECK_NEAR(p.value(1.0), 2.0 * std::exp(0.5), 1e-14);  // rounding
  CHECK_NEAR(p.standardised(p.value(-2.5)), -2.5, 1e-14);
  CHECK_NEAR(p.standardised(p.upper), 4.0, 1e-14);
}

TEST("a thicker layer makes the drive as much deeper and the scene longer") {
  const Scene scene = three_layers();
  const std::vector<Parameter> all = parameters_of(scene);
  const Scene changed = with_values(scene, {*find(all, "layer.0.thickness")}, {0.015});
  CHECK_NEAR(*changed.drive->depth, 0.038, 1e-15);  // rounding
  CHECK_NEAR(changed.simulation.duration, 9.0, 1e-12);
  const auto keys = changes(scene, changed);
  REQUIRE(keys.size() == 3);
  CHECK(keys[0].first == "layer.0.thickness");
  CHECK(keys[1].first == "drive.depth");
  CHECK(changes(scene, scene).empty());
}

TEST("a scene that cannot be calibrated has a reason") {
  CHECK(why_not_calibrated(three_layers()).empty());
  const std::pair<const char*, void (*)(Scene&)> faults[] = {
      {"syringe", [](Scene& scene) { scene.syringe.reset(); }},
      {"drive.depth", [](Scene& scene) { scene.drive->depth = 0.029; }},
      {"layer", [](Scene& scene) { scene.tissue.layers.pop_back(); }}};
  for (const auto& [key, change] : faults) {
    Scene scene = three_layers();
    change(scene);
    CHECK(why_not_calibrated(scene).starts_with(key));
  }
}

TEST("bins of a force linear in depth are its values at their middles") {
  const ObservedInsertion seen = observe(straight_insertion());
  CHECK(seen.force == ForceSource::recorded);
  CHECK(seen.refusal.empty());
  // Two samples at 1 mm/s, and 100 N/m of these.
  CHECK_NEAR(seen.value[index_of(Observable::depth_of_loss)], 20e-3, 2e-5);
  CHECK_NEAR(seen.value[index_of(Observable::force)], 2.0 + 100.0 * 11e-3, 2e-3);
  CHECK_NEAR(seen.value[index_of(Observable::force) + 3], 2.0 + 100.0 * 17e-3, 2e-3);
}

TEST("without a recorded force the plunger gives it in the continuous technique alone") {
  Recording recording = straight_insertion();
  recording.force.clear();
  const ObservedInsertion driven = observe(recording);
  CHECK(driven.force == ForceSource::plunger);
  // Eq. 1, a level pressure.
  CHECK_NEAR(driven.value[index_of(Observable::force)], 60e3 * recording.plunger_area, 1e-9);
  recording.technique = "intermittent";
  const ObservedInsertion pushed = observe(recording);
  CHECK(pushed.force == ForceSource::none);
  CHECK(std::isnan(pushed.value[index_of(Observable::force)]));
  CHECK_NEAR(pushed.value[index_of(Observable::plateau)], 2000.0, 1e-6);  // rounding: constant
}

TEST("a pressure that is not lost is refused, and without depth there are no bins") {
  CHECK_CONTAINS(observe(straight_insertion(60e3, 20e-3, 59e3)).refusal, "no loss of resistance");
  Recording recording = straight_insertion();
  recording.depth.clear();
  const ObservedInsertion seen = observe(recording);
  CHECK(seen.refusal.empty());
  CHECK(std::isnan(seen.value[index_of(Observable::force)]));
  CHECK(std::isfinite(seen.value[index_of(Observable::force_peak)]));
  CHECK(observe(Trace{.time = {0.0, 1.0}}).refusal == "has no syringe or no tool");
}

TEST("every observable has a name and a unit of its own kind") {
  CHECK(name_of(0) == "pressure.peak");
  CHECK(name_of(observable_count - 1) == "force.-2_to_-0.5_mm");
  CHECK(unit_of(0) == "Pa");
  CHECK(unit_of(observable_count - 1) == "N");
  CHECK(unit_of(index_of(Observable::drop_time)) == "s");
  CHECK(unit_of(index_of(Observable::depth_of_loss)) == "m");
}

TEST("the coarser block is as wide, and its duration ends a given time after the motion") {
  Scene scene = three_layers();
  scene.tissue.block = {.nodes = {9, 9}, .spacing = 0.005};
  const Scene coarse = coarser(scene, {.after = 3.0});
  CHECK(coarse.tissue.block.nodes[0] == 3);
  CHECK_NEAR(coarse.tissue.block.spacing * 2.0, 0.005 * 8.0, 1e-15);
  CHECK_NEAR(coarse.simulation.step, 4.0 * scene.simulation.step, 1e-15);
  CHECK_NEAR(coarse.simulation.duration, 0.033 / 0.005 + 3.0, 1e-12);
  scene.tissue.block.nodes = {8, 8};  // no node in the middle
  CHECK(coarser(scene).tissue.block.nodes[0] == 8);
}

TEST("equal parameter values are simulated once, whatever the number of threads") {
  const Scene scene = three_layers();
  for (const int jobs : {1, 3}) {
    std::atomic<int> calls{0};
    Forward forward(scene, parameters_of(scene), jobs, nullptr, [&](const Scene& at) {
      ++calls;
      return lawful(at);
    });
    Forward::Values other = forward.priors();
    other.back() *= 2.0;
    const auto seen = forward.at({forward.priors(), other, forward.priors()});
    CHECK(calls == 2);
    CHECK(forward.simulations() == 2);
    CHECK(seen[0] == seen[2]);
    CHECK(seen[1][1] == 2.0 * seen[0][1]);
  }
}

TEST("parameter values at which the scene fails are named, and a stop ends it") {
  Forward forward(three_layers(), parameters_of(three_layers()), 1, nullptr,
                  [](const Scene&) { return ObservedInsertion{.refusal = "diverges"}; });
  Forward::Values place = forward.priors();
  place[0] = 0.75;
  CHECK_THROWS_AS(std::runtime_error, forward.at(place),
                  "material.firm-fat.cutting_force = 0.75 N diverges");
  const std::atomic<bool> stop{true};
  Forward stopped(three_layers(), parameters_of(three_layers()), 1, &stop, lawful);
  CHECK_THROWS(stopped.at(stopped.priors()), "interrupted");
}

}  // namespace

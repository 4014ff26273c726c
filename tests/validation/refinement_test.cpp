// SPDX-License-Identifier: MIT

#include "validation/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

/// Needle at 5 mm/s: force rises by 1 N/mm up to `punctured` [m], falls to half, rises again at
/// half the rate.
Trace insertion(double punctured, double factor = 1.0) {
  Trace trace{.columns = {{"tool.force_n", "N", {}}, {"tool.insertion_m", "m", {}}}};
  for (int n = 0; n <= 2000; ++n) {
    const double t = 1e-3 * n;
    const double place = 5e-3 * t;
    const double peak = 1e3 * punctured;
    const double force = place < punctured ? 1e3 * place : 0.5 * peak + 0.5e3 * (place - punctured);
    trace.time.push_back(t);
    trace.columns[0].values.push_back(factor * force);
    trace.columns[1].values.push_back(place);
    if (trace.events.empty() && place >= punctured) {
      trace.events.push_back({t, "puncture", "skin"});
    }
  }
  return trace;
}

TEST("a run does not differ from itself, and a force that is 10 % larger differs by 10 %") {
  const Trace run = insertion(4e-3);
  const auto same = difference_of(run, run).value();
  CHECK_NEAR(same.share(), 0.0, 1e-15);  // rounding of the interpolation
  CHECK(same.extra_events == 0);
  CHECK(same.reference == run.values("tool.force_n")[2000]);
  const auto more = difference_of(run, insertion(4e-3, 1.1)).value();
  CHECK_NEAR(more.peak, 0.1, 1e-12);
  CHECK(more.curve > 0.03);  // 0.1 of a root mean square of half the peak
  CHECK(more.curve < 0.1);
}

TEST("a puncture that comes later shows in its depth, and not as a drop of force in between") {
  const auto moved = difference_of(insertion(4e-3), insertion(4.4e-3)).value();
  REQUIRE(moved.events.size() == 1);
  CHECK_NEAR(moved.events[0].place, 4e-3, 5e-6);  // one tick
  CHECK_NEAR(moved.events[0].refined_place.value(), 4.4e-3, 5e-6);
  // Side by side the curves differ by half the force, 2 N of 7, at the drop.
  CHECK(moved.curve < 0.06);
  CHECK(moved.curve > 0.02);
}

TEST("events of one run alone are counted, not matched with others") {
  Trace without = insertion(4e-3);
  without.events = {{0.7, "bone", "spine"}};
  const auto difference = difference_of(insertion(4e-3), without).value();
  REQUIRE(difference.events.size() == 1);
  CHECK(!difference.events[0].refined_place);
  CHECK(difference.extra_events == 1);
}

TEST("without a tool the record that differs most counts, from its own start") {
  Trace run{.time = {0.0, 1.0, 2.0},
            .columns = {{"a.x_m", "m", {5.0, 5.0, 6.0}},
                        {"a.y_m", "m", {0.0, 0.0, 0.0}},
                        {"a.z_m", "m", {0.0, 0.0, 0.0}},
                        {"b.x_m", "m", {0.0, 0.0, 1.0}},
                        {"b.y_m", "m", {0.0, 0.0, 0.0}},
                        {"b.z_m", "m", {0.0, 0.0, 0.0}}}};
  Trace refined = run;
  refined.columns[0].values = {7.0, 7.0, 8.1};
  refined.columns[5].values = {0.0, 0.0, 0.3};
  const auto difference = difference_of(run, refined).value();
  CHECK_NEAR(difference.curve, 0.3, 1e-12);
  CHECK_NEAR(difference.reference, 1.0, 1e-12);
  CHECK(!difference_of(Trace{.time = {0.0, 1.0}}, refined));
}

TEST("on half the spacing loads keep their sum and their centre, and records their point") {
  Scene scene;
  scene.tissue.lattice = uniform_cube(5);
  scene.records = {{"top", 7, {RecordedQuantity::position}}};
  Load face{.force = {0.0, 0.0, 2.0}};
  face.face = Face::z_min;
  scene.loads = {face, {.nodes = {62}, .force = {0.0, 3.0, 0.0}}};
  const SpringNetwork coarse = build_network(scene);
  const std::vector<Load> before = resolve_loads(scene, coarse);
  scene.tissue.lattice.nodes = {9, 9, 9};
  scene.tissue.lattice.spacing *= 0.5;
  const SpringNetwork fine = build_network(scene);
  move_to_finer_nodes(scene, coarse, fine, Eigen::Vector3d::Constant(0.01));
  const int node = record_node(scene.records[0], fine);
  CHECK_NEAR((fine.rest_position.col(node) - coarse.rest_position.col(7)).norm(), 0.0, 1e-15);
  for (std::size_t n = 0; n < before.size(); ++n) {
    const auto moment = [](const Load& load, const SpringNetwork& network) {
      Eigen::Vector4d sum = Eigen::Vector4d::Zero();
      for (const int each : load.nodes) {
        const Eigen::Vector3d place = network.rest_position.col(each);
        sum += load.force.norm() * Eigen::Vector4d(1.0, place.x(), place.y(), place.z());
      }
      return sum;
    };
    CHECK_NEAR((moment(scene.loads[n], fine) - moment(before[n], coarse)).norm(), 0.0, 1e-12);
  }
  // Node 62 is in the middle of the cube: an eighth of its force stays.
  const int middle = record_node({.where = Eigen::Vector3d(coarse.rest_position.col(62))}, fine);
  CHECK(std::ranges::count(scene.loads[1].nodes, middle) == 8);
  CHECK(std::ranges::all_of(scene.loads[0].nodes, [&](int each) {
    return std::abs(fine.rest_position(2, each)) < 1e-12;
  }));
}

}  // namespace PALPATE_FILE

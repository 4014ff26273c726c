// SPDX-License-Identifier: MIT
#include "validation/calibration/forward.hpp"

#include <stdexcept>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

TEST("the coarser block is as wide, and lasts until the needle has stopped for a while") {
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

TEST("a place is simulated once, whatever the number of threads") {
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
    CHECK(calls == 2 && forward.simulations() == 2);
    CHECK(seen[0] == seen[2] && seen[1][1] == 2.0 * seen[0][1]);
  }
}

TEST("a place where the scene fails is named, and a stop ends it") {
  const Scene scene = three_layers();
  Forward forward(scene, parameters_of(scene), 1, nullptr,
                  [](const Scene&) { return ObservedInsertion{.refusal = "diverges"}; });
  Forward::Values place = forward.priors();
  place[0] = 0.75;
  try {
    forward.at(place);
    CHECK(false);
  } catch (const std::runtime_error& problem) {
    CHECK(std::string(problem.what()).find("material.firm-fat.cutting_force = 0.75 N diverges") !=
          std::string::npos);
  }
  const std::atomic<bool> stop{true};
  Forward stopped(scene, parameters_of(scene), 1, &stop, lawful);
  CHECK_THROWS(stopped.at(stopped.priors()), "interrupted");
}

}  // namespace

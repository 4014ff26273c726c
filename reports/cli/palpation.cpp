// SPDX-License-Identifier: MIT
#include "reports/cli/palpation.hpp"

#include "reference/solution.hpp"
#include "reports/markup.hpp"
#include "validation/palpation_map.hpp"

namespace palpate::cli {

namespace {

std::string csv_of(const HeatMap& map) {
  std::string text = "x_m,y_m,stiffness_n_per_m\n";
  std::size_t site = 0;
  for (const double y : map.y) {
    for (const double x : map.x) {
      text += plain_number(1e-3 * x, 17) + "," + plain_number(1e-3 * y, 17) + "," +
              plain_number(1e3 * map.z[site++], 17) + "\n";
    }
  }
  return text;
}

}  // namespace

Palpation palpate_skin(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const auto* problem = dynamic_cast<const NetworkProblem*>(&loaded.simulation.problem());
  if (problem == nullptr || !scene.probe || !scene.probe->map) { return {}; }
  Palpation palpation;
  try {
    HeatMap map = palpation_map(scene, *problem, *scene.probe->map);
    palpation.csv = csv_of(map);
    palpation.figure = {.id = "palpation-map",
                        .title = "Palpation map",
                        .caption = "How stiff the skin is under the probe, place by place: force "
                                   "for each millimetre of a small push on the tissue at rest.",
                        .x = {.label = "x (mm)"},
                        .y = {.label = "y (mm)"},
                        .heat_map = std::move(map),
                        .square = true};
  } catch (const reference::SolverError& e) {
    palpation.warnings.push_back(std::string("no palpation map: ") + e.what());
  }
  return palpation;
}

}  // namespace palpate::cli

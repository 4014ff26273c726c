// SPDX-License-Identifier: MIT
/// A block of three layers under a needle that hardly dents it: the force over the depth is the
/// curve that one sparse factorisation foretells.
#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "reference/quasi_static_insertion.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::tools {

namespace {

constexpr double spacing = 0.004;
constexpr double peak = 0.01;  // [N]; dents of some 60 um
constexpr double path = 0.014;  // [m]

Scene layered_block(double speed) {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {7, 7}, .spacing = spacing, .connectivity = 26};
  scene.tissue.fixed = {Face::z_max};
  scene.materials = {tissue_of("skin", 60e3, 0.5 * peak, 0.0), tissue_of("fat", 15e3, 0.25 * peak, 0.0),
                     tissue_of("ligament", 100e3, peak, 0.0)};
  scene.tissue.layers = {
      {"skin", "skin", 0.004}, {"fat", "fat", 0.0062}, {"ligament", "ligament", 0.0078}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = speed};
  scene.simulation = {.duration = path / speed, .step = 1e-6 / speed};  // 1 um of path a tick
  return scene;
}

/// Where the reference drops at once the run falls within a few ticks, and rings for a while.
bool beside_a_drop(const std::vector<reference::ForceDepthVertex>& curve, double place) {
  constexpr double rest = 3e-4;  // [m]
  for (std::size_t n = 1; n < curve.size(); ++n) {
    const bool drop = curve[n].force < curve[n - 1].force;
    if (drop && place >= curve[n - 1].place - 1e-5 && place < curve[n].place + rest) { return true; }
  }
  return false;
}

void measure_curve(const CaseContext& context, Outcome& outcome) {
  const double speed = 2e-3;
  const Scene scene = layered_block(speed);
  const SpringNetwork network = build_network(scene);
  const Insertion fast = insert_tool(context, scene);
  const Insertion slow = insert_tool(context, layered_block(0.5 * speed));
  const auto curve_of = reference::force_depth_curve(scene, network, path);
  const double compliance = reference::static_compliance(scene, network, 0.0);
  const double dent = peak * compliance;
  const std::size_t samples = std::min(fast.tool.size(), slow.tool.size());
  double worst = samples == 0 ? std::nan("") : 0.0;
  std::vector<double> depth, measured, foretold;
  for (std::size_t n = 0; n < samples; ++n) {
    const double place = slow.tool[n].place;
    const double truth = reference::force_at(curve_of, place);
    const double limit = 2.0 * slow.tool[n].forces.total - fast.tool[n].forces.total;
    depth.push_back(1e3 * place);
    measured.push_back(1e3 * slow.tool[n].forces.total);
    foretold.push_back(1e3 * truth);
    if (beside_a_drop(curve_of, place)) { continue; }
    const double error = std::abs(limit - truth) / peak;
    worst = std::isnan(error) || std::isnan(worst) ? std::nan("") : std::max(worst, error);
  }
  outcome.judge({.name = "largest_error_over_peak",
                 .value = worst,
                 .upper = 4.0 * dent / spacing,
                 .bound_from = "theory: the reference is linear and a dent strains the springs "
                               "beneath it by dent over spacing, fourfold for their turning; "
                               "dampers taken out by extrapolating two speeds"});
  outcome.judge({.name = "punctures",
                 .value = static_cast<double>(slow.count("puncture")),
                 .lower = 3.0,
                 .upper = 3.0,
                 .bound_from = "one for each layer"});
  Figure figure{.id = "static-curve",
                .title = "Force over depth of a block",
                .caption = "Three layers of springs under a slow needle, and the curve of static "
                           "compliances.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (mN)"}};
  figure.series.push_back(curve("1 mm/s", depth, measured));
  figure.series.push_back(curve("one sparse solve", depth, foretold, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> static_cases() {
  return {{.name = "needle/static-curve",
           .suite = "accuracy",
           .claim = "Under a slow needle a block of layers answers with the force that its static "
                    "compliance foretells.",
           .measure = measure_curve,
           .weight = 2.0}};
}

}  // namespace palpate::tools

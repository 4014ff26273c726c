// SPDX-License-Identifier: MIT
/// The paper's Fig. 12: a block is sheared and let go. What of the shear is left once it has come
/// to rest tells whether the lattice resists shear at all.

#include <cmath>

#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;

constexpr double shear = 0.1;  ///< initial, tan of the angle

Block skewed_block(const CaseContext& context, int connectivity) {
  const int n = context.quick ? 5 : 7;
  // Slow modes overdamped: columns must not be pushed together, where they would buckle.
  return {.nodes = {n, n, n}, .connectivity = connectivity, .relaxation = 0.02};
}

/// Held at z-max, sheared along x by a straight line in depth.
SpringNetwork skewed_network(const Block& block) {
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  const double height = block.spacing * (block.nodes[2] - 1);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement.row(0) =
      shear * (height - network.rest_position.row(2).array()).matrix();
  return network;
}

/// Mean displacement along x of the released face over the height.
std::vector<double> shear_over_time(const Block& block, const SpringNetwork& network,
                                    const Motion& motion) {
  const NetworkProblem problem(network);
  const int face = block.nodes[0] * block.nodes[1];
  const double height = block.spacing * (block.nodes[2] - 1);
  std::vector<double> values;
  for (Index n = 0; n < motion.position.cols(); ++n) {
    double sum = 0.0;
    for (int node = 0; node < face; ++node) {
      sum += motion.position(problem.coordinate(node), n) - network.rest_position(0, node);
    }
    values.push_back(sum / (face * height));
  }
  return values;
}

/// Nodes of the middle slice in the plane of the shear, at one sample.
Series slice(const Block& block, const SpringNetwork& network, const Motion& motion, Index sample,
             const std::string& label) {
  const NetworkProblem problem(network);
  Series points{.label = label, .style = Series::Style::points};
  for (int l = 0; l < block.nodes[2]; ++l) {
    for (int i = 0; i < block.nodes[0]; ++i) {
      const int node = block.shape().index(i, block.nodes[1] / 2, l);
      const Index c = problem.coordinate(node);
      const NodeVectors start = network.initial_position();
      points.x.push_back(1e3 * (c < 0 ? start(0, node) : motion.position(c, sample)));
      points.y.push_back(1e3 * (c < 0 ? start(2, node) : motion.position(c + 2, sample)));
    }
  }
  return points;
}

/// Where theory says that the block comes to rest. Without shear stiffness each column keeps the
/// direction that it was given and shortens to its rest length along it.
Eigen::VectorXd final_position(const Block& block, const SpringNetwork& network) {
  const NetworkProblem problem(network);
  const double height = block.spacing * (block.nodes[2] - 1);
  const double shorter = 1.0 / std::sqrt(1.0 + shear * shear);
  Eigen::VectorXd place(problem.dof());
  for (const int node : problem.free_nodes()) {
    Eigen::Vector3d x = network.rest_position.col(node);
    if (block.connectivity == 6) {
      const double above = height - x.z();
      x += Eigen::Vector3d(shear * shorter * above, 0.0, (1.0 - shorter) * above);
    }
    place.segment<3>(problem.coordinate(node)) = x;
  }
  return place;
}

void judge_residual(int connectivity, double residual, double away, Outcome& outcome) {
  const double expected = connectivity == 6 ? 1.0 / std::sqrt(1.0 + shear * shear) : 0.0;
  outcome.judge({.name = "residual_over_initial_shear",
                 .value = residual,
                 .lower = expected - 1e-6,
                 .upper = expected + 1e-6,
                 .bound_from = connectivity == 6
                                   ? "theory: columns shorten to their rest length along the "
                                     "direction they were given, so 1/sqrt(1 + shear^2) stays"
                                   : "theory: C44 > 0, so every mode decays; 40 relaxation times"});
  outcome.judge({.name = "furthest_node_from_theory",
                 .value = away,
                 .unit = "m",
                 .upper = 2e-9,
                 .bound_from = "1e-6 of the smallest block's initial displacement of 2 mm"});
}

void measure(const CaseContext& context, int connectivity, Outcome& outcome) {
  const Block block = skewed_block(context, connectivity);
  const SpringNetwork network = skewed_network(block);
  Scene scene = scene_of("velocity-verlet", 5e-3, context.quick ? 0.8 : 1.6);
  scene.simulation.substeps.reset();
  const Motion motion = simulate(context, scene, &network);
  const std::vector<double> values = shear_over_time(block, network, motion);
  const double away = largest_of(motion.position.rightCols<1>() - final_position(block, network));
  judge_residual(connectivity, values.back() / shear, away, outcome);
  outcome.judge({.name = "diverged",
                 .value = motion.diverged ? 1.0 : 0.0,
                 .upper = 0.0,
                 .bound_from = "steps below the stability limit"});
  Figure figure{
      .id = "shear",
      .title = "Shear of a released block, " + std::to_string(connectivity) + " neighbours",
      .caption = connectivity == 6
                     ? "Lattices of 6 neighbours have no shear stiffness: the skewed block "
                       "stays skewed."
                     : "The released block comes back to its shape.",
      .x = {.label = "time (s)"},
      .y = {.label = "shear (1)"}};
  figure.series.push_back(line("mean shear of the released face", motion.time, values));
  figure.series.push_back(
      line("initial", {0.0, motion.time.back()}, {shear, shear}, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
  Figure shape{.id = "slice",
               .title = "Middle slice before and after",
               .caption = "Nodes of the middle slice when the block is let go and when it rests.",
               .x = {.label = "x (mm)"},
               .y = {.label = "z (mm)"},
               .square = true};
  shape.series.push_back(slice(block, network, motion, 0, "let go"));
  shape.series.push_back(slice(block, network, motion, motion.position.cols() - 1, "at rest"));
  outcome.figures.push_back(std::move(shape));
}

Case skew_case(int connectivity) {
  const std::string neighbours = std::to_string(connectivity);
  return {
      .name = "network/skew/" + neighbours,
      .suite = "accuracy",
      .claim = connectivity == 6
                   ? "A sheared block of 6-neighbour springs keeps its shear: 6 neighbours have "
                     "no shear stiffness."
                   : "A sheared block of " + neighbours +
                         "-neighbour springs comes back to its "
                         "shape.",
      .measure = [connectivity](const CaseContext& context,
                                Outcome& outcome) { measure(context, connectivity, outcome); },
      .weight = 1.0};
}

}  // namespace

std::vector<Case> skew_cases() { return {skew_case(6), skew_case(18), skew_case(26)}; }

}  // namespace palpate::networks

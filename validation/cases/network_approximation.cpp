// SPDX-License-Identifier: MIT
/// Approximations that a scene may ask for, and work that it may save: heavy nodes instead of fixed
/// ones, single precision, skipping.

#include <algorithm>
#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/integrator.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;

/// A cube pulled at the middle of its face, as a scene that builds its own network.
Scene pulled_cube(int nodes, const std::string& scheme, double step, double duration) {
  Scene scene = scene_of(scheme, step, duration);
  scene.tissue.source = Source::lattice;
  scene.tissue.fixed = std::vector{Face::z_min};
  scene.tissue.lattice = {.nodes = {nodes, nodes, nodes},
                          .spacing = 0.01,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.05,
                          .node_mass = 1e-3};
  scene.loads = {
      {.nodes = {((nodes - 1) * nodes + nodes / 2) * nodes + nodes / 2}, .force = {0.0, 0.0, 0.1}}};
  return scene;
}

/// Largest motion of the nodes of the held face [m].
double face_drift(const Scene& scene, const Motion& motion) {
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network);
  double drift = motion.diverged || !motion.position.allFinite() ? std::nan("") : 0.0;
  for (const int node : face_nodes(network.rest_position, Face::z_min)) {
    for (Index n = 0; n < motion.position.cols(); ++n) {
      const Eigen::Vector3d away = motion.position.col(n).segment<3>(problem.coordinate(node)) -
                                   network.rest_position.col(node);
      drift = worse(drift, largest_of(away));
    }
  }
  return drift;
}

/// |M (centre of mass - its start) - F t^2 / 2| over F t^2 / 2 at the end: a body held by mass is
/// free, and Verlet is exact for a constant force.
double centre_error(const Scene& scene, const Motion& motion, double& rounding) {
  const SpringNetwork network = build_network(scene);
  const Eigen::VectorXd mass = NetworkProblem(network).mass();
  const Eigen::VectorXd moved = motion.position.rightCols<1>() - motion.position.col(0);
  double along = 0.0;
  for (Index i = 2; i < moved.size(); i += 3) { along += mass(i) * moved(i); }
  const double time = scene.simulation.duration;
  const double expected = 0.5 * scene.loads.front().force.z() * time * time;
  rounding = static_cast<double>(motion.steps) * epsilon * network.mass.sum() *
             network.rest_position.cwiseAbs().maxCoeff() / expected;
  return std::abs(along / expected - 1.0);
}

void measure_heavy(const CaseContext& context, Outcome& outcome) {
  std::vector<double> factors;
  std::vector<double> drifts;
  std::vector<double> inverse;
  double excess = 0.0;
  for (double factor = 1e2; factor < 2e8; factor *= 10.0) {
    Scene scene = pulled_cube(5, "velocity-verlet", 1e-3, 0.05);
    scene.tissue.hold_by_mass = true;
    scene.tissue.heavy_mass_factor = factor;
    const Motion motion = simulate(context, scene);
    factors.push_back(factor);
    inverse.push_back(1.0 / factor);
    drifts.push_back(face_drift(scene, motion));
    double rounding = 0.0;
    const double error = centre_error(scene, motion, rounding);
    excess = worse(excess, error / rounding);
  }
  const ObservedOrder slope = observed_order(inverse, drifts, 0.0, unbounded);
  outcome.judge({.name = "slope_of_drift_over_factor",
                 .value = -slope.slope,
                 .lower = -1.02,
                 .upper = -0.98,
                 .bound_from = "theory: the same reaction on a heavier node; at the lightest of "
                               "seven factors the neighbours' springs pull it back"});
  outcome.judge({.name = "centre_of_mass_error_over_rounding",
                 .value = excess,
                 .upper = 1.0,
                 .bound_from = "theory: the whole moves by F t^2 / (2 M); one rounding of every "
                               "position a step"});
  Figure figure{.id = "drift",
                .title = "Drift of nodes that are held by mass",
                .caption =
                    "A heavy node is not a fixed one: its drift in 50 ms falls as one over "
                    "its mass and never ends.",
                .x = {.label = "mass factor (1)", .logarithmic = true},
                .y = {.label = "largest drift (m)", .logarithmic = true}};
  figure.series.push_back(line("held by mass", factors, drifts, Series::Style::line_and_points));
  outcome.figures.push_back(std::move(figure));
}

void measure_float(const CaseContext& context, Outcome& outcome) {
  constexpr double half_unit = 0x1p-24;
  for (const char* scheme : {"euler-cromer", "velocity-verlet", "rk4"}) {
    Scene scene = pulled_cube(10, scheme, 1e-3, context.quick ? 0.05 : 0.1);
    scene.loads.front().nodes = {955};
    const Motion in_double = simulate(context, scene);
    scene.simulation.precision = Precision::single_precision;
    const Motion in_float = simulate(context, scene);
    const SpringNetwork network = build_network(scene);
    const Eigen::VectorXd start = NetworkProblem(network).initial_position();
    const TrajectoryError error = trajectory_error(in_float.position, in_double.position, start);
    const double reach = network.rest_position.cwiseAbs().maxCoeff();
    const auto steps = static_cast<double>(in_double.steps);
    outcome.judge({.name = std::string("largest_error_") + scheme,
                   .value = error.maximum,
                   .upper = steps * half_unit * reach / error.peak,
                   .bound_from = "every step rounds each position by at most 2^-24 of the cube's "
                                 "extent, and damped motion does not amplify it"});
    outcome.judge({.name = std::string("rms_error_") + scheme,
                   .value = error.l2,
                   .upper = steps * half_unit * reach / error.peak,
                   .bound_from = "the same"});
    outcome.quantities.push_back({.name = std::string("one_rounding_over_peak_") + scheme,
                                  .value = half_unit * reach / error.peak});
  }
}

/// Values that differ, or all of them when the shapes do.
double differing_values(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) { return unbounded; }
  return static_cast<double>((a.array() != b.array()).count());
}

struct SkipScene {
  const char* name;
  Scene scene;
  SpringNetwork network;
};

std::vector<SkipScene> skip_scenes(bool quick) {
  const auto made = [](const char* name, double relaxation, bool held, bool gravity) {
    SkipScene one{.name = name,
                  .scene = scene_of("auto", 2e-4, 8e-3),
                  .network = block_network({.nodes = {4, 4, 5}, .relaxation = relaxation})};
    if (held) { hold(one.network, Face::z_max); }
    displace(one.network, 5e-4, 41);
    if (gravity) { one.scene.tissue.gravity = {0.0, 0.0, 9.81}; }
    one.scene.loads = {{.nodes = {0, 5}, .force = {1e-3, 0.0, 2e-3}, .end = 4e-3}};
    return one;
  };
  std::vector<SkipScene> scenes{made("undamped", 0.0, true, false),
                                made("damped_with_weight", 1e-3, true, true)};
  if (!quick) {
    scenes.push_back(made("damped", 1e-3, true, false));
    scenes.push_back(made("free_and_undamped", 0.0, false, false));
  }
  return scenes;
}

void measure_skip(const CaseContext& context, Outcome& outcome) {
  CaseContext skipping = context;
  CaseContext computing = context;
  skipping.skip = true;
  computing.skip = false;
  for (SkipScene& one : skip_scenes(context.quick)) {
    double differing = 0.0;
    for (const IntegratorInfo* scheme : integrators()) {
      for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
        one.scene.simulation.integrator = std::string(scheme->name);
        one.scene.simulation.precision = precision;
        const Wanted wanted{.velocity = true, .energy = true};
        const Motion a = simulate(skipping, one.scene, &one.network, wanted);
        const Motion b = simulate(computing, one.scene, &one.network, wanted);
        differing = worse(differing, differing_values(a.position, b.position));
        differing = worse(differing, differing_values(a.velocity, b.velocity));
        differing = worse(differing, a.diverged || b.diverged ? std::nan("") : 0.0);
      }
    }
    outcome.judge({.name = std::string("differing_values_") + one.name,
                   .value = differing,
                   .upper = 0.0,
                   .bound_from = "skipped work adds nothing: the same bits"});
  }
  outcome.notes.push_back("Every scheme, in both precisions, with and without skipping.");
}

}  // namespace

std::vector<Case> approximation_cases() {
  return {{.name = "network/heavy-nodes",
           .suite = "accuracy",
           .claim = "Nodes held by mass drift in inverse proportion to it.",
           .measure = measure_heavy,
           .weight = 0.3},
          {.name = "network/float",
           .suite = "accuracy",
           .claim = "Single precision adds no more than the rounding of positions.",
           .measure = measure_float,
           .weight = 0.5},
          {.name = "network/skip",
           .suite = "accuracy",
           .claim = "Skipping what a scene does not need changes no bit of its motion.",
           .measure = measure_skip,
           .weight = 0.5}};
}

}  // namespace palpate::networks

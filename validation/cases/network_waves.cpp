// SPDX-License-Identifier: MIT
/// Frequencies of chains and bars against closed forms: of the assembled matrices, and measured
/// from motions.

#include <cmath>
#include <complex>
#include <numbers>

#include "model/dynamics/network_builder.hpp"
#include "reference/dense_modes.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double pi = std::numbers::pi;

/// omega of a sampled undamped mode: least squares of x(n+1) + x(n-1) = 2 cos(omega dt) x(n).
double identify_frequency(const VectorXd& x, double dt) {
  const Index n = x.size() - 2;
  if (n < 1 || !x.allFinite()) { return std::nan(""); }
  const VectorXd middle = x.segment(1, n);
  const VectorXd sides = x.head(n) + x.tail(n);
  return std::acos(0.5 * middle.dot(sides) / middle.squaredNorm()) / dt;
}

/// What classical RK4 makes of omega: the argument of its amplification factor.
double rk4_frequency(double omega, double h) {
  const std::complex<double> z(0.0, omega * h);
  return std::arg(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))) / h;
}

/// One mode started alone: `shape` [m] on the z coordinates, followed by RK4 over ten radians.
struct ModeRun {
  double measured = 0.0;  ///< [rad/s]
  double expected = 0.0;  ///< of RK4 with its h [rad/s]
};

ModeRun run_mode(const CaseContext& context, SpringNetwork network, const VectorXd& shape,
                 double omega) {
  constexpr double phase_per_sample = 0.25;
  const double sample = phase_per_sample / omega;
  // Fine enough for RK4 to lose no amplitude that the fit would see.
  constexpr int substeps = 25;
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement.row(2) = shape.transpose();
  const Motion motion =
      simulate(context, scene_of("rk4", sample, 40.0 * sample, substeps), &network);
  const NetworkProblem problem(network);
  VectorXd weights = VectorXd::Zero(problem.dof());
  for (const int node : problem.free_nodes()) {
    weights(problem.coordinate(node) + 2) = shape(node) * network.mass(node);
  }
  VectorXd rest(problem.dof());
  for (const int node : problem.free_nodes()) {
    rest.segment<3>(problem.coordinate(node)) = network.rest_position.col(node);
  }
  const VectorXd x = (motion.position.colwise() - rest).transpose() * weights;
  return {identify_frequency(x, sample), rk4_frequency(omega, sample / substeps)};
}

SpringNetwork chain_of(int masses, double stiffness, double mass, double spacing) {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, masses + 1);
  for (int i = 0; i <= masses; ++i) { network.rest_position(2, i) = spacing * i; }
  network.mass = VectorXd::Constant(masses + 1, mass);
  network.fixed.assign(static_cast<std::size_t>(masses) + 1, 0);
  network.fixed.front() = 1;
  for (int i = 0; i < masses; ++i) {
    network.springs.push_back({i, i + 1, stiffness, 0.0, spacing});
  }
  return network;
}

double chain_frequency(int j, int masses, double stiffness, double mass) {
  return 2.0 * std::sqrt(stiffness / mass) *
         std::sin((2.0 * j - 1.0) * pi / (2.0 * (2.0 * masses + 1.0)));
}

/// Eigenfrequencies of the coordinates along z alone, ascending [rad/s].
VectorXd frequencies_along_z(const NetworkProblem& problem) {
  std::vector<Index> along;
  for (Index i = 2; i < problem.dof(); i += 3) { along.push_back(i); }
  const MatrixXd stiffness = MatrixXd(stiffness_of(problem))(along, along);
  const VectorXd scale = VectorXd(problem.mass()(along)).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * stiffness * scale.asDiagonal();
  return reference::symmetric_eigenvalues(scaled)
      .cwiseMax(0.0)
      .cwiseSqrt();
}

struct ChainErrors {
  double matrix = 0.0;  ///< of the assembled frequencies
  double motion = 0.0;  ///< of those measured from motions
  double scheme = 0.0;  ///< of those against RK4's own
};

constexpr int chain_masses = 20;

ChainErrors compare_chain(const CaseContext& context, Series& formula, Series& points) {
  constexpr double stiffness = 80.0;  // [N/m]
  constexpr double mass = 2e-3;       // [kg]
  constexpr double spacing = 0.01;    // [m]
  const SpringNetwork network = chain_of(chain_masses, stiffness, mass, spacing);
  const VectorXd assembled = frequencies_along_z(NetworkProblem(candidate(context, network)));
  ChainErrors errors;
  for (int j = 1; j <= chain_masses; ++j) {
    const double omega = chain_frequency(j, chain_masses, stiffness, mass);
    VectorXd shape(chain_masses + 1);
    for (int i = 0; i <= chain_masses; ++i) {
      shape(i) = 1e-4 * std::sin((2.0 * j - 1.0) * pi * i / (2.0 * chain_masses + 1.0));
    }
    const ModeRun run = run_mode(context, network, shape, omega);
    errors.matrix = worse(errors.matrix, std::abs(assembled(j - 1) / omega - 1.0));
    errors.scheme = worse(errors.scheme, std::abs(run.measured / run.expected - 1.0));
    errors.motion = worse(errors.motion, std::abs(run.measured / omega - 1.0));
    formula.x.push_back(j);
    formula.y.push_back(omega);
    points.x.push_back(j);
    points.y.push_back(run.measured);
  }
  return errors;
}

void measure_chain(const CaseContext& context, Outcome& outcome) {
  Series formula{.label = "2 sqrt(k/m) sin((2j-1) pi / (2(2N+1)))"};
  Series points{.label = "measured from motion", .style = Series::Style::points};
  const ChainErrors errors = compare_chain(context, formula, points);
  outcome.judge({.name = "assembled_frequency_error",
                 .value = errors.matrix,
                 .upper = 1e-12,
                 .bound_from = "theory; rounding of the eigenvalues times their spread of 700"});
  outcome.judge({.name = "measured_frequency_error",
                 .value = errors.motion,
                 .upper = 1.01 * 1e-8 / 120.0 + 1e-11,
                 .bound_from = "theory: (omega h)^4 / 120 of RK4, and the rounding of the fit"});
  outcome.judge({.name = "measured_minus_rk4_frequency",
                 .value = errors.scheme,
                 .upper = 1e-11,
                 .bound_from = "discrete theory of RK4; rounding of positions over displacements, "
                               "3e-13 a sample, over the squared phase between samples"});
  outcome.figures.push_back({.id = "frequencies",
                             .title = "Natural frequencies of a fixed-free chain of 20 masses",
                             .caption = "Frequencies measured from single modes followed by RK4 "
                                        "lie on the closed form of the chain.",
                             .x = {.label = "mode j"},
                             .y = {.label = "angular frequency (rad/s)"},
                             .series = {std::move(formula), std::move(points)}});
}

/// Modes that move whole planes of a bar along it, sides held on rollers: free-free with half
/// masses at both ends, so q a = j pi / cells exactly.
struct Bar {
  Block block{};
  double speed = 0.0;  ///< sqrt(C11 / density) [m/s]
  int cells = 0;

  [[nodiscard]] double wave_number(int j) const { return j * pi / (cells * block.spacing); }
  [[nodiscard]] double omega(int j) const {
    return 2.0 / block.spacing * speed * std::sin(0.5 * wave_number(j) * block.spacing);
  }
};

Bar bar_of(int connectivity, int cells) {
  Bar bar{.block = {.nodes = {3, 3, cells + 1}, .connectivity = connectivity}, .cells = cells};
  const BondStiffness k = bond_stiffness(bar.block.youngs_modulus, bar.block.spacing, connectivity);
  const double c11 =
      (k.edge + 2.0 * k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / bar.block.spacing;
  bar.speed = std::sqrt(c11 / bar.block.density);
  return bar;
}

VectorXd plane_wave(const Bar& bar, const SpringNetwork& network, int j, double amplitude) {
  return amplitude * (bar.wave_number(j) * network.rest_position.row(2).array()).cos();
}

/// Rayleigh quotient and residual of the plane wave in the assembled matrices.
double assembled_error(const Bar& bar, const SpringNetwork& network, int j, Series& points) {
  const NetworkProblem problem(network);
  const VectorXd shape = plane_wave(bar, network, j, 1.0);
  VectorXd u = VectorXd::Zero(problem.dof());
  for (Index i = 0; i < shape.size(); ++i) { u(3 * i + 2) = shape(i); }
  VectorXd force = stiffness_of(problem) * u;
  VectorXd along(shape.size());
  for (Index i = 0; i < shape.size(); ++i) { along(i) = force(3 * i + 2); }
  const VectorXd inertia = network.mass.cwiseProduct(shape);
  const double omega = std::sqrt(shape.dot(along) / shape.dot(inertia));
  points.x.push_back(bar.wave_number(j) * bar.block.spacing / pi);
  points.y.push_back(omega * bar.block.spacing / bar.speed);
  const double residual =
      largest_of(along - omega * omega * inertia) / largest_of(omega * omega * inertia);
  return worse(std::abs(omega / bar.omega(j) - 1.0), residual);
}

constexpr int bar_cells = 24;

void judge_assembled(const CaseContext& context, int connectivity, Figure& figure,
                     Outcome& outcome) {
  const Bar bar = bar_of(connectivity, bar_cells);
  const SpringNetwork network = candidate(context, block_network(bar.block));
  Series points{.label = std::to_string(connectivity) + " neighbours, assembled",
                .style = Series::Style::points};
  double error = 0.0;
  for (int j = 1; j <= bar_cells; ++j) {
    error = worse(error, assembled_error(bar, network, j, points));
  }
  outcome.judge({.name = "assembled_error_" + std::to_string(connectivity),
                 .value = error,
                 .upper = 1e-11,
                 .bound_from = "theory; rounding of forces that cancel by (q a)^2 = 0.02"});
  figure.series.push_back(std::move(points));
}

/// With 6 neighbours a plane wave needs no rollers: it can be followed in motion.
void judge_motion(const CaseContext& context, Figure& figure, Outcome& outcome) {
  const Bar bar = bar_of(6, bar_cells);
  const SpringNetwork network = block_network(bar.block);
  Series measured{.label = "6 neighbours, from motion", .style = Series::Style::points};
  double error = 0.0;
  for (int j = 1; j <= bar_cells; j += context.quick ? 6 : 3) {
    const VectorXd shape = plane_wave(bar, network, j, 1e-3 * bar.block.spacing);
    const ModeRun run = run_mode(context, network, shape, bar.omega(j));
    error = worse(error, std::abs(run.measured / run.expected - 1.0));
    measured.x.push_back(bar.wave_number(j) * bar.block.spacing / pi);
    measured.y.push_back(run.measured * bar.block.spacing / bar.speed);
  }
  outcome.judge({.name = "motion_error_6",
                 .value = error,
                 .upper = 1e-10,
                 .bound_from = "discrete theory of RK4; rounding of positions over displacements, "
                               "1e-12 a sample, over the squared phase between samples"});
  figure.series.push_back(std::move(measured));
}

void measure_dispersion(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "dispersion",
                .title = "Longitudinal waves along an axis of the lattice",
                .caption =
                    "Frequencies of plane waves, from the assembled matrices (sides on "
                    "rollers) and from motions, on the lattice dispersion; the dashed line "
                    "is the continuum.",
                .x = {.label = "q a / pi"},
                .y = {.label = "omega a / c"}};
  Series curve{.label = "2 sin(q a / 2)"};
  for (int n = 0; n <= 60; ++n) {
    curve.x.push_back(n / 60.0);
    curve.y.push_back(2.0 * std::sin(n * pi / 120.0));
  }
  figure.series.push_back(std::move(curve));
  figure.series.push_back(line("continuum", {0.0, 0.7}, {0.0, 0.7 * pi}, Series::Style::dashed));
  for (const int connectivity : {6, 18, 26}) {
    judge_assembled(context, connectivity, figure, outcome);
  }
  judge_motion(context, figure, outcome);
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> wave_cases() {
  return {{.name = "network/chain-frequencies",
           .suite = "accuracy",
           .claim = "A fixed-free chain of equal masses has its closed-form frequencies, in its "
                    "assembled stiffness and in its motion.",
           .measure = measure_chain,
           .weight = 0.3},
          {.name = "network/dispersion",
           .suite = "accuracy",
           .claim = "Plane longitudinal waves along an axis follow omega = (2/a) sqrt(C11/rho) "
                    "sin(q a / 2).",
           .measure = measure_dispersion,
           .weight = 0.5}};
}

}  // namespace palpate::networks

// SPDX-License-Identifier: MIT
/// Comparison of the lattice at rest with a cubic elastic solid: assembled stiffness under uniform
/// traction and under affine boundary displacement, and homogenised moduli.

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <complex>
#include <limits>
#include <numbers>

#include "reference/exact_problems.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct CubicModuli {
  double c11 = 0.0;  ///< [Pa]
  double c12 = 0.0;
  double c44 = 0.0;

  [[nodiscard]] double youngs() const { return (c11 - c12) * (c11 + 2.0 * c12) / (c11 + c12); }
  [[nodiscard]] double poisson() const { return c12 / (c11 + c12); }
};

/// Number of axes that a spring spans: 1 edge, 2 face diagonal, 3 body diagonal.
int kind_of(const SpringNetwork& network, const Spring& spring, double spacing) {
  const Eigen::Vector3d d =
      network.rest_position.col(spring.b) - network.rest_position.col(spring.a);
  return static_cast<int>((d.array().abs() > 0.5 * spacing).count());
}

CubicModuli formula(const BondStiffness& k, double spacing) {
  const double shear = (k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / spacing;
  return {(k.edge + 2.0 * k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / spacing, shear, shear};
}

/// K u = f with some coordinates prescribed; `displacement` holds those and receives the rest.
void solve_static(const MatrixXd& stiffness, const VectorXd& force, const std::vector<bool>& held,
                  VectorXd& displacement) {
  std::vector<Index> free;
  std::vector<Index> fixed;
  for (Index i = 0; i < displacement.size(); ++i) {
    (held[static_cast<std::size_t>(i)] ? fixed : free).push_back(i);
  }
  const MatrixXd among_free = stiffness(free, free);
  const VectorXd right = force(free) - stiffness(free, fixed) * displacement(fixed);
  const Eigen::LDLT<MatrixXd> factor(among_free);
  VectorXd solution = factor.solve(right);
  solution += factor.solve(right - among_free * solution);
  displacement(free) = solution;
}

struct Measured {
  double youngs = 0.0;
  double poisson = 0.0;
  double not_affine = 0.0;  ///< largest distance from a homogeneous strain over the largest motion
  CubicModuli moduli{};
  VectorXd traction_displacement{};
};

/// Uniform traction along z on rollers; nodal shares of a face are 1, 1/2 and 1/4.
void pull_on_rollers(const Block& block, const MatrixXd& stiffness, const NodeVectors& rest,
                     Measured& measured) {
  const LatticeShape shape = block.shape();
  constexpr double traction = 1.0;  // [Pa]
  VectorXd force = VectorXd::Zero(stiffness.rows());
  std::vector<bool> held(static_cast<std::size_t>(stiffness.rows()), false);
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for (int j = 0; j < shape.nodes[1]; ++j) {
      for (int i = 0; i < shape.nodes[0]; ++i) {
        const auto first = static_cast<std::size_t>(3 * shape.index(i, j, l));
        held[first] = i == 0;
        held[first + 1] = j == 0;
        held[first + 2] = l == 0;
        const bool edge_x = i == 0 || i + 1 == shape.nodes[0];
        const bool edge_y = j == 0 || j + 1 == shape.nodes[1];
        if (l + 1 != shape.nodes[2]) { continue; }
        force(static_cast<Index>(first + 2)) =
            traction * shape.spacing * shape.spacing * (edge_x ? 0.5 : 1.0) * (edge_y ? 0.5 : 1.0);
      }
    }
  }
  VectorXd u = VectorXd::Zero(stiffness.rows());
  solve_static(stiffness, force, held, u);
  // The far corner gives the homogeneous strain that every node is compared with.
  const Eigen::Vector3d extent = rest.rightCols<1>() - rest.col(0);
  const Eigen::Vector3d strain = u.tail<3>().cwiseQuotient(extent);
  measured.youngs = traction / strain.z();
  measured.poisson = -0.5 * (strain.x() + strain.y()) / strain.z();
  NodeVectors affine = strain.asDiagonal() * (rest.colwise() - rest.col(0));
  const double away = largest_of(u - affine.reshaped());
  measured.not_affine = away / largest_of(u);
  measured.traction_displacement = u;
}

/// Mean stress of a body whose boundary moves by x -> strain x: sum of x (outer) reaction / volume.
Matrix3d mean_stress(const Block& block, const MatrixXd& stiffness, const NodeVectors& rest,
                     const Matrix3d& strain) {
  const LatticeShape shape = block.shape();
  const NodeVectors target = strain * rest;
  VectorXd u = target.reshaped();
  std::vector<bool> held(static_cast<std::size_t>(u.size()), true);
  for (int l = 1; l + 1 < shape.nodes[2]; ++l) {
    for (int j = 1; j + 1 < shape.nodes[1]; ++j) {
      for (int i = 1; i + 1 < shape.nodes[0]; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          held[static_cast<std::size_t>(3 * shape.index(i, j, l) + axis)] = false;
        }
      }
    }
  }
  solve_static(stiffness, VectorXd::Zero(u.size()), held, u);
  const VectorXd reaction = stiffness * u;
  const double volume = std::pow(shape.spacing, 3) * (shape.nodes[0] - 1) * (shape.nodes[1] - 1) *
                        (shape.nodes[2] - 1);
  return rest * reaction.reshaped(3, rest.cols()).transpose() / volume;
}

Measured measure_moduli(const Block& block, const SpringNetwork& network) {
  const NetworkProblem problem(network);
  const MatrixXd stiffness = stiffness_of(problem);
  Measured measured;
  pull_on_rollers(block, stiffness, network.rest_position, measured);
  Matrix3d strain = Matrix3d::Zero();
  strain(0, 0) = 1.0;
  const Matrix3d stretched = mean_stress(block, stiffness, network.rest_position, strain);
  strain(0, 0) = 0.0;
  strain(0, 1) = 1.0;
  const Matrix3d sheared = mean_stress(block, stiffness, network.rest_position, strain);
  measured.moduli = {stretched(0, 0), stretched(1, 1), sheared(0, 1)};
  return measured;
}

/// Rounding of one solve with a condition number below 1e4, refined once.
constexpr double rounding = 1e-12;

void patch(const CaseContext& context, int connectivity, Outcome& outcome, Table& table,
           Figure& figure) {
  const std::string tag = std::to_string(connectivity);
  const Block block{.nodes = {5, 4, 6}, .connectivity = connectivity};
  const SpringNetwork network = candidate(context, block_network(block));
  const BondStiffness bonds = bond_stiffness(block.youngs_modulus, block.spacing, connectivity);
  const CubicModuli expected = formula(bonds, block.spacing);
  const Measured measured = measure_moduli(block, network);
  const double scale = block.youngs_modulus;
  const std::string theory = "homogenised lattice; rounding of a refined solve";
  const auto judge = [&](const std::string& name, double error) {
    outcome.judge_at_most(name + "_" + tag, std::abs(error), rounding, theory);
  };
  judge("youngs_error", measured.youngs / scale - 1.0);
  judge("poisson_error", measured.poisson - (connectivity == 6 ? 0.0 : 0.25));
  judge("c11_error", (measured.moduli.c11 - expected.c11) / scale);
  judge("c12_error", (measured.moduli.c12 - expected.c12) / scale);
  judge("c44_error", (measured.moduli.c44 - expected.c44) / scale);
  judge("not_affine", measured.not_affine);
  table.rows.push_back({tag, measured.youngs, measured.poisson, measured.moduli.c11,
                        measured.moduli.c12, measured.moduli.c44, expected.c11, expected.c12,
                        expected.c44});
  Series& nodes = figure.add(tag + " neighbours", Series::Style::points);
  for (Index i = 0; i < network.node_count(); ++i) {
    nodes.add(1e3 * network.rest_position(2, i), 1e6 * measured.traction_displacement(3 * i + 2));
  }
}

/// Edges, face and body diagonals scaled apart, so that no term of a formula hides behind another.
void anisotropic(const CaseContext& context, Outcome& outcome) {
  const Block block{.nodes = {4, 5, 4}};
  SpringNetwork network = block_network(block);
  constexpr std::array factor{1.7, 0.6, 2.3};
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= factor[static_cast<std::size_t>(kind_of(network, s, block.spacing) - 1)];
  });
  BondStiffness bonds = bond_stiffness(block.youngs_modulus, block.spacing, 26);
  bonds = {bonds.edge * factor[0], bonds.face_diagonal * factor[1],
           bonds.body_diagonal * factor[2]};
  const CubicModuli expected = formula(bonds, block.spacing);
  const Measured measured = measure_moduli(block, candidate(context, network));
  const auto judge = [&](const std::string& name, double error) {
    outcome.judge_at_most("anisotropic_" + name, std::abs(error), rounding,
                          "homogenised cubic lattice; rounding of a refined solve");
  };
  judge("c11_error", measured.moduli.c11 / expected.c11 - 1.0);
  judge("c12_error", measured.moduli.c12 / expected.c12 - 1.0);
  judge("c44_error", measured.moduli.c44 / expected.c44 - 1.0);
  judge("youngs_error", measured.youngs / expected.youngs() - 1.0);
  judge("poisson_error", measured.poisson - expected.poisson());
}

void masses(const CaseContext& context, Outcome& outcome) {
  const Block block{.nodes = {5, 4, 6}};
  const SpringNetwork network = candidate(context, block_network(block));
  const double volume = 4.0 * 3.0 * 5.0 * std::pow(block.spacing, 3);
  outcome.judge_at_most("mass_error", std::abs(network.mass.sum() / (block.density * volume) - 1.0),
                        60.0 * 8.0 * epsilon, "60 cells of eight shares each, one rounding each");
  const BondStiffness k = bond_stiffness(1.0, 1.0, 26);
  outcome.judge_at_most("isotropy_error",
                        std::abs(k.edge - k.face_diagonal - 8.0 / 3.0 * k.body_diagonal),
                        4.0 * epsilon, "isotropic iff k1 = k2 + 8/3 k3");
  outcome.judge_at_most("bond_error", std::abs(k.face_diagonal - 1.0 / 3.75), 4.0 * epsilon,
                        "k2 = E a / 3.75");
}

void measure_patch_test(const CaseContext& context, Outcome& outcome) {
  Table& table =
      outcome.table("moduli", "Homogenised moduli",
                    "Moduli measured on a block of 5 x 4 x 6 nodes under uniform traction on "
                    "rollers and under affine boundary displacement, beside their formulas.",
                    {"neighbours", "E (Pa)", "Poisson's ratio", "C11 (Pa)", "C12 (Pa)", "C44 (Pa)",
                     "C11 formula (Pa)", "C12 formula (Pa)", "C44 formula (Pa)"});
  Figure& figure =
      outcome.plot("traction", "Displacement under uniform traction",
                   "Every node of a block pulled by 1 Pa lies on the straight line of a "
                   "homogeneous solid, whatever its neighbours.",
                   {"distance from the roller (mm)"}, {"displacement along the pull (µm)"});
  for (const int connectivity : {6, 18, 26}) {
    patch(context, connectivity, outcome, table, figure);
  }
  const Block block;
  figure.add("t z / E", {0.0, 1e3 * 5.0 * block.spacing},
             {0.0, 1e6 * 5.0 * block.spacing / block.youngs_modulus}, Series::Style::dashed);
  anisotropic(context, outcome);
  masses(context, outcome);
}

// The paper's Fig. 12: a block is sheared and let go. What of the shear is left once it has come
// to rest tells whether the lattice resists shear at all.

constexpr double shear = 0.1;  ///< initial, tan of the angle

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
                                    const Trace& motion) {
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
Series slice(const Block& block, const SpringNetwork& network, const Trace& motion, Index sample,
             const std::string& label) {
  const NetworkProblem problem(network);
  Series points{.label = label, .style = Series::Style::points};
  for (int l = 0; l < block.nodes[2]; ++l) {
    for (int i = 0; i < block.nodes[0]; ++i) {
      const int node = block.shape().index(i, block.nodes[1] / 2, l);
      const Index c = problem.coordinate(node);
      const NodeVectors start = network.initial_position();
      points.add(1e3 * (c < 0 ? start(0, node) : motion.position(c, sample)),
                 1e3 * (c < 0 ? start(2, node) : motion.position(c + 2, sample)));
    }
  }
  return points;
}

/// Returns the theoretical rest position of the block. Without shear stiffness each column keeps
/// its initial direction and shortens to its rest length.
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

void measure_skew(int connectivity, const CaseContext& context, Outcome& outcome) {
  const int n = context.quick ? 5 : 7;
  // Slow modes overdamped: columns must not be pushed together, where they would buckle.
  const Block block{.nodes = {n, n, n}, .connectivity = connectivity, .relaxation = 0.02};
  const SpringNetwork network = skewed_network(block);
  const Scene scene = automatic_scene("velocity-verlet", 5e-3, context.quick ? 0.8 : 1.6);
  const Trace motion = roll_out(context, scene, &network, {.position = true});
  const std::vector<double> values = shear_over_time(block, network, motion);
  const double away = largest_of(motion.position.rightCols<1>() - final_position(block, network));
  const double expected = connectivity == 6 ? 1.0 / std::sqrt(1.0 + shear * shear) : 0.0;
  outcome.judge_near("residual_over_initial_shear", values.back() / shear, expected, 1e-6,
                     connectivity == 6
                         ? "theory: columns shorten to their rest length along the direction they "
                           "were given, so 1/sqrt(1 + shear^2) stays"
                         : "theory: C44 > 0, so every mode decays; 40 relaxation times");
  outcome.judge_at_most("furthest_node_from_theory", away, 2e-9,
                        "1e-6 of the smallest block's initial displacement of 2 mm", "m");
  outcome.judge_at_most("diverged", motion.diverged ? 1.0 : 0.0, 0.0,
                        "steps below the stability limit");
  outcome.figures.push_back(
      plot("shear", "Shear of a released block, " + std::to_string(connectivity) + " neighbours",
           connectivity == 6
               ? "Lattices of 6 neighbours have no shear stiffness: the skewed block stays skewed."
               : "The released block comes back to its shape.",
           {"time (s)"}, {"shear (1)"},
           {curve("mean shear of the released face", motion.time, values),
            curve("initial", {0.0, motion.time.back()}, {shear, shear}, Series::Style::dashed)}));
  Figure& shape =
      outcome.plot("slice", "Middle slice before and after",
                   "Nodes of the middle slice when the block is let go and when it rests.",
                   {"x (mm)"}, {"z (mm)"});
  shape.square = true;
  shape.series.push_back(slice(block, network, motion, 0, "let go"));
  shape.series.push_back(slice(block, network, motion, motion.position.cols() - 1, "at rest"));
}

// Frequencies of chains and bars, assembled and from motions, against closed forms.

constexpr double pi = std::numbers::pi;

/// omega of a sampled undamped mode: least squares of x(n+1) + x(n-1) = 2 cos(omega dt) x(n).
double identify_frequency(const VectorXd& x, double dt) {
  const Index n = x.size() - 2;
  if (n < 1 || !x.allFinite()) { return std::nan(""); }
  const VectorXd middle = x.segment(1, n);
  const VectorXd sides = x.head(n) + x.tail(n);
  return std::acos(0.5 * middle.dot(sides) / middle.squaredNorm()) / dt;
}

/// Returns the numerical frequency of classical RK4: the argument of its amplification factor.
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
  const Trace motion = roll_out(context, scene_of("rk4", sample, 40.0 * sample, substeps), &network,
                                {.position = true});
  const NetworkProblem problem(network);
  VectorXd weights = VectorXd::Zero(problem.dof());
  for (const int node : problem.free_nodes()) {
    weights(problem.coordinate(node) + 2) = shape(node) * network.mass(node);
  }
  const VectorXd rest = reference::rest_coordinates(problem);
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
  return eigenvalues(stiffness, problem.mass()(along)).cwiseMax(0.0).cwiseSqrt();
}

struct ChainErrors {
  Largest matrix{};  ///< of the assembled frequencies
  Largest motion{};  ///< of those measured from motions
  Largest scheme{};  ///< of those against RK4's own
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
    errors.matrix.add(std::abs(assembled(j - 1) / omega - 1.0));
    errors.scheme.add(std::abs(run.measured / run.expected - 1.0));
    errors.motion.add(std::abs(run.measured / omega - 1.0));
    formula.add(j, omega);
    points.add(j, run.measured);
  }
  return errors;
}

void measure_chain(const CaseContext& context, Outcome& outcome) {
  Series formula{.label = "2 sqrt(k/m) sin((2j-1) pi / (2(2N+1)))"};
  Series points{.label = "measured from motion", .style = Series::Style::points};
  const ChainErrors errors = compare_chain(context, formula, points);
  outcome.judge_at_most("assembled_frequency_error", errors.matrix.value(), 1e-12,
                        "theory; rounding of the eigenvalues times their spread of 700");
  outcome.judge_at_most("measured_frequency_error", errors.motion.value(),
                        1.01 * 1e-8 / 120.0 + 1e-11,
                        "theory: (omega h)^4 / 120 of RK4, and the rounding of the fit");
  outcome.judge_at_most("measured_minus_rk4_frequency", errors.scheme.value(), 1e-11,
                        "discrete theory of RK4; rounding of positions over displacements, 3e-13 a "
                        "sample, over the squared phase between samples");
  outcome.figures.push_back(plot(
      "frequencies", "Natural frequencies of a fixed-free chain of 20 masses",
      "Frequencies measured from single modes followed by RK4 lie on the closed form of the chain.",
      {"mode j"}, {"angular frequency (rad/s)"}, {std::move(formula), std::move(points)}));
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
  points.add(bar.wave_number(j) * bar.block.spacing / pi, omega * bar.block.spacing / bar.speed);
  const double residual =
      largest_of(along - omega * omega * inertia) / largest_of(omega * omega * inertia);
  Largest error(residual);
  error.add(std::abs(omega / bar.omega(j) - 1.0));
  return error.value();
}

constexpr int bar_cells = 24;

void judge_assembled(const CaseContext& context, int connectivity, Figure& figure,
                     Outcome& outcome) {
  const Bar bar = bar_of(connectivity, bar_cells);
  const SpringNetwork network = candidate(context, block_network(bar.block));
  Series& points =
      figure.add(std::to_string(connectivity) + " neighbours, assembled", Series::Style::points);
  Largest error;
  for (int j = 1; j <= bar_cells; ++j) { error.add(assembled_error(bar, network, j, points)); }
  outcome.judge_at_most("assembled_error_" + std::to_string(connectivity), error.value(), 1e-11,
                        "theory; rounding of forces that cancel by (q a)^2 = 0.02");
}

/// With 6 neighbours a plane wave needs no rollers: it can be followed in motion.
void judge_motion(const CaseContext& context, Figure& figure, Outcome& outcome) {
  const Bar bar = bar_of(6, bar_cells);
  const SpringNetwork network = block_network(bar.block);
  Series& measured = figure.add("6 neighbours, from motion", Series::Style::points);
  Largest error;
  for (int j = 1; j <= bar_cells; j += context.quick ? 6 : 3) {
    const VectorXd shape = plane_wave(bar, network, j, 1e-3 * bar.block.spacing);
    const ModeRun run = run_mode(context, network, shape, bar.omega(j));
    error.add(std::abs(run.measured / run.expected - 1.0));
    measured.add(bar.wave_number(j) * bar.block.spacing / pi,
                 run.measured * bar.block.spacing / bar.speed);
  }
  outcome.judge_at_most("motion_error_6", error.value(), 1e-10,
                        "discrete theory of RK4; rounding of positions over displacements, 1e-12 a "
                        "sample, over the squared phase between samples");
}

void measure_dispersion(const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("dispersion", "Longitudinal waves along an axis of the lattice",
                   "Frequencies of plane waves, from the assembled matrices (sides on rollers) and "
                   "from motions, on the lattice dispersion; the dashed line is the continuum.",
                   {"q a / pi"}, {"omega a / c"});
  Series& lattice = figure.add("2 sin(q a / 2)");
  for (int n = 0; n <= 60; ++n) { lattice.add(n / 60.0, 2.0 * std::sin(n * pi / 120.0)); }
  figure.add("continuum", {0.0, 0.7}, {0.0, 0.7 * pi}, Series::Style::dashed);
  for (const int connectivity : {6, 18, 26}) {
    judge_assembled(context, connectivity, figure, outcome);
  }
  judge_motion(context, figure, outcome);
}

/// Blocks of several Poisson's ratios against isotropic elasticity.
void measure_poisson(const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("poisson", "Poisson's ratio of a block under traction",
                   "Measured from the lateral contraction; the line is what the material gives.",
                   {"nu of the material"}, {"nu measured"});
  figure.add("given", {0.25, 0.49}, {0.25, 0.49});
  Series& points = figure.add("measured", Series::Style::points);
  for (const double nu : {0.25, 0.3, 0.45, 0.49}) {
    const Block block{.poissons_ratio = nu};
    const Measured measured = measure_moduli(block, candidate(context, block_network(block)));
    const double e = block.youngs_modulus;
    const double mu = 0.5 * e / (1.0 + nu);
    const double lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    Largest error(std::abs(measured.youngs / e - 1.0));
    error.add(std::abs(measured.poisson / nu - 1.0));
    error.add(measured.not_affine);
    error.add(std::abs(measured.moduli.c11 / (lambda + 2.0 * mu) - 1.0));
    error.add(std::abs(measured.moduli.c12 / lambda - 1.0));
    error.add(std::abs(measured.moduli.c44 / mu - 1.0));
    outcome.judge_at_most("error_nu_" + plain_number(nu, 2), error.value(), 1e-10,
                          "theory; rounding times the condition of a nearly incompressible block, "
                          "1 / (1 - 2 nu)");
    points.add(nu, measured.poisson);
  }
}

/// Layers that differ in damping alone, with their border in a row of cells: a step of velocity
/// across the row loses the power of the mean damping ratio.
void judge_mixed_damping(const CaseContext& context, Outcome& outcome) {
  constexpr double upper = 0.2;
  constexpr double lower = 0.8;
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {3, 3}, .spacing = 0.003, .connectivity = 26};
  scene.tissue.fixed = std::vector<Face>{};
  scene.materials = {{.name = "upper", .youngs_modulus = 1e4, .damping_ratio = upper},
                     {.name = "lower", .youngs_modulus = 1e4, .damping_ratio = lower}};
  const auto lost = [&](double border) {
    scene.tissue.layers = {{"upper", "upper", border}, {"lower", "lower", 0.009 - border}};
    const SpringNetwork network = candidate(context, build_network(scene));
    const NetworkProblem problem(network);
    Eigen::SparseMatrix<double> stiffness;
    Eigen::SparseMatrix<double> damping;
    problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), stiffness, damping);
    VectorXd v = VectorXd::Zero(problem.dof());
    for (const int node : problem.free_nodes()) {
      v(problem.coordinate(node) + 2) = network.rest_position(2, node) < 0.0045 ? 0.0 : 1.0;
    }
    return v.dot(damping * v);
  };
  const double mixed = upper / 3.0 + lower * 2.0 / 3.0;
  outcome.judge_near("damping_of_a_row_of_two_tissues", lost(0.004) / lost(0.006), mixed / upper,
                     1e-12,
                     "the mean damping ratio by volume, a third and two thirds (EQUATIONS.md); "
                     "rounding");
}

/// Decay of the slowest mode of a cube of 20 mm on a fixed face, from its motion.
void measure_retardation(const CaseContext& context, Outcome& outcome) {
  constexpr double edge = 0.02;
  constexpr double tau = 2e-3;
  for (const int cells : {2, 4, 6}) {
    Block block{
        .nodes = {cells + 1, cells + 1, cells + 1}, .spacing = edge / cells, .poissons_ratio = 0.4};
    CellMaterial material{.youngs_modulus = block.youngs_modulus,
                          .density = block.density,
                          .poissons_ratio = block.poissons_ratio,
                          .retardation_time = tau};
    SpringNetwork network = cell_lattice(block.shape(), [&](int, int, int) { return material; });
    hold(network, Face::z_max);
    const NetworkProblem problem(network);
    const VectorXd scale = problem.mass().cwiseSqrt().cwiseInverse();
    const MatrixXd matrix =
        scale.asDiagonal() * MatrixXd(stiffness_of(problem)) * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(matrix);
    const double omega = std::sqrt(modes.eigenvalues()(0));
    const VectorXd mode = scale.cwiseProduct(modes.eigenvectors().col(0));
    const double size = 1e-5 * edge / largest_of(mode);
    network.initial_displacement = NodeVectors::Zero(3, network.node_count());
    for (const int node : problem.free_nodes()) {
      network.initial_displacement.col(node) = size * mode.segment<3>(problem.coordinate(node));
    }
    const double period = 2.0 * pi / omega;
    Scene scene = automatic_scene("rk4", period / 200.0, 2.0 * period);
    const Trace trace = roll_out(context, scene, &network, {.position = true, .velocity = true});
    const VectorXd weight = problem.mass().cwiseProduct(mode);
    const double expected = 0.5 * omega * tau;
    const double decay = expected * omega;
    const double own = omega * std::sqrt(1.0 - expected * expected);
    const auto envelope = [&](Index row) {
      const double p = weight.dot(trace.position.col(row) - problem.initial_position());
      const double v = weight.dot(trace.velocity.col(row));
      return std::hypot(p, (v + decay * p) / own);
    };
    const Index last = trace.position.cols() - 1;
    const double measured = std::log(envelope(0) / envelope(last)) / (2.0 * period * omega);
    outcome.judge_at_most("damping_error_" + std::to_string(cells) + "_cells",
                          std::abs(measured / expected - 1.0), 1e-5,
                          "theory: damping ratio omega tau / 2 of a Kelvin-Voigt solid on every "
                          "grid; strains of 1e-5");
    outcome.report("damping_ratio_" + std::to_string(cells) + "_cells", measured, "1");
  }
  judge_mixed_damping(context, outcome);
}

/// A spring between a fixed and a very heavy node, whose strain is held or grows steadily.
void judge_prony(const CaseContext& context, bool held, const MaterialLaw& law,
                 const std::string& integrator, Figure& figure, Outcome& outcome) {
  constexpr double stiffness = 50.0;
  constexpr double rest = 0.02;
  constexpr double strain = 0.2;
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.rest_position(0, 1) = rest;
  network.mass = VectorXd::Constant(2, 1e15);
  network.fixed = {1, 0};
  network.springs = {{0, 1, stiffness, 0.0, rest, network.law_number(law)}};
  network.initial_displacement = NodeVectors::Zero(3, 2);
  network.initial_velocity = NodeVectors::Zero(3, 2);
  (held ? network.initial_displacement : network.initial_velocity)(0, 1) = strain * rest;
  Scene scene = scene_of(integrator, 0.01, 2.0, 2);
  scene.records = {{.name = "wall", .where = 0, .quantities = {RecordedQuantity::force}}};
  const Trace trace = roll_out(context, scene, &network, {});
  const std::vector<double>& force = trace.values("wall.fx_n");
  Series points{.label = (held ? "held, " : "steady, ") + integrator,
                .style = Series::Style::points};
  Series exact{.label = std::string(held ? "held" : "steady") + ", closed form"};
  Largest error;
  for (std::size_t n = 0; n < force.size(); ++n) {
    const double t = trace.time[n];
    // Held: k L0 e (1 - sum of g (1 - exp(-t / tau))). Strain e t: the integral of that.
    double expected = held ? 1.0 : t;
    for (const RelaxationBranch& b : law.branches) {
      const double gone = 1.0 - std::exp(-t / b.time);
      expected -= b.share * (held ? gone : t - b.time * gone);
    }
    expected *= stiffness * rest * strain;
    if (n % 5 == 0) { exact.add(t, expected); }
    if (n % 20 == 0) { points.add(t, force[n]); }
    if (expected > 0.0) { error.add(std::abs(force[n] / expected - 1.0)); }
  }
  figure.series.push_back(std::move(exact));
  figure.series.push_back(std::move(points));
  outcome.judge_at_most(
      (held ? "held_strain_" : "steady_strain_") + integrator, error.value(),
      16.0 * std::numeric_limits<double>::epsilon() * static_cast<double>(force.size()),
      "theory: a Prony series is integrated exactly for a strain that is linear "
      "in time; 16 roundings a step");
}

/// A block of two materials against equations of motion that share no code with the model.
void judge_laws(const CaseContext& context, const std::string& name,
                const std::array<MaterialLaw, 2>& laws, Outcome& outcome) {
  const Block block{};
  SpringNetwork network = cell_lattice(block.shape(), [&](int, int, int l) {
    CellMaterial material{.youngs_modulus = block.youngs_modulus, .density = block.density};
    material.poissons_ratio = l < 1 ? 0.4 : 0.25;
    material.retardation_time = 5e-4;
    material.law = laws[l < 1 ? 0 : 1];
    return material;
  });
  hold(network, Face::z_max);
  displace(network, 0.2 * block.spacing);
  const double end = context.quick ? 0.02 : 0.05;
  const auto run = [&](int substeps) {
    return roll_out(context, scene_of("rk4", 1e-3, end, substeps), &network, {.position = true});
  };
  const Trace coarse = run(context.quick ? 4 : 8);
  const Trace fine = run(context.quick ? 8 : 16);
  const Trace truth =
      reference::solve_long_double(NetworkProblem(network), fine.time, {.relative = 1e-10});
  const double step_error = distance(coarse, fine).maximum;
  outcome.judge_at_most(name + "_error_over_step_halving",
                        distance(fine, truth).maximum / step_error, 0.4,
                        "theory: 1 / (2^p - 1) = 1/3 or less of what halving the step changes, for "
                        "order p >= 2");
  outcome.judge_at_most(name + "_step_halving", step_error, 1e-3,
                        "so small that an error of 1 % in a law stands out");
}

void measure_laws(const CaseContext& context, Outcome& outcome) {
  const MaterialLaw exponential{.stiffening = {.rate = 8.0}};
  const MaterialLaw polynomial{
      .stiffening = {.law = Stiffening::Law::polynomial, .quadratic = 4.0, .cubic = 40.0}};
  judge_laws(context, "stiffening", {exponential, polynomial}, outcome);
}

void measure_relaxation(const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("relaxation", "Force of a relaxing spring",
                   "Held at a strain, and stretched steadily; the lines are the closed forms.",
                   {"time (s)"}, {"force (N)"});
  const MaterialLaw prony{.branches = {{0.3, 0.05}, {0.2, 0.4}, {0.1, 3.0}}};
  for (const char* integrator : {"implicit-euler", "velocity-verlet"}) {
    for (const bool held : {true, false}) {
      judge_prony(context, held, prony, integrator, figure, outcome);
    }
  }
  const MaterialLaw both{.stiffening = {.rate = 8.0}, .branches = {{0.3, 0.004}, {0.2, 0.1}}};
  judge_laws(context, "relaxing", {prony, both}, outcome);
}

}  // namespace

std::vector<Case> elasticity_cases() {
  std::vector<Case> cases{
      {"network/stiffening", "accuracy",
       "A block whose springs stiffen exponentially and by a polynomial moves as equations of its "
       "own in long double say.",
       measure_laws, 1.0},
      {"network/relaxation", "accuracy",
       "Springs relax as their Prony series says under held and steady strain, and a relaxing "
       "block moves as equations of its own in long double say.",
       measure_relaxation, 1.0},
      {"network/poisson", "accuracy",
       "Blocks with Poisson's ratios from 0.25 to 0.49 have their Young's modulus, Poisson's ratio "
       "and elastic constants under traction and affine strain.",
       measure_poisson, 0.5},
      {"network/retardation", "accuracy",
       "The slowest mode of a cube decays with the damping ratio omega tau / 2 on three grids.",
       measure_retardation, 1.0},
      {"network/patch-test", "accuracy",
       "A cell-built lattice under uniform traction has the Young's modulus it was given, "
       "Poisson's ratio 1/4 (0 and no shear stiffness with 6 neighbours), and its homogenised "
       "moduli.",
       measure_patch_test, 0.3},
      {"network/chain-frequencies", "accuracy",
       "A fixed-free chain of equal masses has its closed-form frequencies, in its assembled "
       "stiffness and in its motion.",
       measure_chain, 0.3},
      {"network/dispersion", "accuracy",
       "Plane longitudinal waves along an axis follow omega = (2/a) sqrt(C11/rho) sin(q a / 2).",
       measure_dispersion, 0.5}};
  for (const int connectivity : {6, 18, 26}) {
    const std::string neighbours = std::to_string(connectivity);
    cases.push_back({"network/skew/" + neighbours, "accuracy",
                     connectivity == 6 ? "A sheared block of 6-neighbour springs keeps its shear: "
                                         "6 neighbours have no shear stiffness."
                                       : "A sheared block of " + neighbours +
                                             "-neighbour springs comes back to its shape.",
                     std::bind_front(measure_skew, connectivity), 1.0});
  }
  return cases;
}

}  // namespace palpate::networks

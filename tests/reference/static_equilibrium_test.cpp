// SPDX-License-Identifier: MIT

#include "reference/static_equilibrium.hpp"

#include <numbers>

#include "reference/exact_problems.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;
using Eigen::VectorXd;

VectorXd force_at(const Problem& problem, const VectorXd& q) {
  VectorXd f(problem.dof());
  problem.force(0.0, 0.0, q, VectorXd::Zero(q.size()), f);
  return f;
}

TEST("a lattice pushed far comes to rest where no force is left") {
  Load push{.nodes = {0, 1, 4}, .force = {0.2, 0.1, 0.6}};
  const NetworkProblem problem(sample::block({.nodes = 4}), {push}, {0.0, 0.0, 9.81});
  const Equilibrium rest = static_equilibrium(problem);
  CHECK_NEAR(force_at(problem, rest.position).cwiseAbs().maxCoeff(), 0.0, 1e-12 * 0.6);
  CHECK(rest.residual <= 1e-12);
  CHECK((rest.position - problem.initial_position()).cwiseAbs().maxCoeff() > 2e-4);
}

TEST("a tripod carries its load: the force balance holds for a large deflection") {
  const Eigen::Vector3d load(0.05, -0.02, -0.4);
  const NetworkProblem problem = sample::tripod(load);
  const Equilibrium rest = static_equilibrium(problem);
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();  // Hooke's law, written here once more
  for (int foot = 0; foot < 3; ++foot) {
    const Eigen::Vector3d leg = rest.position - problem.network().rest_position.col(foot);
    const double rest_length =
        problem.network().springs[static_cast<std::size_t>(foot)].rest_length;
    reaction -= 100.0 * (leg.norm() - rest_length) * leg.normalized();
  }
  CHECK_NEAR(reaction, Eigen::Vector3d(-load), 1e-12);
}

TEST("an oscillator at rest carries its drive") {
  const OscillatorProblem problem(Oscillator{.stiffness = 4.0, .drive_amplitude = 2.0});
  CHECK_NEAR(static_equilibrium(problem).position(0), 0.5, 1e-15);
  const NetworkProblem at_rest(sample::block({.nodes = 3}));  // needs no iteration
  CHECK(static_equilibrium(at_rest).iterations <= 1);
}

TEST("an unsymmetric stiffness, of the printed direction, is solved too") {
  const NetworkProblem problem = sample::tripod({2e-5, 1e-5, -3e-3}, {.direction = true});
  const Equilibrium rest = static_equilibrium(problem);
  CHECK_NEAR(force_at(problem, rest.position).cwiseAbs().maxCoeff(), 0.0, 1e-14);
}

TEST("the response is the limit of small loads") {
  const Eigen::Vector3d load(3e-7, -1e-7, -2e-6);
  const NetworkProblem problem = sample::tripod(load);
  const VectorXd linear = StaticResponse(problem)(load);
  const VectorXd moved = static_equilibrium(problem).position - problem.initial_position();
  CHECK_NEAR(moved / linear.norm(), VectorXd(linear / linear.norm()), 1e-5);
  CHECK_NEAR(LinearProblem(problem).stiffness() * linear, VectorXd(load), 1e-18);
}

TEST("factors and conjugate gradients give the same answer") {
  const NetworkProblem problem(sample::block({.nodes = 5}));
  VectorXd load = VectorXd::Zero(problem.dof());
  load(2) = 1.0;
  load(7) = -0.3;
  const StaticResponse factorised(problem);
  const VectorXd exact = factorised(load);
  // A relative residual of 1e-10, times a condition of a few hundred.
  CHECK_NEAR(StaticResponse(problem, 0)(load) / exact.norm(), VectorXd(exact / exact.norm()), 1e-7);
  CHECK_NEAR(factorised.compliance(load), load.dot(exact), 1e-18);
}

TEST("Maxwell and Betti: pushing here moves there as pushing there moves here") {
  const NetworkProblem problem(sample::block({.nodes = 4}));
  const StaticResponse response(problem);
  VectorXd here = VectorXd::Zero(problem.dof());
  VectorXd there = here;
  here(0) = 1.0;
  there(20) = 1.0;
  CHECK_NEAR(response(here)(20) / response(there)(0), 1.0, 1e-12);
}

TEST("a body that can move freely is an error") {
  auto network = sample::block({.nodes = 3});
  std::ranges::fill(network.fixed, std::uint8_t{0});
  const NetworkProblem problem(network, {sample::pulse(0.1)});
  CHECK_THROWS(static_equilibrium(problem, {.time = 0.01, .gate = 0.01}), "static equilibrium");
  CHECK_THROWS(StaticResponse(problem)(VectorXd::Unit(problem.dof(), 0)), "move freely");
}

TEST("a punch on a layer has the published stiffness, and those of a half space and a thin layer") {
  // Table 1 of Hayes et al. 1972 for nu = 0.5, as reproduced in software of two later authors. The
  // table was computed with few points: above a / h = 1 it is up to 1 % lower at 2.
  struct Row {
    double ratio;
    double kappa;
    double tolerance;
  };
  for (const Row& row :
       {Row{0.2, 1.281, 5e-4}, Row{0.4, 1.683, 1e-3}, Row{0.6, 2.211, 1e-3}, Row{0.8, 2.855, 2e-3},
        Row{1.0, 3.609, 3e-3}, Row{1.5, 5.970, 6e-3}, Row{2.0, 9.069, 1e-2}}) {
    const PunchFactor found = punch_on_layer(row.ratio, 0.5);
    CHECK_NEAR(found.kappa / row.kappa, 1.0, row.tolerance);
    CHECK(found.uncertainty < 1e-6);
  }
  for (const double nu : {0.0, 0.25, 0.49}) {
    // Half space: kappa - 1 is proportional to a / h.
    const double far = punch_on_layer(1e-3, nu).kappa - 1.0;
    CHECK(far > 0.0);
    CHECK(far < 2e-3);
    CHECK_NEAR(punch_on_layer(2e-3, nu).kappa - 1.0, 2.0 * far, 2e-2 * far);
  }
  for (const double nu : {0.0, 0.25}) {
    // Thin layer: confined compression, kappa = pi (1 - nu)^2 / (2 (1 - 2 nu)) a / h + constant.
    const double slope = (punch_on_layer(6.0, nu).kappa - punch_on_layer(4.0, nu).kappa) / 2.0;
    CHECK_NEAR(slope * 2.0 * (1.0 - 2.0 * nu) / (3.14159265 * (1.0 - nu) * (1.0 - nu)), 1.0, 5e-3);
  }
}

TEST("a sphere on a deep layer has Hertz's force, and that of a flat punch beyond its face") {
  const double a = 0.0075;
  for (const double nu : {0.0, 0.49}) {
    const std::vector<PunchLayer> deep{{4.0, 1e4, nu}};
    const SphericalFace face{.radius = a, .tip_radius = 0.03};
    const double plane = 1e4 / (1.0 - nu * nu);
    const double full = a * a / face.tip_radius;
    // A base at 530 radii stiffens by about a / h, 0.2 %.
    for (const double share : {0.01, 0.3, 0.99}) {
      const SphereForce found = sphere_on_layers(share * full, face, deep);
      const double hertz =
          4.0 / 3.0 * plane * std::sqrt(face.tip_radius) * std::pow(share * full, 1.5);
      CHECK_NEAR(found.force / hertz, 1.0, 5e-3);
      CHECK_NEAR(found.contact_radius / std::sqrt(share * full * face.tip_radius), 1.0, 5e-3);
      CHECK(found.uncertainty < 1e-6);
    }
    const double more = sphere_on_layers(3.0 * full, face, deep).force;
    const double less = sphere_on_layers(2.0 * full, face, deep).force;
    CHECK_NEAR((more - less) / full, punch_on_layers(a, deep).kappa * 2.0 * plane * a,
               1e-6 * plane * a);
  }
}

TEST("the force of a sphere grows with its dent as that of a flat punch of its contact") {
  // dF/dD at the equilibrium of the contact's edge, on a layer of one radius.
  const std::vector<PunchLayer> layer{{0.0075, 1e4, 0.4}};
  const SphericalFace face{.radius = 0.0075, .tip_radius = 0.03};
  for (const double dent : {2e-4, 6e-4}) {
    constexpr double small = 1e-6;
    const double slope = (sphere_on_layers(dent + small, face, layer).force -
                          sphere_on_layers(dent - small, face, layer).force) /
                         (2.0 * small);
    const double a = sphere_on_layers(dent, face, layer).contact_radius;
    const double punch = punch_on_layers(a, layer).kappa * 2.0 * 1e4 * a / (1.0 - 0.16);
    CHECK_NEAR(slope / punch, 1.0, 1e-4);
  }
}

TEST("a uniform pressure on a deep layer has the mean displacement of the closed form") {
  // 3 pi^2 E a / (16 (1 - nu^2)); on a layer it is stiffer, and never as stiff as a rigid face.
  const double a = 0.0075;
  const double half_space = 3.0 * std::numbers::pi * std::numbers::pi / 32.0;
  CHECK_NEAR(uniform_pressure_on_layers(a, {{4.0, 1e4, 0.3}}).kappa / half_space, 1.0, 4e-3);
  const PunchFactor layer = uniform_pressure_on_layers(a, {{a, 1e4, 0.3}});
  CHECK(layer.kappa > half_space);
  CHECK(layer.kappa < punch_on_layers(a, {{a, 1e4, 0.3}}).kappa);
  CHECK(layer.uncertainty < 1e-6);
}

TEST("a punch on layers has the stiffness of one layer if they are alike") {
  const double a = 0.0075;
  for (const double nu : {0.0, 0.25, 0.49}) {
    const PunchFactor two = punch_on_layers(a, {{0.002, 1e4, nu}, {0.01, 1e4, nu}});
    CHECK_NEAR(two.kappa / punch_on_layer(a / 0.012, nu).kappa, 1.0, 1e-6);
    CHECK(two.uncertainty < 1e-6);
  }
  // A base that is a million times stiffer is rigid.
  const PunchFactor rigid = punch_on_layers(a, {{0.012, 1e4, 0.4}, {0.012, 1e10, 0.2}});
  CHECK_NEAR(rigid.kappa / punch_on_layer(a / 0.012, 0.4).kappa, 1.0, 1e-5);
  // A skin of twice the modulus, a fifteenth as thick as the radius, stiffens a half space by less
  // than a fifth.
  const double thin = punch_on_layers(a, {{5e-4, 2e4, 0.4}, {0.6, 1e4, 0.4}}).kappa * 2e4;
  CHECK(thin > 1e4);
  CHECK(thin < 1.2e4);
}

}  // namespace PALPATE_FILE

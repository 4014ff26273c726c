// SPDX-License-Identifier: MIT

#include "model/problem/material_law.hpp"

#include <Eigen/SparseCore>
#include <cmath>
#include <random>
#include <string>

#include "model/kernels/list_network.hpp"
#include "model/problem/problem.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/lattice.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::VectorXd;

constexpr double h = 0.01;
const MaterialLaw exponential{.stiffening = {.rate = 6.0}};
const MaterialLaw polynomial{
    .stiffening = {.law = Stiffening::Law::polynomial, .quadratic = 2.0, .cubic = 30.0}};
const std::vector<RelaxationBranch> branches{{0.3, 0.02}, {0.2, 0.5}};
const MaterialLaw relaxing{.stiffening = {.rate = 6.0}, .branches = branches};

TEST("stiffening starts with slope 1, is odd, and goes on straight from its largest slope") {
  for (const MaterialLaw& law : {exponential, polynomial}) {
    const auto numbers = stiffening_numbers<double>(law);
    const auto g = [&](double e) { return stretched<double>(numbers, e); };
    CHECK_NEAR(g(0.0).slope, 1.0, 1e-15);
    CHECK_NEAR(g(1e-9).value, 1e-9, 1e-16);
    CHECK_NEAR(g(numbers.straight).slope, law.stiffening.largest, 1e-12);
    CHECK_NEAR(g(2.0 * numbers.straight).slope, law.stiffening.largest, 1e-12);
    for (const double e : {0.01, 0.1, 0.3, 0.5, 2.0}) {
      const double d = 1e-6;
      CHECK(g(-e).value == -g(e).value);
      CHECK_NEAR(g(e).slope, (g(e + d).value - g(e - d).value) / (2.0 * d), 1e-8 * g(e).slope);
      CHECK_NEAR(g(e).value,
                 (stretched_work(numbers, e + d) - stretched_work(numbers, e - d)) / (2.0 * d),
                 1e-8 * g(e).value);
    }
  }
  // exp(6 * 0.2) - 1 over 6, and 0.2 + 2 * 0.04 + 30 * 0.008
  CHECK_NEAR(stretched<double>(stiffening_numbers<double>(exponential), 0.2).value,
             (std::exp(1.2) - 1.0) / 6.0, 1e-15);
  CHECK_NEAR(stretched<double>(stiffening_numbers<double>(polynomial), 0.2).value, 0.52, 1e-15);
}

/// A block of two materials, one of them with volume terms, whose border has springs of both.
SpringNetwork block(const MaterialLaw& upper, const MaterialLaw& lower) {
  return cell_lattice({{4, 4, 4}, h, 26}, [&](int, int, int l) {
    CellMaterial material{.youngs_modulus = 1e4, .density = 1000.0};
    material.poissons_ratio = l < 2 ? 0.45 : 0.25;
    material.retardation_time = 1e-3;
    material.law = l < 2 ? upper : lower;
    return material;
  });
}

VectorXd shaken(VectorXd q, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> some(-by, by);
  for (double& x : q) { x += some(random); }
  return q;
}

TEST("materials with different laws make springs beside each other") {
  const SpringNetwork network = block(exponential, {});
  const SpringNetwork plain = block({}, {});
  CHECK(network.laws.size() == 1);
  CHECK(network.springs.size() > plain.springs.size());
  double with = 0.0;
  double without = 0.0;
  for (const Spring& s : network.springs) { with += s.stiffness; }
  for (const Spring& s : plain.springs) { without += s.stiffness; }
  CHECK_NEAR(with / without, 1.0, 1e-12);
  CHECK(plain.laws.empty());
}

TEST("forces of stiffening springs are the negative gradient of the energy") {
  const NetworkProblem problem(block(exponential, polynomial));
  const VectorXd q = shaken(problem.initial_position(), 0.3 * h, 3);
  const VectorXd still = VectorXd::Zero(q.size());
  VectorXd f(q.size());
  problem.force(0.0, 0.0, q, still, f);
  for (Eigen::Index i = 0; i < f.size(); i += 5) {
    VectorXd there = q;
    there(i) += 1e-6 * h;
    const double up = problem.energy(there, still);
    there(i) -= 2e-6 * h;
    const double down = problem.energy(there, still);
    CHECK_NEAR(f(i), -(up - down) / (2e-6 * h), 1e-5 * f.cwiseAbs().maxCoeff());
  }
}

template <class Real> double apart(const VectorXd& one, const Vector<Real>& other) {
  return (one - other.template cast<double>()).cwiseAbs().maxCoeff() / one.cwiseAbs().maxCoeff();
}

TEST("a list network has the forces, matrices and energy of stiffening springs") {
  SpringNetwork network = block(exponential, polynomial);
  for (int n = 0; n < 16; ++n) { network.fixed[static_cast<std::size_t>(n)] = 1; }
  const NetworkProblem problem(network);
  const VectorXd q = shaken(problem.initial_position(), 0.3 * h, 3);
  const VectorXd v = shaken(VectorXd::Zero(q.size()), 0.1, 4);
  VectorXd expected(q.size());
  problem.force(0.0, 0.0, q, v, expected);
  ListNetwork<double> list(problem, {}, 1e-3, true);
  VectorXd f(q.size());
  list.force(0.0, 0.0, q, v, f);
  CHECK(apart<double>(expected, f) <= 1e-13);
  CHECK_NEAR(list.energy(q, v), problem.energy(q, v), 1e-12);
  ListNetwork<float> short_list(problem, {}, 1e-3, true);
  Vector<float> g(q.size());
  short_list.force(0.0, 0.0, q.cast<float>(), v.cast<float>(), g);
  CHECK(apart<float>(expected, g) <= 1e-4);  // rounding of coordinates over extensions
  JacobianMatrix stiffness;
  JacobianMatrix damping;
  problem.jacobian(q, v, stiffness, damping);
  VectorXd up(q.size());
  VectorXd down(q.size());
  for (Eigen::Index i = 0; i < q.size(); i += 7) {
    VectorXd there = q;
    there(i) += 1e-6 * h;
    problem.force(0.0, 0.0, there, v, up);
    there(i) -= 2e-6 * h;
    problem.force(0.0, 0.0, there, v, down);
    const VectorXd column = stiffness.col(i);
    CHECK(apart<double>(column, VectorXd((down - up) / (2e-6 * h))) <= 1e-5);
  }
  Eigen::SparseMatrix<double> a;
  list.pattern(a);
  list.jacobian(q, v, 0.5, 0.25, a);
  Eigen::SparseMatrix<double> exact = 0.5 * damping + 0.25 * stiffness;
  exact.diagonal() += problem.mass();
  const Eigen::MatrixXd difference = Eigen::MatrixXd(a) - Eigen::MatrixXd(exact);
  CHECK(difference.cwiseAbs().maxCoeff() <= 1e-12 * Eigen::MatrixXd(exact).cwiseAbs().maxCoeff());
}

TEST("relaxing springs and cells have the derivative of their force in the Jacobian") {
  const NetworkProblem problem(block(relaxing, {.branches = branches}));
  ListNetwork<double> list(problem, {}, 1e-3, true);
  const VectorXd q = shaken(problem.initial_position(), 0.1 * h, 3);
  const VectorXd v = VectorXd::Zero(q.size());
  list.remember(0.01, q);
  const VectorXd later = shaken(q, 0.1 * h, 5);
  constexpr double stage = 0.02;
  Eigen::SparseMatrix<double> a;
  list.pattern(a);
  list.jacobian(later, v, stage, 1.0, a);
  Eigen::SparseMatrix<double> damping;
  list.pattern(damping);
  list.jacobian(later, v, stage, 0.0, damping);
  VectorXd up(q.size());
  VectorXd down(q.size());
  for (Eigen::Index i = 0; i < q.size(); i += 5) {
    VectorXd there = later;
    there(i) += 1e-6 * h;
    list.force(0.01 + stage, 0.0, there, v, up);
    there(i) -= 2e-6 * h;
    list.force(0.01 + stage, 0.0, there, v, down);
    const VectorXd column = VectorXd(a.col(i)) - VectorXd(damping.col(i));
    CHECK(apart<double>(column, VectorXd((down - up) / (2e-6 * h))) <= 1e-5);
  }
}

/// A network of which nothing moves but as it began: every mass is huge.
Scene held_scene(const std::string& integrator) {
  Scene scene;
  scene.tissue.source = Source::network;
  scene.simulation.step = 5e-3;
  scene.simulation.duration = 1.0;
  scene.simulation.integrator = integrator;
  scene.simulation.substeps = 2;
  scene.records = {{.name = "end", .where = 0, .quantities = {RecordedQuantity::force}}};
  return scene;
}

double recorded(Simulation& run, std::size_t column) {
  std::vector<double> row(run.columns().size());
  run.sample(row);
  return row[column];
}

TEST("a held strain relaxes, and a steady one builds up, as a Prony series says") {
  for (const char* integrator : {"euler-cromer", "leapfrog", "velocity-verlet", "rk4",
                                 "implicit-euler", "implicit-midpoint"}) {
    for (const bool held : {true, false}) {
      SpringNetwork network;
      network.rest_position.resize(3, 2);
      network.rest_position << 0.0, 0.02, 0.0, 0.0, 0.0, 0.0;
      network.mass = VectorXd::Constant(2, 1e15);
      network.fixed = {1, 0};
      MaterialLaw law{.branches = branches};
      if (held) { law.stiffening = exponential.stiffening; }
      network.springs = {{0, 1, 50.0, 0.0, 0.02, network.law_number(law)}};
      network.initial_displacement = NodeVectors::Zero(3, 2);
      network.initial_velocity = NodeVectors::Zero(3, 2);
      (held ? network.initial_displacement : network.initial_velocity)(0, 1) = 0.004;
      Simulation run(held_scene(integrator), network);
      for (int n = 0; n < 200; ++n) {
        CHECK(run.tick() == StepStatus::ok);
        const double t = run.time();
        double expected = 0.0;
        if (held) {
          double left = 1.0;
          for (const auto& b : branches) { left -= b.share * (1.0 - std::exp(-t / b.time)); }
          expected = left * 50.0 * 0.02 * (std::exp(6.0 * 0.2) - 1.0) / 6.0;
        } else {
          double reach = 0.5 * t;
          for (const auto& b : branches) {
            reach += b.share * b.time * (1.0 - std::exp(-t / b.time));
          }
          expected = 50.0 * 0.004 * reach;
        }
        CHECK_NEAR(recorded(run, 0), expected, 1e-10 * expected);
      }
    }
  }
}

TEST("a cell with volume terms relaxes as its springs do") {
  SpringNetwork network = cell_lattice({{2, 2, 2}, h, 26}, [](int, int, int) {
    CellMaterial material{.youngs_modulus = 1e4, .density = 1e19};
    material.poissons_ratio = 0.45;
    material.law.branches = branches;
    return material;
  });
  for (int n = 0; n < 4; ++n) { network.fixed[static_cast<std::size_t>(n)] = 1; }
  network.initial_displacement = NodeVectors::Zero(3, 8);
  for (int n = 4; n < 8; ++n) { network.initial_displacement(2, n) = 0.1 * h; }
  Simulation run(held_scene("implicit-euler"), network);
  const double at_once = recorded(run, 2);
  for (int n = 0; n < 200; ++n) { CHECK(run.tick() == StepStatus::ok); }
  double left = 1.0;
  for (const auto& b : branches) { left -= b.share * (1.0 - std::exp(-1.0 / b.time)); }
  CHECK_NEAR(recorded(run, 2) / at_once, left, 1e-10);
}

}  // namespace PALPATE_FILE

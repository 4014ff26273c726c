// SPDX-License-Identifier: MIT

#include <Eigen/LU>
#include <cmath>
#include <numeric>
#include <random>

#include "model/kernels/network_system.hpp"
#include "model/kernels/supernode_factors.hpp"
#include "model/kernels/system.hpp"
#include "model/stepping/constraint_compliance.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/simulation.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/tissue/lattice.hpp"
#include "tests/check.hpp"

using namespace palpate;

namespace PALPATE_FILE {

/// Laplacian of an n x n x n grid with three coordinates per node and a small diagonal term.
template <class Real> Eigen::SparseMatrix<Real> grid(int n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(0.1, 1.0);
  std::vector<Eigen::Triplet<Real>> entries;
  const int nodes = n * n * n;
  const auto tie = [&](int a, int b) {
    for (int i = 3 * a; i < 3 * a + 3; ++i) {
      const auto stiffness = static_cast<Real>(any(random));
      const int j = 3 * b + static_cast<int>(random() % 3);
      entries.emplace_back(i, i, stiffness);
      entries.emplace_back(j, j, stiffness);
      entries.emplace_back(i, j, -stiffness);
      entries.emplace_back(j, i, -stiffness);
    }
  };
  for (int node = 0; node < nodes; ++node) {
    if (node % n + 1 < n) { tie(node, node + 1); }
    if (node / n % n + 1 < n) { tie(node, node + n); }
    if (node / (n * n) + 1 < n) { tie(node, node + n * n); }
  }
  for (int i = 0; i < 3 * nodes; ++i) { entries.emplace_back(i, i, Real(0.1)); }
  Eigen::SparseMatrix<Real> matrix(3 * nodes, 3 * nodes);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Supernodes of the factors of a matrix.
template <class Real>
SupernodeFactors<Real> factors_of(
    const Eigen::SparseMatrix<Real>& matrix,
    const supernodes::Kernels& kernels = supernode_kernels().front()) {
  SupernodeFactors<Real> factors(kernels);
  Eigen::PermutationMatrix<Eigen::Dynamic> order(matrix.rows());
  for (int n = 0; n < order.rows(); ++n) { order.indices()(n) = (n + 5) % int(order.rows()); }
  CHECK(factors.factorise(matrix, order));
  return factors;
}

template <class Real>
double residual(const Eigen::SparseMatrix<Real>& matrix,
                const supernodes::Kernels& kernels = supernode_kernels().front()) {
  SupernodeFactors<Real> factors = factors_of(matrix, kernels);
  CHECK(factors.usable());
  CHECK(factors.supernode_count() <= static_cast<std::size_t>(matrix.cols()));
  const Vector<Real> right = Vector<Real>::LinSpaced(matrix.cols(), Real(-1), Real(2));
  Vector<Real> x = Vector<Real>::Zero(matrix.cols());
  factors.solve(right, x);
  return static_cast<double>((matrix * x - right).norm() / right.norm());
}

TEST("supernodes solve what the factors solve, to single precision") {
  // Condition below (12 + 0.1) / 0.1; rounding of 6e-8 along a column of up to 375 entries.
  for (const int n : {1, 2, 5}) {
    for (const supernodes::Kernels& kernels : supernode_kernels()) {
      CHECK(residual(grid<double>(n), kernels) < 120.0 * 375.0 * 6e-8);
      CHECK(residual(grid<float>(n), kernels) < 120.0 * 375.0 * 6e-8);
    }
  }
}

TEST("columns with the same rows share a supernode, and what single precision lacks is unusable") {
  Eigen::SparseMatrix<double> full = Eigen::MatrixXd::Ones(40, 40).sparseView();
  full.diagonal().array() += 40.0;
  CHECK(factors_of(full).supernode_count() == 2);  // at most 32 columns each
  CHECK_NEAR(residual(full), 0.0, 1e-6);
  Eigen::SparseMatrix<double> diagonal(4, 4);
  diagonal.setIdentity();
  CHECK_NEAR(residual<double>(4.0 * diagonal), 0.0, 1e-7);
  CHECK(!factors_of<double>(1e-60 * diagonal).usable());
}

/// Damped 3 x 3 x 3 lattice with one node displaced by `push` [m].
SpringNetwork pushed_lattice(double push) {
  SpringNetwork network = uniform_lattice({{3, 3, 3}, 0.005, 26}, 50.0, 0.5, 1e-3);
  for (std::size_t i = 18; i < 27; ++i) { network.fixed[i] = 1; }
  network.initial_displacement = NodeVectors::Zero(3, 27);
  network.initial_displacement(2, 4) = push;
  return network;
}

Scene implicit_scene(double duration, const char* integrator, Precision precision = {}) {
  Scene scene;
  scene.simulation = {.duration = duration,
                      .step = 1e-3,
                      .substeps = 1,
                      .integrator = integrator,
                      .precision = precision};
  scene.tissue.source = Source::network;
  return scene;
}

/// Runs a scene to its end or to divergence.
StepStatus run(Simulation& simulation) {
  StepStatus status = StepStatus::ok;
  while (status == StepStatus::ok && simulation.ticks() < simulation.tick_count()) {
    status = simulation.tick();
  }
  return status;
}

TEST("damped tissue comes to rest and stays there, in either precision") {
  for (const char* name : {"implicit-euler", "implicit-midpoint"}) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      for (const double push : {1e-12, 1e-9, 1e-6, 1e-3}) {
        Simulation simulation(implicit_scene(2.0, name, precision), pushed_lattice(push));
        CHECK(run(simulation) == StepStatus::ok);
        // The remaining error is rounding of positions of 0.01 m: 1e-18 m, or 1e-9 m in float.
        CHECK_NEAR(simulation.node_positions(), pushed_lattice(0.0).rest_position,
                   precision == Precision::single_precision ? 1e-8 : 1e-16);
      }
    }
  }
}

/// Position of a node 20 ticks after `start`, when a force acts on it. It stretches its springs by
/// half.
Eigen::Vector3d place_after_a_blow(double start, const char* integrator) {
  Scene scene = implicit_scene(start + 0.02, integrator);
  scene.loads = {{.nodes = {4}, .force = {0.1, 0.2, 0.3}, .start = start}};
  Simulation simulation(scene, pushed_lattice(0.0));
  CHECK(run(simulation) == StepStatus::ok);
  return simulation.node_positions().col(4);
}

TEST("a force after a rest is solved as accurately as one at the start") {
  for (const char* name : {"implicit-euler", "implicit-midpoint"}) {
    const Eigen::Vector3d at_once = place_after_a_blow(0.0, name);
    CHECK((at_once - pushed_lattice(0.0).rest_position.col(4)).norm() > 1e-3);
    CHECK_NEAR(place_after_a_blow(0.1, name), at_once, 1e-12);
  }
}

TEST("a limit of corrections bounds each step, and what it leaves decays in those that follow") {
  const auto run_with = [](int corrections, LimitedSteps& limited, Eigen::Vector3d& begin) {
    Scene scene = implicit_scene(0.2, "implicit-euler");
    scene.simulation.solver_corrections = corrections;
    scene.loads = {{.nodes = {4}, .force = {0.1, 0.2, 0.3}}};
    Simulation simulation(scene, pushed_lattice(0.0));
    while (simulation.ticks() < simulation.tick_count()) {
      CHECK(simulation.tick() == StepStatus::ok);
      if (simulation.ticks() == 10) { begin = simulation.node_positions().col(4); }
    }
    limited = simulation.limited_steps();
    return Eigen::Vector3d(simulation.node_positions().col(4));
  };
  LimitedSteps none, few;
  Eigen::Vector3d begin, begin_limited;
  const Eigen::Vector3d end = run_with(0, none, begin);
  const Eigen::Vector3d end_limited = run_with(3, few, begin_limited);
  CHECK(none.count == 0);
  CHECK(none.largest_correction == 0.0);
  CHECK(few.count > 0);
  CHECK(few.largest_correction > 0.0);
  const double moved = (end - pushed_lattice(0.0).rest_position.col(4)).norm();
  CHECK((begin_limited - begin).norm() > 1e-9 * moved);  // the limit acts
  CHECK_NEAR(begin_limited, begin, 0.05 * moved);
  CHECK_NEAR(end_limited, end, 1e-9 * moved);  // both are at rest
}

/// Stiff blocks in soft tissue.
SpringNetwork mixed_block() {
  SpringNetwork network = uniform_lattice({{5, 5, 6}, 0.003, 26}, 60.0, 0.3, 3e-5);
  for (std::size_t i = 0; i < 25; ++i) { network.fixed[i] = 1; }
  network.springs.change_each([&](Spring& spring) {
    const bool stiff = spring.a / 25 == 3 && spring.b / 25 == 3;
    if (stiff) { spring.stiffness = 6e5; }
  });
  return network;
}

/// Scene that compresses the block to half its height, so that it buckles: strongly nonlinear in
/// every step.
Scene pressed(double force) {
  Scene scene = implicit_scene(0.05, "implicit-euler");
  scene.loads = {{.nodes = {137}, .force = {0.0, 0.3 * force, -force}}};
  return scene;
}

StepStatus press_mixed_block(double force) {
  Simulation simulation(pressed(force), mixed_block());
  return run(simulation);
}

/// Returns the number of steps of the scheme alone until one has no solution; at most 50.
int steps_with_a_solution(double force) {
  const Scene scene = pressed(force);
  const NetworkProblem problem(mixed_block(), scene.loads, Eigen::Vector3d::Zero(), {});
  const StepPlan plan = plan_steps(scene, problem);
  const auto system = make_network_system<double>(problem, plan);
  State<double> state{system->initial_position(), system->initial_velocity()};
  const auto scheme = plan.integrator->make<double>();
  scheme->prepare(*system, state, plan.h);
  for (int n = 0; n < 50; ++n) {
    scheme->step(*system, state, n * plan.h, plan.h);
    if (!state.velocity.allFinite()) { return n; }
  }
  return 50;
}

TEST("steps far from linear find their solution with part of a correction") {
  for (const double force : check::sanitized ? std::vector{0.8} : std::vector{0.2, 0.4, 0.8}) {
    CHECK(press_mixed_block(force) == StepStatus::ok);
  }
}

TEST("a step without a solution is taken in halves, and one without any is divergence") {
  if (check::sanitized) { return; }  // thousands of iterations
  CHECK(steps_with_a_solution(0.8) == 50);
  CHECK(steps_with_a_solution(1.6) < 50);
  CHECK(press_mixed_block(1.6) == StepStatus::ok);
  CHECK(press_mixed_block(25.0) == StepStatus::diverged);
}

/// Position and velocity after one step on m = 1.
State<double> one_step(double theta, const Oscillator& o, double h) {
  OscillatorSystem<double> system(o);
  State<double> state{Eigen::VectorXd::Constant(1, o.displacement),
                      Eigen::VectorXd::Constant(1, o.velocity)};
  const auto scheme =
      find_integrator(theta == 1.0 ? "implicit-euler" : "implicit-midpoint")->make<double>();
  scheme->prepare(system, state, h);
  scheme->step(system, state, 0.0, h);
  return state;
}

TEST("one step on an oscillator is its closed form at any step length") {
  const Oscillator o{
      .mass = 1.0, .stiffness = 4.0, .viscosity = 0.6, .displacement = 0.3, .velocity = -0.8};
  for (const double theta : {1.0, 0.5}) {
    for (const double h : {1e-6, 1e-3, 0.1, 1.0, 1e3, 1e6}) {
      // (1 + theta h c + (theta h)^2 k) D = -h (k (x + theta h v) + c v)
      const double change = -h * (4.0 * (0.3 - theta * h * 0.8) - 0.6 * 0.8) /
                            (1.0 + theta * h * 0.6 + theta * theta * h * h * 4.0);
      const State<double> end = one_step(theta, o, h);
      CHECK_NEAR(end.velocity(0), -0.8 + change, 1e-13);
      CHECK_NEAR(end.position(0) / h, 0.3 / h - 0.8 + theta * change, 1e-13 * (1.0 + 0.3 / h));
    }
  }
}

TEST("one step is accurate to the same digits at amplitudes far from one") {
  for (const double theta : {1.0, 0.5}) {
    const Oscillator unit{.mass = 1.0, .stiffness = 4.0, .viscosity = 0.6, .displacement = 1.0};
    const double expected = one_step(theta, unit, 0.1).position(0);
    for (const double size : {1e-300, 1e-200, 1e-30, 1e30, 1e150, 1e200}) {
      Oscillator o = unit;
      o.displacement = size;
      CHECK_NEAR(one_step(theta, o, 0.1).position(0) / size, expected, 1e-13);
    }
  }
}

using Eigen::VectorXd;
using Square = Eigen::Matrix<double, 10, 10>;

using Response = ConstraintCompliance<double>;

struct Setting {
  Square p = Square::Zero();  ///< symmetric, positive definite
  Eigen::Matrix<double, 10, 1> mass{};
  Eigen::PartialPivLU<Square> factors{};

  /// Response of a tissue without a tool.
  [[nodiscard]] Response of(std::vector<Response::Support> supports) const {
    Response response;
    std::vector<std::size_t> begin(supports.size() + 1);
    std::iota(begin.begin(), begin.end(), 0U);
    response.learn(std::move(supports), begin, 0, -1, 1.0, 10, solve());
    return response;
  }
  [[nodiscard]] Response::Solve solve() const {
    return [this](const VectorXd& right, VectorXd& x) { x = factors.solve(right); };
  }
};

/// Three nodes and a tool as the last coordinate, without springs to it.
Setting setting() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Setting made;
  Square some;
  for (double& entry : some.reshaped()) { entry = any(random); }
  made.p = some * some.transpose();
  made.p.row(9).setZero();
  made.p.col(9).setZero();
  for (int node = 0; node < 3; ++node) {
    made.mass.segment<3>(3 * node).setConstant(2.0 + any(random));
  }
  made.mass(9) = 1.5;
  made.p.diagonal() += made.mass;
  made.factors.compute(made.p);
  return made;
}

TEST("a corrected solution is that of the saddle system") {
  const Setting s = setting();
  const std::vector<Response::Support> supports{{0, 0.25, 1.0 / s.mass(0)},
                                                {3, 0.75, 1.0 / s.mass(3)},
                                                {3, 0.5, 1.0 / s.mass(3)},
                                                {6, 0.5, 1.0 / s.mass(6)}};
  Response response;
  response.learn(supports, {0, 2, 4}, 0, 9, s.mass(9), 10, s.solve());
  const Eigen::Vector3d along(0.0, 0.6, 0.8);
  Eigen::Matrix<double, 2, 10> w;
  w.setZero();
  const auto knot_row = [&](std::size_t knot, const Eigen::Vector3d& direction, Eigen::Index row) {
    for (std::size_t i = 2 * knot; i < 2 * knot + 2; ++i) {
      w.row(row).segment<3>(supports[i].coordinate) += supports[i].weight * direction.transpose();
    }
  };
  response.clear();
  const auto tip = response.add_row(0, 2, 1.0);
  tip[0] = -0.3 * along;
  tip[1] = -0.7 * along;
  response.add_row(1, 1, 0.0)[0] = Eigen::Vector3d::UnitX();
  response.factorise();
  knot_row(0, -0.3 * along, 0);
  knot_row(1, -0.7 * along, 0);
  w(0, 9) = 1.0;
  knot_row(1, Eigen::Vector3d::UnitX(), 1);

  const VectorXd r = VectorXd::LinSpaced(10, -1.0, 2.0);
  VectorXd x = s.factors.solve(r);
  response.correct(r, x);
  Eigen::Matrix<double, 12, 12> saddle = Eigen::Matrix<double, 12, 12>::Zero();
  saddle.topLeftCorner(10, 10) = s.p;
  saddle.topRightCorner(10, 2) = -w.transpose();
  saddle.bottomLeftCorner(2, 10) = w;
  Eigen::Matrix<double, 12, 1> right;
  right.head(10) = r;
  right.tail(2) = w * r.cwiseQuotient(s.mass);
  const Eigen::Matrix<double, 12, 1> exact = saddle.partialPivLu().solve(right);
  CHECK_NEAR(x, VectorXd(exact.head(10)), 1e-12);
}

TEST("a force row adds its part to the matrix, beside a constraint") {
  const Setting s = setting();
  const std::vector<Response::Support> supports{{0, 1.0, 1.0 / s.mass(0)},
                                                {3, 1.0, 1.0 / s.mass(3)}};
  Response response;
  response.learn(supports, {0, 1, 2}, 1, 9, s.mass(9), 10, s.solve());
  const Eigen::Vector3d along(0.0, 0.6, 0.8);
  response.clear();
  response.add_row(0, 1, 0.0)[0] = Eigen::Vector3d::UnitX();
  const auto force = response.add_force_row(0, 2, 1.0, 0.4);
  force[0] = -0.3 * along;
  force[1] = -0.7 * along;
  response.factorise();
  VectorXd w = VectorXd::Zero(10);
  w.segment<3>(0) = -0.3 * along;
  w.segment<3>(3) = -0.7 * along;
  w(9) = 1.0;

  const VectorXd r = VectorXd::LinSpaced(10, -1.0, 2.0);
  VectorXd x = s.factors.solve(r);
  response.correct(r, x);
  Eigen::Matrix<double, 11, 11> saddle = Eigen::Matrix<double, 11, 11>::Zero();
  saddle.topLeftCorner(10, 10) = s.p + w * w.transpose() / 0.4;
  saddle(0, 10) = -1.0;
  saddle(10, 0) = 1.0;
  Eigen::Matrix<double, 11, 1> right;
  right << r, r(0) / s.mass(0);
  const Eigen::Matrix<double, 11, 1> exact = saddle.partialPivLu().solve(right);
  CHECK_NEAR(x, VectorXd(exact.head(10)), 1e-12);
}

TEST("the compliance of a row, and between two contact points, is that of the matrix") {
  const Setting s = setting();
  Response response = s.of({{0, 1.0, 1.0}, {3, 1.0, 1.0}});
  const Eigen::Vector3d along(0.0, 0.6, 0.8);
  VectorXd w = VectorXd::Zero(10);
  w.segment<3>(0) = 0.3 * along;
  w.segment<3>(3) = 0.7 * along;
  const double expected = w.dot(VectorXd(s.factors.solve(w)));
  CHECK_NEAR(response.response_at(0, 0.7, along), expected, 1e-12);
  CHECK_NEAR(response.response_at(1, 0.0, along),
             along.dot(s.factors.inverse().block<3, 3>(3, 3) * along), 1e-12);
  response.clear();
  response.add_row(1, 1, 0.0)[0] = Eigen::Vector3d::UnitX();
  const auto row = response.add_row(0, 2, 0.0);
  row[0] = 0.3 * along;
  row[1] = 0.7 * along;
  response.factorise();
  CHECK_NEAR(response.response_of(1), expected, 1e-12);
}

TEST("weights that move by up to 5 % keep the response, and the constraint stays exact") {
  const Setting s = setting();
  const auto weighed = [&](double moved) {
    return std::vector<Response::Support>{{0, 0.25 - moved, 1.0 / s.mass(0)},
                                          {3, 0.75, 1.0 / s.mass(3)},
                                          {6, moved, 1.0 / s.mass(6)}};
  };
  int solves = 0;
  Response response;
  response.learn(weighed(0.0), {0, 3}, 0, -1, 1.0, 10, [&](const VectorXd& right, VectorXd& x) {
    ++solves;
    x = s.factors.solve(right);
  });
  const VectorXd r = VectorXd::LinSpaced(10, -1.0, 2.0);
  const auto corrected = [&](double moved) {
    response.reweigh(weighed(moved), 2);
    response.clear();
    response.add_row(0, 1, 0.0)[0] = Eigen::Vector3d::UnitZ();
    response.factorise();
    VectorXd x = s.factors.solve(r);
    response.correct(r, x);
    return x;
  };
  const auto row = [&](double moved) {
    VectorXd w = VectorXd::Zero(10);
    for (const Response::Support& one : weighed(moved)) { w(one.coordinate + 2) = one.weight; }
    return w;
  };
  const auto exact = [&](double moved) {
    const VectorXd w = row(moved);
    const VectorXd answer = s.factors.solve(w);
    const VectorXd free = s.factors.solve(r);
    return VectorXd(free + answer * (w.dot(r.cwiseQuotient(s.mass)) - w.dot(free)) / w.dot(answer));
  };
  solves = 0;
  CHECK_NEAR(corrected(0.0), exact(0.0), 1e-12);
  CHECK(solves == 1);
  const VectorXd kept = corrected(0.02);  // 4 % in all
  CHECK(solves == 1);
  CHECK_NEAR(row(0.02).dot(kept), row(0.02).dot(r.cwiseQuotient(s.mass)), 1e-12);
  CHECK((kept - exact(0.02)).norm() > 1e-6);
  CHECK_NEAR(corrected(0.03), exact(0.03), 1e-12);  // 6 %
  CHECK(solves == 2);
}

TEST("without constraints the solution does not change") {
  const Setting s = setting();
  Response response = s.of({{0, 1.0, 1.0}});
  response.clear();
  response.factorise();
  VectorXd x = VectorXd::Ones(10);
  response.correct(VectorXd::Ones(10), x);
  CHECK(x == VectorXd::Ones(10));
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "model/reduction/reduced_network.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::MatrixXd;
using Eigen::SparseMatrix;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Poisson's ratios with which cells do not resist changes of their volume, and do.
const std::vector poissons_ratios{0.25, 0.45};

/// Needle on skin, fat and ligament with published moduli, 5 mm apart.
Scene scene_of(int across, double near_radius, double poissons_ratio = 0.25,
               double stiffening_rate = 0.0) {
  Scene scene;
  scene.simulation = {.duration = 0.3,
                      .step = 1e-3,
                      .integrator = "implicit-euler",
                      .solver_tolerance = 1e-4,
                      .near_radius = near_radius,
                      .far_modes = 40};
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {across, across}, .spacing = 0.005, .connectivity = 26};
  const auto tissue = [&](const std::string& name, double youngs_modulus, double cutting_force) {
    Material material{.name = name,
                      .youngs_modulus = youngs_modulus,
                      .damping_ratio = 0.5,
                      .cutting_force = cutting_force,
                      .friction = 50.0,
                      .role = TissueRole::tissue};
    if (poissons_ratio > 0.25) {
      material.poissons_ratio = poissons_ratio;
      material.damping_ratio = 0.0;
      material.retardation_time = 1e-3;
    }
    if (stiffening_rate > 0.0) { material.stiffening = Stiffening{.rate = stiffening_rate}; }
    return material;
  };
  scene.materials = {tissue("skin", 1.5e6, 3.68), tissue("fat", 9.1e3, 0.43),
                     tissue("ligament", 8e6, 2.65)};
  scene.tissue.layers = {
      {"skin", "skin", 0.002}, {"fat", "fat", 0.0048}, {"ligament", "ligament", 0.012}};
  scene.tissue.fixed = {Face::z_max, Face::x_min, Face::x_max, Face::y_min, Face::y_max};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.05};
  return scene;
}

struct Setting {
  explicit Setting(int across, double poissons_ratio = 0.25)
      : scene(scene_of(across, 0.0, poissons_ratio)), made(make_problem(scene)) {}
  [[nodiscard]] const NetworkProblem& problem() const {
    return dynamic_cast<const NetworkProblem&>(*made);
  }
  [[nodiscard]] LatticeShape shape() const { return problem().network().springs.lattice().value(); }
  [[nodiscard]] ReductionSetting leaving(int modes) const {
    return {.near = near(), .load_cases = load_cases_of(scene, problem()), .modes = modes};
  }
  /// All nodes of the box.
  [[nodiscard]] NearNodes near() const {
    NearNodes nodes{.near = {}, .box = box()};
    for (int node = 0; node < shape().node_count(); ++node) {
      nodes.near.push_back(box().holds(shape().place(node)));
    }
    return nodes;
  }
  [[nodiscard]] LatticeBox box() const {
    const LatticeShape all = shape();
    const int middle = all.nodes[0] / 2;
    return {.first = {middle - 1, middle - 1, 0},
            .last = {middle + 1, middle + 1, all.nodes[2] - 1}};
  }
  Scene scene;
  std::unique_ptr<Problem> made;
};

/// Factors of the stiffness at rest.
using Statics = Eigen::SimplicialLDLT<SparseMatrix<double>>;

Statics statics_of(const NetworkProblem& problem) {
  SparseMatrix<double> stiffness, damping;
  problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), stiffness, damping);
  return Statics(stiffness);
}

/// A - M, with A = M + d C + s K of a reduced network.
SparseMatrix<double> without_mass(NetworkSystem<double>& reduced, const VectorXd& q,
                                  const VectorXd& v, double on_damping, double on_stiffness) {
  SparseMatrix<double> a;
  reduced.pattern(a);
  reduced.jacobian(q, v, on_damping, on_stiffness, a);
  a.diagonal() -= reduced.mass();
  return a;
}

Statics statics_of(NetworkSystem<double>& reduced) {
  const VectorXd still = VectorXd::Zero(reduced.dof());
  return Statics(without_mass(reduced, reduced.initial_position(), still, 0.0, 1.0));
}

VectorXd random_vector(Eigen::Index size, double scale) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-scale, scale);
  return VectorXd::NullaryExpr(size, [&] { return any(random); });
}

VectorXd forces_of(const Scene& scene) {
  Simulation simulation(scene);
  VectorXd forces(simulation.tick_count());
  for (double& force : forces) {
    CHECK(simulation.tick() == StepStatus::ok);
    force = simulation.tool().forces.total;
  }
  return forces;
}

TEST("fewer nodes carry what is linear, and all or some nodes of the box") {
  const Setting setting(41);
  const LatticeShape shape = setting.shape();
  const auto linear = [&](int node) {
    const auto at = shape.place(node);
    return 1.0 + 0.3 * at[0] - 0.7 * at[1] + 0.2 * at[2];
  };
  const auto check = [&](const GradedLattice& graded) {
    const auto own = [&](int node) {
      const GradedLattice::Place place = graded.place_of(node);
      const auto whole = std::ranges::find(place.weight, 1.0);
      return whole == place.weight.end() ? -1 : place.coordinate[whole - place.weight.begin()];
    };
    VectorXd values = VectorXd::Zero(graded.dof());
    for (const int node : setting.problem().free_nodes()) {
      if (own(node) >= 0) { values(own(node)) = linear(node); }
    }
    int in_box = 0;
    for (const int node : setting.problem().free_nodes()) {
      in_box += own(node) >= 0 && setting.box().holds(shape.place(node)) ? 1 : 0;
      const GradedLattice::Place place = graded.place_of(node);
      double value = 0.0;
      bool beside_held = false;
      for (std::size_t c = 0; c < place.weight.size(); ++c) {
        if (place.weight[c] == 0.0) { continue; }
        beside_held = beside_held || place.coordinate[c] < 0;
        if (!beside_held) { value += place.weight[c] * values(place.coordinate[c]); }
      }
      if (!beside_held) { CHECK_NEAR(value, linear(node), 1e-12 * std::abs(linear(node)) + 1e-12); }
    }
    return in_box;
  };
  const GradedLattice narrow(setting.problem(), shape, setting.box());
  CHECK(narrow.dof() < setting.problem().dof() / 3);
  const auto free = std::ranges::count_if(setting.problem().free_nodes(), [&](int node) {
    return setting.box().holds(shape.place(node));
  });
  CHECK(check(narrow) == free);
  // A box of the whole tissue has 8405 nodes, of which at most 6000 are kept.
  const LatticeBox all{.first = {0, 0, 0},
                       .last = {shape.nodes[0] - 1, shape.nodes[1] - 1, shape.nodes[2] - 1}};
  const GradedLattice wide(setting.problem(), shape, all);
  CHECK(wide.dof() <= 3 * 6000);
  CHECK(check(wide) < free);
}

TEST("modes from fewer nodes of a large box lack as little compliance") {
  if (check::sanitized) { check::skip("compares numbers; other tests execute its code"); }
  const Setting setting(41);
  const LatticeShape shape = setting.shape();
  ReductionSetting reduction = setting.leaving(100);
  const auto lacks = [&] { return ReductionError(setting.problem(), reduction, {}).linear(); };
  const double with_all = lacks();
  reduction.near.box = {.first = {0, 0, 0},
                        .last = {shape.nodes[0] - 1, shape.nodes[1] - 1, shape.nodes[2] - 1}};
  CHECK(GradedLattice(setting.problem(), shape, reduction.near.box).dof() <= 3 * 6000);
  const double with_fewer = lacks();
  CHECK(with_all < with_fewer);
  CHECK(with_fewer < 0.02);  // a run warns above 2 %
}

TEST(
    "sums over the far field by coarse cells are those of every node, displaced linearly between") {
  for (const double poissons_ratio : poissons_ratios) {
    const Setting setting(31, poissons_ratio);
    const NetworkProblem& problem = setting.problem();
    const GradedLattice graded(problem, setting.shape(), setting.box());
    const EveryNode every(problem);
    CHECK(graded.dof() < every.dof() / 2);
    const FarNodes far = far_nodes(problem, setting.near());
    SparseMatrix<double> between(every.dof(), graded.dof());
    for (const int node : problem.free_nodes()) {
      const PointModel::Place place = graded.place_of(node);
      for (std::size_t c = 0; c < place.weight.size(); ++c) {
        if (place.coordinate[c] < 0 || place.weight[c] == 0.0) { continue; }
        for (int axis = 0; axis < 3; ++axis) {
          between.coeffRef(problem.coordinate(node) + axis, place.coordinate[c] + axis) =
              place.weight[c];
        }
      }
    }
    const auto check = [&](const SparseMatrix<double>& coarse, const SparseMatrix<double>& fine) {
      const SparseMatrix<double> whole = fine.selfadjointView<Eigen::Lower>();
      const SparseMatrix<double> found = coarse.selfadjointView<Eigen::Lower>();
      const SparseMatrix<double> expected = between.transpose() * (whole * between);
      CHECK(expected.norm() > 0.0);
      CHECK_NEAR((found - expected).norm(), 0.0, 1e-12 * expected.norm());
    };
    for (const Constant which : {Constant::stiffness, Constant::viscosity}) {
      check(graded.far_part(far, which), every.far_part(far, which));
    }
    check(graded.far_mass(far), every.far_mass(far));
  }
}

TEST("with shapes enough a far field answers to forces at rest as the whole tissue does") {
  for (const double poissons_ratio : poissons_ratios) {
    const Setting setting(9, poissons_ratio);
    const NetworkProblem& problem = setting.problem();
    const auto owner = make_reduced_network<double>(problem, setting.leaving(200));
    NetworkSystem<double>& reduced = *owner;
    CHECK(reduced.dof() < problem.dof());
    const Statics of_whole = statics_of(problem);
    const Statics of_reduced = statics_of(reduced);
    const auto loads = load_cases_of(setting.scene, problem);
    CHECK(loads.size() >= 9);  // x, y and z at three contact points or more
    for (const LoadCase& load : loads) {
      VectorXd on_whole = VectorXd::Zero(problem.dof());
      VectorXd on_reduced = VectorXd::Zero(reduced.dof());
      for (const NeedlePath::Support& s : load.on) {
        const Vector3d force = s.weight * load.direction;
        on_whole.segment<3>(problem.coordinate(s.node)) += force;
        on_reduced.segment<3>(reduced.layout().first[static_cast<std::size_t>(s.node)]) += force;
      }
      const VectorXd whole = of_whole.solve(on_whole);
      const VectorXd few = of_reduced.solve(on_reduced);
      double off = 0.0;
      for (const int each : problem.free_nodes()) {
        const Eigen::Index first = reduced.layout().first[static_cast<std::size_t>(each)];
        const Vector3d moved =
            first >= 0 ? Vector3d(few.segment<3>(first)) : reduced.moved(few, each);
        off = std::max(off, (moved - whole.segment<3>(problem.coordinate(each))).norm());
      }
      // Modes with a mass fraction below 1e-11 are omitted: 3e-6 of a displacement.
      CHECK_NEAR(off, 0.0, 3e-6 * whole.lpNorm<Eigen::Infinity>());
    }
  }
}

TEST("few shapes make the tissue stiffer, never softer, and more of them no more so") {
  for (const double poissons_ratio : poissons_ratios) {
    const Setting setting(15, poissons_ratio);
    const NetworkProblem& problem = setting.problem();
    const LatticeShape shape = setting.shape();
    const int node = shape.index(7, 7, 0);
    const Eigen::Index coordinate = problem.coordinate(node) + 2;
    const VectorXd whole = statics_of(problem).solve(VectorXd::Unit(problem.dof(), coordinate));
    double before = 0.0;
    for (const int modes : {1, 4, 40, 100}) {
      const auto owner = make_reduced_network<double>(problem, setting.leaving(modes));
      NetworkSystem<double>& reduced = *owner;
      const Eigen::Index own = reduced.layout().first[static_cast<std::size_t>(node)] + 2;
      const double moved = statics_of(reduced).solve(VectorXd::Unit(reduced.dof(), own))(own);
      CHECK(moved < whole(coordinate) * (1.0 + 1e-9));
      CHECK(moved > before * (1.0 - 1e-9));
      before = std::max(before, moved);
    }
    CHECK(before > 0.98 * whole(coordinate));  // 2 % is what a force may be off
  }
}

TEST("no other modes would leave less of the load cases' compliance out") {
  for (const double poissons_ratio : poissons_ratios) {
    const Setting setting(9, poissons_ratio);
    const NetworkProblem& problem = setting.problem();
    const NearNodes near = setting.near();
    SparseMatrix<double> stiffness, damping;
    problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), stiffness, damping);
    std::vector<int> rows;
    for (const int node : problem.free_nodes()) {
      for (int axis = 0; near.holds(node) && axis < 3; ++axis) {
        rows.push_back(static_cast<int>(problem.coordinate(node)) + axis);
      }
    }
    const auto loads = load_cases_of(setting.scene, problem);
    MatrixXd forces = MatrixXd::Zero(problem.dof(), static_cast<Eigen::Index>(loads.size()));
    for (std::size_t n = 0; n < loads.size(); ++n) {
      for (const NeedlePath::Support& s : loads[n].on) {
        forces.col(static_cast<Eigen::Index>(n)).segment<3>(problem.coordinate(s.node)) +=
            s.weight * loads[n].direction;
      }
    }
    // Without modes the far nodes stay at rest. Work of a unit by each load case: sum of shares.
    const MatrixXd whole = forces.transpose() * statics_of(problem).solve(forces);
    const MatrixXd near_forces = forces(rows, Eigen::all);
    const MatrixXd near_stiffness = MatrixXd(stiffness)(rows, rows);
    const MatrixXd none = near_forces.transpose() * near_stiffness.llt().solve(near_forces);
    const VectorXd unit = whole.diagonal().cwiseSqrt().cwiseInverse();
    const VectorXd shares = Eigen::SelfAdjointEigenSolver<MatrixXd>(
                                unit.asDiagonal() * (whole - none) * unit.asDiagonal())
                                .eigenvalues();
    for (const int modes : {1, 4, 8}) {
      const auto owner = make_reduced_network<double>(problem, setting.leaving(modes));
      const Statics of_reduced = statics_of(*owner);
      double lacking = 0.0;
      for (std::size_t n = 0; n < loads.size(); ++n) {
        VectorXd force = VectorXd::Zero(owner->dof());
        for (const NeedlePath::Support& s : loads[n].on) {
          force.segment<3>(owner->layout().first[static_cast<std::size_t>(s.node)]) +=
              s.weight * loads[n].direction;
        }
        const auto at = static_cast<Eigen::Index>(n);
        lacking += 1.0 - force.dot(of_reduced.solve(force)) / whole(at, at);
      }
      // The best of this number (C. Eckart and G. Young, Psychometrika 1, 1936). Differences of
      // compliances cancel to about 1e-12.
      const double least = shares.head(shares.size() - modes).sum();
      CHECK_NEAR(lacking, least, 1e-6 * least + 1e-9);
    }
  }
}

TEST("the compliance that too few modes lack is found without the whole stiffness") {
  for (const double poissons_ratio : check::sanitized ? std::vector{0.45} : poissons_ratios) {
    const Setting setting(15, poissons_ratio);
    const NetworkProblem& problem = setting.problem();
    const Statics of_whole = statics_of(problem);
    double before = 1.0;
    for (const int modes : {4, 40, 200}) {
      const auto owner = make_reduced_network<double>(problem, setting.leaving(modes));
      const Statics of_reduced = statics_of(*owner);
      double lacking = 0.0;
      for (const LoadCase& load : load_cases_of(setting.scene, problem)) {
        if (load.direction.z() == 0.0) { continue; }
        VectorXd on_whole = VectorXd::Zero(problem.dof());
        VectorXd on_reduced = VectorXd::Zero(owner->dof());
        for (const NeedlePath::Support& s : load.on) {
          on_whole(problem.coordinate(s.node) + 2) += s.weight;
          on_reduced(owner->layout().first[static_cast<std::size_t>(s.node)] + 2) += s.weight;
        }
        const double whole = on_whole.dot(of_whole.solve(on_whole));
        const double reduced = on_reduced.dot(of_reduced.solve(on_reduced));
        lacking = std::max(lacking, 1.0 - reduced / whole);
      }
      const ReductionError error(problem, setting.leaving(modes), Vector3d::UnitZ());
      CHECK(error.linear() < lacking * (1.0 + 1e-6) + 1e-9);  // conjugate gradients from below
      CHECK_NEAR(error.linear(), lacking, 0.1 * lacking + 1e-9);
      CHECK(error.linear() < before + 1e-12);  // modes enough leave rounding
      before = error.linear();
    }
  }
}

TEST("forces of a far field are the slope of its energy, and its matrices theirs") {
  for (const double poissons_ratio : poissons_ratios) {
    const Setting setting(13, poissons_ratio);
    const auto owner = make_reduced_network<double>(setting.problem(), setting.leaving(30));
    NetworkSystem<double>& reduced = *owner;
    const Eigen::Index n = reduced.dof();
    const VectorXd q = reduced.initial_position() + random_vector(n, 1e-3);
    const VectorXd v = random_vector(n, 1e-2).reverse();
    const VectorXd way = random_vector(n, 1.0).reverse();
    const VectorXd still = VectorXd::Zero(n);
    constexpr double step = 1e-7;
    const auto force = [&](const VectorXd& at, const VectorXd& speed) {
      VectorXd f(n);
      reduced.force(0.0, 0.0, at, speed, f);
      return f;
    };
    const VectorXd there = q + step * way;
    const VectorXd back = q - step * way;
    const double slope =
        (reduced.energy(there, still) - reduced.energy(back, still)) / (2.0 * step);
    const VectorXd f = force(q, still);
    CHECK_NEAR(slope, -f.dot(way), 1e-6 * f.norm() * way.norm());
    const VectorXd by_matrix = without_mass(reduced, q, v, 0.0, 1.0) * way;
    const VectorXd by_force = (force(back, v) - force(there, v)) / (2.0 * step);
    CHECK_NEAR((by_matrix - by_force).norm(), 0.0, 1e-5 * by_force.norm());
    const VectorXd damped = without_mass(reduced, q, v, 1.0, 0.0) * way;
    const VectorXd resisted = force(q, still) - force(q, way);
    CHECK_NEAR((damped - resisted).norm(), 0.0, 1e-9 * resisted.norm());
    VectorXd damping(n);
    reduced.damping(q, way, damping);
    CHECK_NEAR((damping - resisted).norm(), 0.0, 1e-9 * resisted.norm());
    VectorXd measured(n);
    const double energy = reduced.measure(0.0, 0.0, q, v, measured);
    CHECK_NEAR((measured - force(q, v)).norm(), 0.0, 1e-12 * measured.norm());
    CHECK_NEAR(energy + reduced.unmeasured_energy(q), reduced.energy(q, still), 1e-12 * energy);
  }
}

TEST("a needle in a reduced block feels what it feels in the whole one") {
  if (check::sanitized) { check::skip("compares numbers; other tests execute its code"); }
  for (const double poissons_ratio : poissons_ratios) {
    const VectorXd whole = forces_of(scene_of(15, 0.0, poissons_ratio));
    const VectorXd reduced = forces_of(scene_of(15, 0.015, poissons_ratio));
    const VectorXd cut_off = forces_of(scene_of(9, 0.0, poissons_ratio));
    CHECK(whole.maxCoeff() > 1.0);
    // Requirement on the reduced-order model: 2 % of the largest force.
    CHECK_NEAR(reduced, whole, 0.02 * whole.maxCoeff());
    CHECK((cut_off - whole).lpNorm<Eigen::Infinity>() >
          5.0 * (reduced - whole).lpNorm<Eigen::Infinity>());
  }
}

ReductionError::Moment at(const NodeVectors& position, std::optional<double> tip = {},
                          double contact = 0.0) {
  return {.position = &position, .tip = tip, .contact = contact};
}

TEST("tissue that stiffens has a far field, and its error is estimated") {
  if (check::sanitized) { check::skip("compares numbers; other tests execute its code"); }
  // A force presses on the skin until the tissue rests.
  const auto pressed = [](double near_radius, double force) {
    Scene scene = scene_of(11, near_radius, 0.45, 30.0);
    scene.needle.reset();
    scene.drive.reset();
    scene.loads = {{.nodes = {11 * 5 + 5}, .force = {0.0, 0.0, force}}};
    scene.simulation.duration = 1.0;
    return scene;
  };
  Simulation whole(pressed(0.0, 2.0));
  Simulation more(pressed(0.0, 2.2));
  Simulation gentle(pressed(0.0, 0.02));
  Simulation reduced(pressed(0.006, 2.0));
  REQUIRE(reduced.plan().far != nullptr);
  for (Simulation* each : {&whole, &more, &gentle, &reduced}) {
    while (each->ticks() < each->tick_count()) { CHECK(each->tick() == StepStatus::ok); }
  }
  const auto& problem = dynamic_cast<const NetworkProblem&>(reduced.problem());
  const auto moved = [&](const Simulation& of) {
    return (of.node_positions() - problem.network().rest_position).col(11 * 5 + 5).z();
  };
  CHECK(moved(whole) < 0.7 * 100.0 * moved(gentle));
  const double stiffness = 0.2 / (moved(more) - moved(whole));
  const double off = stiffness * (moved(reduced) - moved(whole));
  CHECK(off > 0.1 * 2.0);
  const ReductionError estimate(problem, *reduced.plan().far, Vector3d::Zero());
  CHECK_NEAR(estimate.nonlinear_there(at(reduced.node_positions())), off, 0.2 * off);
  // With more of the tissue near, the rest is small.
  Simulation wider(pressed(0.0155, 2.0));
  while (wider.ticks() < wider.tick_count()) { CHECK(wider.tick() == StepStatus::ok); }
  CHECK_NEAR(moved(wider), moved(whole), 0.02 * moved(whole));
}

TEST("the force that a far field adds is felt through the compliance of the contact") {
  // The tip dents the skin, which is not cut, and rests.
  const auto force_of = [](double near_radius, Simulation* keep) {
    Scene scene = scene_of(11, near_radius, 0.45, 20.0);
    scene.drive->depth = 0.005;
    scene.drive->speed = 0.025;
    scene.simulation.solver_tolerance = 0.0;
    scene.materials.front().cutting_force = 1e3;
    scene.materials[1].youngs_modulus = 1.5e6;
    scene.simulation.duration = 0.5;
    Simulation simulation(scene);
    while (simulation.ticks() < simulation.tick_count()) {
      CHECK(simulation.tick() == StepStatus::ok);
    }
    const double force = simulation.tool().forces.total;
    if (keep != nullptr) { *keep = std::move(simulation); }
    return force;
  };
  Simulation reduced(scene_of(9, 0.0));
  const double here = force_of(0.004, &reduced);
  const double off = std::abs(here - force_of(0.0, nullptr));
  const auto& problem = dynamic_cast<const NetworkProblem&>(reduced.problem());
  const ReductionError estimate(problem, *reduced.plan().far, Vector3d::UnitZ());
  const NodeVectors position = reduced.node_positions();
  const double contact = reduced.plan().tip.at(0.0);
  const double there = estimate.nonlinear_there(at(position, 0.0, contact));
  CHECK_NEAR(there, off, 0.2 * off);
  CHECK(estimate.nonlinear_there(at(position, 0.0)) > 3.0 * off);
}

TEST("tissue that is no regular lattice has a far field, which is exact for its load cases") {
  const Setting setting(11, 0.45);
  SpringNetwork cut = setting.problem().network();
  const LatticeShape shape = setting.shape();
  const auto is_gone = [&](int node) {
    const auto place = shape.place(node);
    return place[0] + place[1] < 5;
  };
  std::vector<Spring> springs = cut.springs.listed();
  std::erase_if(springs, [&](const Spring& s) { return is_gone(s.a) || is_gone(s.b); });
  cut.springs = SpringList(springs, std::nullopt);
  std::erase_if(cut.cells,
                [&](const VolumeCell& cell) { return std::ranges::any_of(cell.nodes, is_gone); });
  for (int node = 0; node < cut.node_count(); ++node) {
    if (is_gone(node)) { cut.fixed[static_cast<std::size_t>(node)] = 1; }
  }
  const NetworkProblem problem(std::move(cut), {});
  REQUIRE(!problem.network().springs.lattice());
  Scene scene = setting.scene;
  const NearChoice choice = choose_near_nodes(scene, problem, 0.011);
  REQUIRE(choice.nodes.has_value());
  const ReductionSetting near{
      .near = *choice.nodes, .load_cases = load_cases_of(scene, problem), .modes = 40};
  const auto owner = make_reduced_network<double>(problem, near);
  CHECK(owner->dof() < 2 * problem.dof() / 3);
  const Statics of_whole = statics_of(problem);
  const Statics of_reduced = statics_of(*owner);
  for (const LoadCase& load : near.load_cases) {
    VectorXd on_whole = VectorXd::Zero(problem.dof());
    VectorXd on_reduced = VectorXd::Zero(owner->dof());
    for (const NeedlePath::Support& s : load.on) {
      const Eigen::Index own = owner->layout().first[static_cast<std::size_t>(s.node)];
      on_whole.segment<3>(problem.coordinate(s.node)) += s.weight * load.direction;
      on_reduced.segment<3>(own) += s.weight * load.direction;
    }
    const double whole = on_whole.dot(of_whole.solve(on_whole));
    CHECK_NEAR(on_reduced.dot(of_reduced.solve(on_reduced)), whole, 1e-5 * whole);
  }
}

TEST("tissue with more nodes than are factorised has its modes from a coarser lattice") {
  const Setting setting(41);
  CHECK(setting.problem().free_nodes().size() > 5000);
  const ReductionError error(setting.problem(), setting.leaving(40), Vector3d::UnitZ());
  CHECK(error.linear() < 0.02);  // 2 % is what a force may be off
  CHECK(error.linear() > 1e-6);  // not those of every node
}

TEST("a probe that slides over a reduced block feels what it feels on the whole one") {
  const auto forces = [](double near_radius) {
    Scene scene = scene_of(15, near_radius);
    scene.needle.reset();
    scene.probe =
        Probe{.size = {0.008, 0.012}, .path = {{{0.05, -0.012, 0.002}, {0.35, 0.012, -0.004}}}};
    scene.drive = Drive{.speed = 0.02, .depth = 0.001};
    scene.simulation.duration = 0.4;
    scene.simulation.far_modes = 24;
    return forces_of(scene);
  };
  const VectorXd whole = forces(0.0);
  CHECK(whole.maxCoeff() > 0.1);
  CHECK_NEAR(forces(0.011), whole, 0.02 * whole.maxCoeff());
}

TEST("nodes of a far field have their positions in the output") {
  Scene exact = scene_of(11, 0.0);
  exact.simulation.solver_tolerance = 0.0;
  Simulation whole(exact);
  exact.simulation.near_radius = 0.01;
  exact.simulation.far_modes = 150;
  Simulation reduced(exact);
  CHECK(reduced.plan().far != nullptr);
  for (int n = 0; n < 20; ++n) {
    (void)whole.tick();
    (void)reduced.tick();
  }
  const NodeVectors rest = Simulation(scene_of(11, 0.0)).node_positions();
  const NodeVectors there = whole.node_positions();
  const NodeVectors here = reduced.node_positions();
  const int beside = 11 * 5 + 2;  // on the skin, outside the box
  double far_motion = 0.0;
  double off = 0.0;
  for (int node = 0; node < static_cast<int>(rest.cols()); ++node) {
    off = std::max(off, (here.col(node) - there.col(node)).norm());
    if (reduced.plan().far->near.holds(node)) { continue; }
    far_motion = std::max(far_motion, (there.col(node) - rest.col(node)).norm());
  }
  // The tissue outside the box is not exactly linear: 5 % of its displacement.
  CHECK_NEAR(off, 0.0, 0.05 * far_motion);
  VectorXd q(whole.problem().dof());
  reduced.coordinates(q);
  const auto& problem = dynamic_cast<const NetworkProblem&>(reduced.problem());
  CHECK_NEAR((q.segment<3>(problem.coordinate(beside)) - here.col(beside)).norm(), 0.0, 0.0);
}

/// Cube fixed on one face and pulled at the middle of the opposite face.
Scene pulled_cube(double near_radius, int far_modes) {
  Scene scene;
  scene.simulation = {.duration = 0.05,
                      .step = 1e-3,
                      .integrator = "rk4",
                      .near_radius = near_radius,
                      .far_modes = far_modes};
  scene.simulation.substeps = 1;
  scene.tissue.fixed = std::vector<Face>{Face::z_min};
  scene.tissue.lattice = uniform_cube(9);
  scene.loads = {{.nodes = {(8 * 9 + 4) * 9 + 4}, .force = {0.0, 0.0, 0.1}}};
  return scene;
}

/// Largest deviation of the pulled node from the full integration of every node, relative to its
/// largest displacement.
double error_of_far_field(const Scene& scene) {
  Scene all = scene;
  all.simulation.near_radius = 0.0;
  Simulation whole(all);
  Simulation reduced(scene);
  CHECK(reduced.plan().far != nullptr);
  CHECK(!reduced.plan().integrator->implicit);
  CHECK(!reduced.plan().lattice);
  const int node = scene.loads.front().nodes.front();
  const Vector3d rest = whole.node_positions().col(node);
  double peak = 0.0;
  double off = 0.0;
  while (whole.ticks() < whole.tick_count()) {
    CHECK(whole.tick() == StepStatus::ok);
    CHECK(reduced.tick() == StepStatus::ok);
    const Vector3d there = whole.node_positions().col(node);
    peak = std::max(peak, (there - rest).norm());
    off = std::max(off, (reduced.node_positions().col(node) - there).norm());
  }
  return off / peak;
}

TEST("more modes bring the pulled node nearer, up to the nonlinear part, which follows the load") {
  double before = 1.0;
  for (const int modes : {3, 6, 12}) {
    const double error = error_of_far_field(pulled_cube(0.025, modes));
    CHECK(error < 0.2 * before);
    before = error;
  }
  Scene gentle = pulled_cube(0.025, 24);
  const double at_full_load = error_of_far_field(gentle);
  gentle.loads.front().force *= 0.1;
  CHECK_NEAR(error_of_far_field(gentle), 0.1 * at_full_load, 0.02 * at_full_load);
}

TEST(
    "the force that linear springs add is estimated to a third about rest, and closer where they "
    "are") {
  if (check::sanitized) { check::skip("compares numbers; other tests execute its code"); }
  Scene scene = pulled_cube(0.025, 24);
  scene.loads.front().force *= 3.0;
  scene.simulation.duration = 4.0;  // then at rest
  Scene all = scene;
  all.simulation.near_radius = 0.0;
  Simulation whole(all);
  Simulation reduced(scene);
  while (whole.ticks() < whole.tick_count()) {
    (void)whole.tick();
    (void)reduced.tick();
  }
  const int node = scene.loads.front().nodes.front();
  const auto& problem = dynamic_cast<const NetworkProblem&>(reduced.problem());
  const double moved = (whole.node_positions() - problem.network().rest_position).col(node).norm();
  const double error = (reduced.node_positions() - whole.node_positions()).col(node).norm() / moved;
  const ReductionError estimate(problem, *reduced.plan().far, Vector3d::Zero());
  CHECK(error > 10.0 * estimate.linear());
  CHECK_NEAR(estimate.nonlinear(at(reduced.node_positions())) / scene.loads.front().force.norm(),
             error, 0.33 * error);
  CHECK_NEAR(
      estimate.nonlinear_there(at(reduced.node_positions())) / scene.loads.front().force.norm(),
      error, 0.15 * error);
  CHECK_NEAR(estimate.nonlinear(at(problem.network().rest_position)), 0.0, 1e-12);
  CHECK_NEAR(estimate.nonlinear_there(at(problem.network().rest_position)), 0.0, 1e-12);
}

TEST("the force that linear springs add to a needle is that at its tip") {
  Scene scene = scene_of(11, 0.006);
  scene.drive->depth = 0.002;  // the skin is not cut
  Simulation run(scene);
  while (run.ticks() < 40) { (void)run.tick(); }
  const auto& problem = dynamic_cast<const NetworkProblem&>(run.problem());
  const ReductionError estimate(problem, *run.plan().far, Vector3d::UnitZ());
  const NodeVectors position = run.node_positions();
  const double anywhere = estimate.nonlinear(at(position));
  double largest = 0.0;
  double least = anywhere;
  for (double tip = -0.001; tip < 0.025; tip += 0.001) {
    const double force = estimate.nonlinear(at(position, tip));
    CHECK(force <= anywhere);
    largest = std::max(largest, force);
    least = std::min(least, force);
  }
  CHECK_NEAR(largest, anywhere, 0.0);
  CHECK(least < 0.5 * anywhere);
}

/// Returns the number of near nodes; all free ones without a far field.
std::ptrdiff_t near_count(const Simulation& of) {
  const auto& problem = dynamic_cast<const NetworkProblem&>(of.problem());
  return std::ranges::count_if(problem.free_nodes(), [&](int node) {
    return of.plan().far == nullptr || of.plan().far->near.holds(node);
  });
}

TEST("a chosen far field is the smallest that keeps the wanted error of the force") {
  if (check::sanitized) { check::skip("compares numbers; other tests execute its code"); }
  // A needle cuts skin and fat; a force dents stiffening tissue deeply.
  Scene cut = scene_of(11, 0.0, 0.45);
  Scene dented = scene_of(11, 0.0, 0.45, 30.0);
  dented.drive = Drive{.kind = Drive::Kind::force, .force = 2.0, .rise = 0.1};
  dented.needle.reset();
  dented.probe = Probe{};
  for (Scene scene : {cut, dented}) {
    const Simulation all(scene);
    const VectorXd whole = forces_of(scene);
    scene.simulation.near_radius.reset();
    std::ptrdiff_t before = 0;
    for (const double wanted : {0.2, 0.02, 0.002, 0.0}) {
      scene.simulation.force_error = wanted;
      const Simulation chosen(scene);
      CHECK(!chosen.plan().far_reason.empty());
      CHECK(near_count(chosen) >= before);
      before = near_count(chosen);
      if (wanted == 0.0) {
        CHECK(chosen.plan().far == nullptr);
        CHECK(chosen.plan().far_reason.find("is expected to change") != std::string::npos);
        continue;
      }
      // Forces jump where a layer is cut a tick earlier or later.
      const VectorXd off = (forces_of(scene) - whole).cwiseAbs();
      const auto beyond = (off.array() > wanted * whole.maxCoeff()).count();
      CHECK(beyond <= 3);
    }
    CHECK(before == near_count(all));
  }
}

TEST("near is what lies within the radius of a pushed node, along every line") {
  const Simulation simulation(pulled_cube(0.02, 8));
  const NodeVectors rest = simulation.node_positions();
  const Vector3d middle = rest.col(pulled_cube(0.0, 1).loads.front().nodes.front());
  for (int node = 0; node < static_cast<int>(rest.cols()); ++node) {
    CHECK(simulation.plan().far->near.holds(node) ==
          ((rest.col(node) - middle).norm() < 0.02 + 1e-9));
  }
}

TEST("below the contact point after the end of a trajectory no node is near") {
  Scene scene = scene_of(9, 0.004);
  scene.drive->depth = 0.004;
  const Simulation simulation(scene);
  const NodeVectors rest = simulation.node_positions();
  const auto deepest = [&](const Simulation& of) {
    double depth = 0.0;
    for (int node = 0; node < static_cast<int>(rest.cols()); ++node) {
      if (of.plan().far->near.holds(node)) { depth = std::max(depth, rest(2, node)); }
    }
    return depth;
  };
  CHECK_NEAR(deepest(simulation), 0.01, 1e-12);  // and one contact point more
  if (check::sanitized) { return; }              // compares forces; other tests execute the code

  // The needle comes to 4 mm, rests and goes back.
  scene.drive->hold = 0.05;
  scene.drive->withdraw_speed = 0.05;
  const auto error = [&](Scene other) {
    const VectorXd reduced = forces_of(other);
    other.simulation.near_radius = 0.0;
    const VectorXd whole = forces_of(other);
    return (reduced - whole).lpNorm<Eigen::Infinity>() / whole.maxCoeff();
  };
  const double with_end = error(scene);
  scene.drive->depth = 0.012;  // all contact points
  CHECK(deepest(Simulation(scene)) > 0.011);
  const double with_all = error(scene);
  CHECK(with_all < 0.03);
  CHECK(with_end < with_all + 0.005);
}

TEST("near nodes may begin in motion, far ones may not") {
  const Scene scene = scene_of(9, 0.004);
  SpringNetwork network = build_network(scene);
  const auto near = Simulation(scene, network).plan().far->near;
  const auto far_with = [&](bool all) {
    network.initial_velocity = NodeVectors::Zero(3, network.node_count());
    for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
      if (all || near.holds(node)) { network.initial_velocity.col(node).setConstant(0.01); }
    }
    Simulation simulation(scene, network);
    VectorXd velocities(3 * std::ranges::count(network.fixed, 0));
    simulation.velocities(velocities);
    CHECK_NEAR(velocities.maxCoeff(), 0.01, 0.0);
    CHECK_NEAR(velocities.minCoeff(), all ? 0.01 : 0.0, 0.0);
    return simulation.plan().far != nullptr;
  };
  CHECK(far_with(false));
  CHECK(!far_with(true));
  // A support that is displaced pulls at the far nodes around it.
  network.initial_velocity.resize(3, 0);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  CHECK(Simulation(scene, network).plan().far != nullptr);
  network.initial_displacement(0, std::ranges::find(network.fixed, 1) - network.fixed.begin()) =
      1e-3;
  CHECK(Simulation(scene, network).plan().far == nullptr);
}

TEST("an implicit scheme refuses more nodes than it can factorise") {
  Scene scene = pulled_cube(0.0, 1);
  scene.tissue.lattice.nodes = {47, 47, 47};
  scene.simulation.integrator = "implicit-euler";
  CHECK_THROWS_AS(std::invalid_argument, Simulation(scene), "factorises the stiffness of 101614");
}

TEST("a step that is stable for the whole tissue is stable with a far field") {
  for (const int modes : {1, 10, 100}) {
    Scene scene = pulled_cube(0.015, modes);
    scene.simulation.integrator = "velocity-verlet";
    scene.simulation.duration = 2.0;
    scene.simulation.step =
        0.9 * Simulation(pulled_cube(0.0, 1)).plan().stable_step.at("velocity-verlet");
    Simulation simulation(scene);
    while (simulation.ticks() < simulation.tick_count()) {
      CHECK(simulation.tick() == StepStatus::ok);
      CHECK(simulation.energy() < 0.1 * 2e-3);  // work of a load of 0.1 N over less than 2 mm
    }
  }
}

TEST("gravity, printed equations, and tissue that nothing holds or pushes keep every node") {
  Scene heavy = pulled_cube(0.02, 8);
  heavy.tissue.gravity = {0.0, 0.0, 9.81};
  const Scene near_alone = pulled_cube(1.0, 8);
  Scene without_push = pulled_cube(0.02, 8);
  without_push.loads.clear();
  Scene floating = pulled_cube(0.02, 8);
  floating.tissue.fixed = std::vector<Face>{};
  Scene pulled_where_held = pulled_cube(0.02, 8);
  pulled_where_held.loads.front().nodes = {4};
  Scene printed = pulled_cube(0.02, 8);
  printed.simulation.integrator = "euler-cromer";
  printed.simulation.printed.half_force = true;
  for (const Scene& scene :
       {heavy, near_alone, without_push, floating, pulled_where_held, printed}) {
    const Simulation simulation(scene);
    CHECK(simulation.plan().far == nullptr);
    CHECK(std::ranges::any_of(simulation.plan().warnings, [](const std::string& w) {
      return w.starts_with("nothing is left to a far field: ");
    }));
  }
  CHECK(Simulation(pulled_cube(0.02, 8), false).plan().far == nullptr);
}

TEST("with a far field \"auto\" is explicit where few substeps suffice and implicit elsewhere") {
  Scene scene = pulled_cube(0.02, 8);
  scene.simulation.integrator = "auto";
  scene.simulation.substeps.reset();
  CHECK(!Simulation(scene).plan().integrator->implicit);
  scene.tissue.lattice.stiffness *= 1e6;
  CHECK(Simulation(scene).plan().integrator->implicit);
}

TEST("a far field that a push does not reach has no shapes and stays at rest") {
  const Scene scene = pulled_cube(0.02, 8);
  const auto made = make_problem(scene);
  const auto& problem = dynamic_cast<const NetworkProblem&>(*made);
  SpringNetwork walled = problem.network();
  for (int n = 0; n < 81; ++n) { walled.fixed[static_cast<std::size_t>(5 * 81 + n)] = 1; }
  const NetworkProblem beyond_a_wall(walled, problem.loads());
  ReductionSetting setting{.near = {.near = std::vector<unsigned char>(729, 0),
                                    .box = {.first = {0, 0, 6}, .last = {8, 8, 8}}},
                           .load_cases = load_cases_of(scene, beyond_a_wall),
                           .modes = 8};
  std::fill(setting.near.near.begin() + 6 * 81, setting.near.near.end(),
            static_cast<unsigned char>(1));
  const auto owner = make_reduced_network<double>(beyond_a_wall, setting);
  NetworkSystem<double>& reduced = *owner;
  CHECK(reduced.dof() == 3 * 3 * 81);
  const VectorXd q = reduced.initial_position();
  CHECK_NEAR(reduced.moved(q, 3 * 81 + 40).norm(), 0.0, 0.0);
  VectorXd f(reduced.dof());
  reduced.force(0.0, 0.0, q, VectorXd::Zero(reduced.dof()), f);
  CHECK_NEAR(f.norm(), 0.1, 1e-12);
}

TEST("tissue fixed at a single node has no static response") {
  const Scene scene = pulled_cube(0.02, 8);
  const auto made = make_problem(scene);
  const auto& problem = dynamic_cast<const NetworkProblem&>(*made);
  SpringNetwork hung = problem.network();
  std::fill(hung.fixed.begin() + 1, hung.fixed.end(), static_cast<unsigned char>(0));
  const NetworkProblem turning(hung, problem.loads());
  const GradedLattice graded(turning, hung.springs.lattice().value(),
                             {.first = {2, 2, 6}, .last = {6, 6, 8}});
  CHECK(!StaticSolver(graded.stiffness(), graded.places()).held());
}

TEST("static responses solve K x = F, in the order of the rows of K") {
  const Scene scene = pulled_cube(0.02, 8);
  const auto made = make_problem(scene);
  const auto& problem = dynamic_cast<const NetworkProblem&>(*made);
  const GradedLattice graded(problem, problem.network().springs.lattice().value(),
                             {.first = {2, 2, 6}, .last = {6, 6, 8}});
  const auto check = [](const auto& model) {
    const Eigen::SparseMatrix<double> k = model.stiffness();
    const StaticSolver statics(k, model.places());
    REQUIRE(statics.held());
    const VectorXd force = VectorXd::LinSpaced(model.dof(), -1.0, 2.0);
    const VectorXd x = statics.respond(force);
    CHECK_NEAR((k.selfadjointView<Eigen::Lower>() * x - force).norm(), 0.0, 1e-9 * force.norm());
  };
  check(graded);
  check(EveryNode(problem));
}

}  // namespace PALPATE_FILE

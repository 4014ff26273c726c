// SPDX-License-Identifier: MIT

#include "model/stepping/step_plan.hpp"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>

#include "model/kernels/lattice_network.hpp"
#include "model/kernels/lattice_rows.hpp"
#include "model/kernels/list_network.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/problem/rules.hpp"
#include "model/reduction/mode_basis.hpp"
#include "model/reduction/reduced_network.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/stability.hpp"

namespace palpate {

namespace {

/// Number of explicit substeps per tick above which an implicit scheme is chosen: the midpoint
/// rule, or with a tool implicit Euler, which damps the oscillations after changes between sticking
/// and slipping.
constexpr int most_automatic_substeps = 200;
constexpr int most_automatic_substeps_with_tool = 25;
/// Limits for large networks. The cost of the factorisation of an implicit step grows with the
/// square of the number of nodes, but a tick with the factors is cheaper than many explicit
/// substeps.
constexpr std::size_t most_nodes_factorised = 8000;
constexpr int most_automatic_substeps_of_many = 1000;

const std::string no_far_field = "nothing is left to a far field: ";

std::string number(double value) { return number_in_words(value, 3); }

/// Returns the number of substeps per tick that keeps h at stability_margin of the limit.
double substeps_for(double step, double limit) {
  if (!std::isfinite(limit)) { return 1.0; }
  return limit > 0.0 ? std::max(1.0, std::ceil(step / (stability_margin * limit)))
                     : std::numeric_limits<double>::infinity();
}

std::string far_field_text(const ReductionSetting& setting, long far_nodes) {
  return "nodes further than " + number(setting.radius) +
         " m from what is pushed: " + std::to_string(far_nodes) + ", linear about rest in " +
         std::to_string(setting.modes) + " modes";
}

/// Share of simulation.force_error that a chosen reduced-order model may cause. The rest is left to
/// spacing, step and solver.
constexpr double share_of_reduction = 0.5;
/// Number of free nodes up to which a reduced-order model is chosen: several are tried at load, and
/// the expected error of each takes seconds in larger tissue.
constexpr std::size_t most_nodes_chosen_for = 10'000;

/// Returns the depth on its line that a tool on a trajectory reaches [m].
double end_of_trajectory(const Scene& scene, const Drive& drive) {
  return drive.depth.value_or(drive.from + drive.speed * scene.simulation.duration);
}

/// Returns the force with which the tool is expected to press where its tip is at a depth [m] and
/// the tissue has a compliance [m/N].
ReductionError::Push expected_push(const Scene& scene, const NeedlePath& path,
                                   const TipCompliance& tip, double depth, double compliance) {
  const Drive drive = scene.drive.value_or(Drive{});
  const std::vector<PathInterval>& intervals = path.intervals();
  const std::size_t here = path.interval_at(std::max(depth, 0.0));
  const DentLaw law = tip.law(depth, intervals[here].indentation_toe, here);
  ReductionError::Push push{.force = drive.force,
                            .contact = law.is_linear() ? law.compliance : 0.0};
  if (scene.needle) {
    std::vector<double> limits(path.knots().size());
    push.force = path.friction(depth, limits);
    double cutting = 0.0;
    for (std::size_t n = 0; n <= here; ++n) {
      push.force += path.friction(n, depth, limits);
      const double force = std::max(intervals[n].puncture_force, intervals[n].cutting_force);
      if (std::isfinite(force)) { cutting = force; }  // bone stops the needle
    }
    push.force += cutting;
  }
  if (drive.kind == Drive::Kind::trajectory) {
    const double most = end_of_trajectory(scene, drive) / (compliance + push.contact);
    push.force = scene.needle ? std::min(push.force, most) : most;
  }
  return push;
}

/// Returns the expected shares of the force that the modes and the linear springs of a
/// reduced-order model lose.
std::pair<double, double> expected_error(const Scene& scene, const NetworkProblem& problem,
                                         const StepPlan& plan, const ReductionSetting& setting) {
  const double small = 0.5 * share_of_reduction * scene.simulation.force_error;
  if (!scene.needle && !scene.probe) {
    double largest = 0.0;
    for (const Load& load : problem.loads()) { largest = std::max(largest, load.force.norm()); }
    const ReductionError error(problem, setting, Eigen::Vector3d::Zero());
    return {error.linear(),
            error.expected([&](double, double) { return ReductionError::Push{.force = largest}; },
                           small)};
  }
  const NeedlePath path(scene, problem.network());
  const ReductionError error(problem, setting, path.direction());
  const double skin = path.direction().dot(path.origin());
  const auto push = [&](double place, double compliance) {
    return expected_push(scene, path, plan.tip, place - skin, compliance);
  };
  return {error.linear(), error.expected(push, small)};
}

/// Returns the mean length of the springs [m].
double mean_length(const SpringNetwork& network) {
  double sum = 0.0;
  for (const Spring& spring : network.springs) {
    sum += (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).norm();
  }
  return network.springs.empty() ? 0.0 : sum / static_cast<double>(network.springs.size());
}

std::string percent(double share) { return number(100.0 * share) + " %"; }

/// Chooses the smallest reduced-order model whose expected error is allowed.
void choose_far(const Scene& scene, const NetworkProblem& problem, StepPlan& plan) {
  const double allowed = share_of_reduction * scene.simulation.force_error;
  const double length = mean_length(problem.network());
  const std::string whole = "every node is integrated: ";
  if (problem.free_nodes().size() > most_nodes_chosen_for) {
    plan.far_reason = whole + "tissue of more than " + std::to_string(most_nodes_chosen_for) +
                      " free nodes needs simulation.near_radius in metres";
    plan.warnings.push_back(plan.far_reason);
    return;
  }
  const std::vector<LoadCase> load_cases = load_cases_of(scene, problem);
  std::ptrdiff_t near_before = -1;
  std::string least;
  // The first are the loaded nodes alone; the others grow by about a cell.
  for (const double lengths : {0.1, 0.75, 1.5, 2.25, 3.0}) {
    const double radius = lengths * length;
    NearChoice choice = choose_near_nodes(scene, problem, radius);
    if (!choice.nodes) {
      if (!least.empty()) { break; }  // no far node is left
      plan.far_reason = whole + choice.obstacle;
      return;
    }
    const auto near = std::ssize(problem.free_nodes()) - choice.far_nodes;
    if (near == std::exchange(near_before, near)) { continue; }
    ReductionSetting setting{
        .radius = radius, .near = *std::move(choice.nodes), .load_cases = load_cases};
    for (const int modes : {24, 48, 96}) {
      setting.modes = std::min(modes, scene.simulation.far_modes);
      const auto [linear, nonlinear] = expected_error(scene, problem, plan, setting);
      least = percent(linear) + " by too few modes and " + percent(nonlinear) +
              " by linear springs, of " + percent(allowed);
      if (linear + nonlinear <= allowed) {
        plan.far_reason = "near_radius " + number(radius) + " m, far_modes " +
                          std::to_string(setting.modes) + ": expected to change the force by " +
                          least + " allowed";
        plan.skipped.push_back(far_field_text(setting, choice.far_nodes));
        plan.far = std::make_shared<const ReductionSetting>(std::move(setting));
        return;
      }
      if (nonlinear > allowed || setting.modes < modes) { break; }  // more modes do not help
    }
  }
  plan.far_reason = whole +
                    "the largest reduced-order model tried is expected to change the force by " +
                    least + " allowed";
}

void choose_near(const Scene& scene, const NetworkProblem& problem, StepPlan& plan) {
  const std::optional<double> radius = scene.simulation.near_radius;
  if (radius == 0.0 || !plan.skip) { return; }
  if (!radius) {
    choose_far(scene, problem, plan);
    return;
  }
  NearChoice choice = choose_near_nodes(scene, problem, *radius);
  if (!choice.nodes) {
    plan.warnings.push_back(no_far_field + choice.obstacle);
    return;
  }
  ReductionSetting setting{.radius = *radius,
                           .near = *std::move(choice.nodes),
                           .load_cases = load_cases_of(scene, problem),
                           .modes = scene.simulation.far_modes};
  plan.skipped.push_back(far_field_text(setting, choice.far_nodes));
  plan.far = std::make_shared<const ReductionSetting>(std::move(setting));
}

/// Returns the number of integrated nodes.
std::size_t stepped_nodes(const NetworkProblem& problem, const StepPlan& plan) {
  if (!plan.far) { return problem.free_nodes().size(); }
  const auto near = std::ranges::count_if(problem.free_nodes(),
                                          [&](int node) { return plan.far->near.holds(node); });
  return static_cast<std::size_t>(near + plan.far->modes / 3);
}

void choose_integrator(const Scene& scene, std::size_t nodes, StepPlan& plan) {
  const SimulationSettings& settings = scene.simulation;
  if (settings.integrator != "auto") {
    plan.integrator = find_integrator(settings.integrator);
    if (plan.integrator == nullptr) {
      throw std::invalid_argument("unknown integrator \"" + settings.integrator + "\"");
    }
    plan.integrator_reason = "set by the scene";
    return;
  }
  if (settings.printed.any()) {
    plan.integrator = find_integrator("euler-cromer");
    plan.integrator_reason = "the paper's pseudo-code steps velocity, then position";
    return;
  }
  const double needed = substeps_for(settings.step, plan.stable_step.at("velocity-verlet"));
  const double given = settings.substeps ? *settings.substeps : needed;
  const bool tool = scene.needle || scene.probe;
  const int most = nodes > most_nodes_factorised ? most_automatic_substeps_of_many
                   : tool                        ? most_automatic_substeps_with_tool
                                                 : most_automatic_substeps;
  const bool explicit_works = needed <= most && given >= needed * stability_margin;
  plan.integrator = find_integrator(explicit_works ? "velocity-verlet"
                                    : tool         ? "implicit-euler"
                                                   : "implicit-midpoint");
  plan.integrator_reason =
      explicit_works ? "second order, explicit, stable with " + number(needed) + " substeps a tick"
                     : "explicit schemes would need " + number(needed) +
                           " substeps a tick; this one has no limit";
}

void refuse_large_factors(std::size_t nodes, const StepPlan& plan) {
  if (!plan.integrator->implicit || nodes <= most_implicit_nodes) { return; }
  const auto no_far = std::ranges::find_if(
      plan.warnings, [](const std::string& warning) { return warning.starts_with(no_far_field); });
  std::string why;
  if (!plan.skip) { why = "; --no-skip integrates every node"; }
  if (no_far != plan.warnings.end()) { why = "; " + *no_far; }
  throw std::invalid_argument("integrator \"" + std::string(plan.integrator->name) +
                              "\" factorises the stiffness of " + std::to_string(nodes) +
                              " nodes; at most " + std::to_string(most_implicit_nodes) +
                              ", by simulation.near_radius or a coarser spacing, or an explicit "
                              "scheme with a shorter step" +
                              why);
}

void choose_substeps(const Scene& scene, StepPlan& plan) {
  const SimulationSettings& settings = scene.simulation;
  const double limit = plan.stable_step.at(std::string(plan.integrator->name));
  if (settings.substeps) {
    plan.substeps = *settings.substeps;
    plan.substeps_reason = "set by the scene";
  } else if (plan.integrator->implicit) {
    plan.substeps_reason = "an implicit scheme needs one";
  } else if (!(limit > 0.0) || settings.printed.any()) {
    plan.substeps_reason = settings.printed.any() ? "the printed form takes one step a tick"
                                                  : "no step is stable; one a tick";
  } else {
    const double wanted = substeps_for(settings.step, limit);
    plan.substeps = static_cast<int>(std::min(wanted, 1e6));
    plan.substeps_reason =
        "h stays below " + number(stability_margin) + " of the stable step " + number(limit) + " s";
  }
  plan.h = settings.step / plan.substeps;
  if (!settings.printed.any() && plan.h > limit) {
    plan.warnings.push_back("step " + number(plan.h) + " s is above the stable step " +
                            number(limit) + " s of " + std::string(plan.integrator->name) +
                            ": expect divergence unless the motion stays slow");
  }
}

/// Returns the rows of a lattice in SIMD lanes.
std::optional<LatticeRows> lattice_rows(const std::optional<LatticeShape>& shape, bool single,
                                        bool may_fold) {
  if (!shape) { return {}; }
  return LatticeRows(
      *shape,
      single ? lattice_kernels<float>().front().lanes : lattice_kernels<double>().front().lanes,
      may_fold);
}

void choose_threads(const Scene& scene, const std::optional<LatticeRows>& rows, StepPlan& plan) {
  const int wanted = scene.simulation.threads;
  if (wanted == 1) { return; }
  if (!rows) {
    plan.warnings.emplace_back(
        "one thread: only a regular lattice under an explicit scheme is shared out");
    return;
  }
  if (plan.sleep_force > 0.0) {
    plan.warnings.emplace_back("one thread: rows that may sleep are not shared out");
    return;
  }
  const int layers = rows->nodes[2];
  plan.threads = most_lattice_threads(layers, rows->vectors, wanted);
  if (plan.threads < wanted) {
    plan.warnings.push_back(std::to_string(plan.threads) + " of " + std::to_string(wanted) +
                            " threads: each takes two layers or more of " + std::to_string(layers) +
                            ", in rows longer than a register");
  }
  const unsigned processors = std::thread::hardware_concurrency();
  if (processors > 0 && static_cast<unsigned>(plan.threads) > processors) {
    plan.warnings.push_back(std::to_string(plan.threads) + " threads on " +
                            std::to_string(processors) +
                            " processors: they will wait for each other");
  }
  if (plan.threads > 1) { plan.kernel += "-" + std::to_string(plan.threads) + "-threads"; }
}

/// Chooses whether rows sleep. Lattice springs have their natural length, so a row at rest stays at
/// rest until a force acts on it.
void choose_sleep(const Scene& scene, const NetworkProblem& problem, StepPlan& plan) {
  const double wanted = scene.simulation.sleep_force;
  if (!(wanted > 0.0) || !plan.skip) { return; }
  const char* obstacle = !plan.lattice
                             ? "only rows of a regular lattice under an explicit scheme can"
                         : !scene.tissue.gravity.isZero() ? "with gravity no node is at rest"
                                                          : nullptr;
  if (obstacle != nullptr) {
    plan.warnings.push_back(std::string("nothing sleeps: ") + obstacle);
    return;
  }
  plan.sleep_force = wanted;
  plan.touched = nodes_of_tool(scene, problem.network());
  plan.skipped.push_back("nodes at rest, until more than " + number(wanted) +
                         " N in all pulls at them");
}

void list_skipped(const Scene& scene, const NetworkProblem& problem,
                  const std::optional<LatticeRows>& rows, StepPlan& plan) {
  const SpringNetwork& network = problem.network();
  // SIMD lanes process complete rows: fixed nodes among free ones are computed with zero inverse
  // mass.
  const long springs = rows ? springs_between_fixed_rows(problem, *rows)
                            : std::ranges::count_if(network.springs, [&](const Spring& s) {
                                return network.is_fixed(s.a) && network.is_fixed(s.b);
                              });
  const long nodes = rows ? 0 : network.node_count() - std::ssize(problem.free_nodes());
  const bool device = scene.drive && scene.drive->is_coupled();
  for (auto& [skipped, text] : std::initializer_list<std::pair<bool, std::string>>{
           {!is_damped(network), "dampers: springs and cells have no viscosity"},
           {!has_volume_terms(network), "cell volumes: Poisson's ratio is 1/4 everywhere"},
           {std::ranges::none_of(network.laws, &MaterialLaw::stiffens),
            "stiffening: every material is linear"},
           {!relaxes(network), "relaxation: no material has it"},
           {springs > 0, "springs between fixed nodes: " + std::to_string(springs)},
           {nodes > 0, "stepping of fixed nodes: " + std::to_string(nodes)},
           {scene.tissue.gravity.isZero(), "gravity: zero"},
           {scene.loads.empty(), "loads: the scene has none"},
           {!scene.needle, "needle and shaft friction: the scene has none"},
           {!scene.probe, "probe: the scene has none"},
           {!scene.syringe, "syringe: the scene has none"},
           {!device, "haptic device: the scene has none"},
           {!scene.simulation.printed.any(), "printed forms of the paper: none is selected"}}) {
    if (skipped) { plan.skipped.push_back(text); }
  }
}

/// Adds the frequency and damping of a tool with a coordinate. Sticking to the tissue only moves
/// frequencies closer together.
void add_tool(const Scene& scene, SpectralBounds& bounds) {
  if (scene.drive->kind == Drive::Kind::trajectory) { return; }
  const double mass = scene.needle ? scene.needle->mass : scene.probe->mass;
  double viscosity = scene.drive->hand_viscosity;
  if (scene.drive->is_coupled()) {
    const FalconDrive falcon = scene.falcon.value_or(FalconDrive{});
    const double omega = std::sqrt(falcon.coupling_stiffness / mass);
    viscosity = falcon.coupling_viscosity;
    bounds.omega_upper = std::max(bounds.omega_upper, omega);
    bounds.omega_estimate = std::max(bounds.omega_estimate, omega);
    bounds.relaxation_lower =
        std::min(bounds.relaxation_lower, viscosity / falcon.coupling_stiffness);
  }
  bounds.damping_upper = std::max(bounds.damping_upper, viscosity / mass);
}

/// Warns of what makes a result depend on the grid: layers without cells of their own, and damping
/// that is given per spring.
void warn_of_grid(const Scene& scene, StepPlan& plan) {
  for (const ResolvedLayer& layer : resolved_layers(scene)) {
    if (layer.cells > 0) { continue; }
    plan.warnings.push_back("layer \"" + layer.tissue + "\" (" + number(1e3 * layer.thickness) +
                            " mm) has no cell of its own: its cells have the mean of several "
                            "layers; a spacing of " +
                            number(0.5 * layer.thickness) + " m would resolve it");
  }
  std::set<std::string> damped;
  const auto see = [&](const std::string& name) {
    const Material* material = find_material(scene.materials, name);
    if (material != nullptr && material->damping_ratio > 0.0 && !material->retardation_time &&
        !material->viscosity) {
      damped.insert(name);
    }
  };
  for (const Layer& layer : scene.tissue.layers) { see(layer.material); }
  for (const Inclusion& body : scene.tissue.inclusions) { see(body.material); }
  if (scene.tissue.source == Source::lattice &&
      scene.tissue.lattice.weights == LatticeWeights::cell) {
    see(scene.tissue.lattice.material);
  }
  std::string names;
  for (const std::string& name : damped) { names += (names.empty() ? "" : ", ") + name; }
  if (!names.empty()) {
    plan.warnings.push_back("damping_ratio of " + names +
                            ": the damping of a mode depends on the spacing; retardation_time "
                            "does not");
  }
}

/// Warns if whole cells make a block of another depth than its layers, and of inclusions under a
/// probe that cells do not resolve.
void warn_of_shapes(const Scene& scene, const SpringNetwork& network, StepPlan& plan) {
  constexpr double rounded = 0.05;  // thin tissue on a firm base changes its stiffness by more
  // palpation.toml with its bone moved by 12.5 % of an edge: 13 % less force than at half the
  // spacing. Unmoved, with faces on planes of nodes: 2 % more.
  constexpr double misfit = 0.1;
  const std::optional<LatticeShape>& shape = network.springs.lattice();
  if (!shape) { return; }
  double depth = 0.0;
  for (const Layer& layer : scene.tissue.layers) { depth += layer.thickness; }
  const double block = shape->spacing * (shape->nodes[2] - 1);
  if (scene.tissue.source == Source::layers && std::abs(block - depth) > rounded * depth) {
    plan.warnings.push_back("the layers are " + number(1e3 * depth) + " mm deep and their " +
                            std::to_string(shape->nodes[2] - 1) + " planes of cells " +
                            number(1e3 * block) + " mm: the tissue is as stiff as if it were so; " +
                            "a spacing of " + number(depth / (shape->nodes[2] - 1)) + " m fits");
  }
  if (!scene.probe) { return; }  // a needle's tip is narrow
  const Eigen::Vector3d first = shape->position(0, 0, 0);
  const Eigen::Vector3d last =
      shape->position(shape->nodes[0] - 1, shape->nodes[1] - 1, shape->nodes[2] - 1);
  for (const Inclusion& body : scene.tissue.inclusions) {
    // A ball of three cells still changes a probe's force by more than 5 % with the spacing.
    const bool ball = body.shape == Inclusion::Shape::sphere;
    const double cells = ball ? 4.0 : 2.0;
    const double least = ball ? body.size.x() : body.size.minCoeff();
    double off = 0.0;  // of a box's face from the next plane of nodes, as a share of its edge
    for (const double side : {-0.5, 0.5}) {
      const Eigen::Vector3d face =
          (body.centre + side * body.size).cwiseMax(first).cwiseMin(last) - first;
      const Eigen::Array3d place = face.array() / shape->spacing;
      const Eigen::Array3d away = (place - place.round()).abs() * shape->spacing;
      if (!ball) { off = std::max(off, (away / body.size.array()).maxCoeff()); }
    }
    const bool thin = least < (cells - 1e-9) * shape->spacing;
    if (!thin && off <= misfit) { continue; }
    plan.warnings.push_back(
        "an inclusion of " + body.material +
        (thin ? " is " + number(1e3 * least) + " mm thin, less than " + number(cells) + " cells"
              : " has a face that is " + number(100.0 * off) +
                    " % of its edge from the next plane of nodes") +
        ": its shape depends on where the nodes lie; " +
        (thin ? "a spacing of " + number(least / cells) + " m would resolve it"
              : "choose spacing, centre and size so that its faces lie on planes of nodes"));
  }
}

/// Warns of a modulus that was probably given in kPa, and of a motion in mm. The softest organs
/// (brain, liver, fat) have some hundred Pa; hands move needles by less than 0.5 m/s and 0.3 m.
void warn_of_units(const Scene& scene, StepPlan& plan) {
  constexpr double softest = 100.0;  // [Pa]
  for (const Material& material : scene.materials) {
    if (material.youngs_modulus > 0.0 && material.youngs_modulus < softest) {
      plan.warnings.push_back("youngs_modulus of " + material.name + " is " +
                              number(material.youngs_modulus) +
                              " Pa, less than that of any tissue; 1 kPa is 1000");
    }
  }
  const auto warn = [&](const char* key, double value, double most, const char* unit) {
    if (!(std::abs(value) > most)) { return; }
    plan.warnings.push_back(std::string(key) + " is " + number(value) + " " + unit +
                            ", more than a hand moves a needle; 1 mm" +
                            std::string(unit).substr(1) + " is 0.001");
  };
  if (!scene.drive || scene.drive->kind != Drive::Kind::trajectory) { return; }
  warn("drive.speed", scene.drive->speed, 0.5, "m/s");
  warn("drive.depth", scene.drive->depth.value_or(0.0), 0.3, "m");
}

/// Warns of parts of the tissue that no spring joins to a fixed node, if another part is held.
void warn_of_loose_parts(const Scene& scene, const SpringNetwork& network, StepPlan& plan) {
  const bool one_part = scene.tissue.source == Source::lattice;
  if (one_part || std::ranges::count(network.fixed, 1) == 0) { return; }
  boost::disjoint_sets_with_storage<> parts(static_cast<std::size_t>(network.node_count()));
  const auto part_of = [&parts](int node) {
    return parts.find_set(static_cast<std::size_t>(node));
  };
  for (const Spring& spring : network.springs) { parts.link(part_of(spring.a), part_of(spring.b)); }
  std::set<std::size_t> held;
  for (int node = 0; node < network.node_count(); ++node) {
    if (network.is_fixed(node)) { held.insert(part_of(node)); }
  }
  long loose = 0;
  double depth = std::numeric_limits<double>::infinity();
  for (int node = 0; node < network.node_count(); ++node) {
    if (held.contains(part_of(node))) { continue; }
    ++loose;
    depth = std::min(depth, network.rest_position(2, node));
  }
  if (loose == 0) { return; }
  plan.warnings.push_back(std::to_string(loose) +
                          " nodes, the first at z = " + number(1e3 * depth) +
                          " mm, are joined to no fixed node: this part of the tissue moves freely; "
                          "tissue.fixed holds faces");
}

/// Warns of loads, inclusions and recordings that change nothing, and of records far from tissue.
void warn_of_no_effect(const Scene& scene, const SpringNetwork& network, StepPlan& plan) {
  const double duration = scene.simulation.duration;
  const std::vector<Load> loads = resolve_loads(scene, network);
  for (std::size_t n = 0; n < loads.size(); ++n) {
    const Load& load = loads[n];
    const bool held =
        std::ranges::all_of(load.nodes, [&](int node) { return network.is_fixed(node); });
    if (!held && load.start < duration) { continue; }
    plan.warnings.push_back("load[" + std::to_string(n) + "] has no effect: " +
                            (held ? std::string("all its nodes are fixed")
                                  : "it starts at " + number(load.start) +
                                        " s, and the run ends at " + number(duration) + " s"));
  }
  const Eigen::Vector3d low = network.rest_position.rowwise().minCoeff();
  const Eigen::Vector3d high = network.rest_position.rowwise().maxCoeff();
  for (std::size_t n = 0; n < scene.tissue.inclusions.size(); ++n) {
    const Inclusion& body = scene.tissue.inclusions[n];
    const Eigen::Vector3d away = body.centre.cwiseMax(low).cwiseMin(high) - body.centre;
    const bool reaches = body.shape == Inclusion::Shape::sphere
                             ? away.norm() <= 0.5 * body.size.x()
                             : (away.cwiseAbs().array() <= 0.5 * body.size.array()).all();
    if (reaches) { continue; }
    plan.warnings.push_back("inclusion[" + std::to_string(n) + "] of " + body.material +
                            " has no effect: it lies outside the tissue");
  }
  for (const Record& record : scene.records) {
    const auto* point = std::get_if<Eigen::Vector3d>(&record.where);
    if (point == nullptr) { continue; }
    const double away = (network.rest_position.col(record_node(record, network)) - *point).norm();
    if (away <= mean_length(network)) { continue; }
    plan.warnings.push_back("record \"" + record.name + "\" is of a node " + number(1e3 * away) +
                            " mm from its point, more than the mean length of a spring");
  }
  if (scene.drive && scene.drive->grip && !scene.drive->grip->empty()) {
    const double end = scene.drive->grip->back().time;
    if (end + scene.simulation.step < duration) {
      plan.warnings.push_back("the recording of drive.recording ends at " + number(end) +
                              " s, and the run at " + number(duration) +
                              " s: the hand rests from then on");
    }
  }
}

/// Warns if a step takes the tool past more than a tenth of a layer.
void warn_of_stride(const Scene& scene, StepPlan& plan) {
  constexpr double share = 0.1;
  if (!scene.drive || scene.drive->kind != Drive::Kind::trajectory) { return; }
  if (scene.tissue.source != Source::layers || scene.tissue.layers.empty()) { return; }
  const Layer& layer = *std::ranges::min_element(scene.tissue.layers, {}, &Layer::thickness);
  const double stride = plan.h * std::max(scene.drive->speed, scene.drive->withdraw_speed);
  if (!(stride > share * layer.thickness)) { return; }
  const double substeps = std::ceil(plan.substeps * stride / (share * layer.thickness));
  plan.warnings.push_back("the tool moves by " + number(1e3 * stride) + " mm in a step, and " +
                          layer.tissue + " is " + number(1e3 * layer.thickness) +
                          " mm thick: forces at its borders are missed; simulation.substeps = " +
                          std::to_string(std::lround(std::min(substeps, 1e6))) + " resolves them");
}

/// Warns if the force at which the tip cuts the first cells presses them by more than half their
/// height. Deeper tissue has another stiffness than the one that `plan.tip.grid` is computed from.
void warn_of_collapse(const NeedlePath& path, StepPlan& plan) {
  double force = 0.0;
  for (const PathInterval& interval : path.intervals()) {
    if (interval.begin < plan.tip.spacing && std::isfinite(interval.puncture_force)) {
      force = std::max({force, interval.puncture_force, interval.cutting_force});
    }
  }
  const double share = force * plan.tip.grid / plan.tip.spacing;
  if (share > 0.5) {
    plan.warnings.push_back("the tip presses the first cells by " + number(share) +
                            " times their height before it cuts: they may turn inside out");
  }
}

/// Warns of a deep dent in tissue without a resistance to collapse, whose springs fold the more the
/// finer the cells are (docs/notebook/skin-dent.md, "Tissue that folds").
void warn_of_folding(const Scene& scene, const NeedlePath& path, StepPlan& plan) {
  constexpr double resists = 0.45;        // Poisson's ratio from which on cells keep their volume
  constexpr double deep_under_tip = 1.0;  // diameters
  constexpr double deep_under_face = 0.25;
  const PathInterval& first = path.tissue().front();
  if (!(first.youngs_modulus > 0.0) || first.poissons_ratio >= resists) { return; }
  // A skin over soft tissue has its own law or warning.
  const std::vector<DentTable>& tables = plan.tip.tables;
  if (scene.needle && !tables.empty() && tables.front().interval == 0) { return; }
  const Drive drive = scene.drive.value_or(Drive{});
  if (scene.probe && drive.is_coupled()) { return; }  // a hand decides
  double dent = plan.tip.continuum * drive.force;
  if (scene.needle) {
    const double force = std::max(first.puncture_force, first.cutting_force);
    dent = std::isfinite(force) ? plan.tip.continuum * force : 0.0;
  }
  if (drive.kind == Drive::Kind::trajectory) {
    dent = scene.needle ? std::min(dent, end_of_trajectory(scene, drive))
                        : end_of_trajectory(scene, drive);
  }
  const double width = scene.needle ? scene.needle->diameter : 2.0 * scene.probe->radius();
  if (!(dent > (scene.needle ? deep_under_tip : deep_under_face) * width)) { return; }
  plan.warnings.push_back(first.label + " is dented by about " + number(1e3 * dent) +
                          " mm by a tool of " + number(1e3 * width) +
                          " mm, and with a poissons_ratio of " + number(first.poissons_ratio) +
                          " its cells hardly resist collapse: the force depends on the spacing, "
                          "and palpate run --refine measures by how much");
}

/// Warns if a spherical tip is pressed to a contact of more than half its radius of curvature,
/// where a paraboloid is no sphere and strains are not small.
void warn_of_curvature(const Scene& scene, StepPlan& plan) {
  constexpr double share = 0.5;
  if (!scene.probe || !scene.probe->tip_radius) { return; }
  const double radius = *scene.probe->tip_radius;
  const Drive drive = scene.drive.value_or(Drive{});
  const double dent = drive.kind == Drive::Kind::trajectory ? end_of_trajectory(scene, drive)
                                                            : plan.tip.continuum * drive.force;
  // Hertz: a contact of radius a has the dent a^2 / R.
  if (scene.probe->radius() <= share * radius || dent <= share * share * radius) { return; }
  plan.warnings.push_back("the tip is pressed " + number(1e3 * dent) +
                          " mm deep, more than a quarter of probe.tip_radius: its law is for "
                          "contacts that are small against that radius");
}

/// Returns true if the force of a dent by a needle differs by more than a tenth between cells of
/// five and of half a radius (docs/notebook/ligament-curves.md, "Dents").
bool stiffens_too_fast_for_contact(const MaterialLaw& law) {
  constexpr double strain = 0.2;
  constexpr double bent = 6.5 * strain;  // of an exponential law with the rate 6.5
  return law.stiffens() && stretched(stiffening_numbers<double>(law), strain).value >
                               std::expm1(bent) / bent * strain;
}

/// Computes the compliance that the grid lacks under the tool, and adds the frequency of the tool
/// on the nodes of its contact points.
void add_contact(const Scene& scene, const NetworkProblem& problem, StepPlan& plan) {
  const NeedlePath path(scene, problem.network());
  plan.tip = path.tip_compliance(scene, problem.network());
  TipCompliance& tip = plan.tip;
  if (tip.spacing > 0.0) {
    warn_of_collapse(path, plan);
    warn_of_folding(scene, path, plan);
    warn_of_curvature(scene, plan);
    for (DentTable& table : tip.tables) {
      if (table.is_complete()) { continue; }
      if (scene.simulation.printed.any()) { table.dent.clear(); }
      if (table.dent.empty()) { plan.warnings.push_back(membrane_warning(path, table)); }
    }
  }
  if (tip.excess > 0.05) {
    plan.warnings.push_back("the grid is softer under the tool than the continuum, by up to " +
                            number(100.0 * tip.excess) + " %, which is not corrected");
  }
  if (!plan.tip.value.empty() &&
      std::ranges::any_of(path.intervals(), [](const PathInterval& interval) {
        return stiffens_too_fast_for_contact(interval.law);
      })) {
    plan.warnings.emplace_back(
        "tissue under the tool stiffens so fast that the force of a dent changes by more than 10 % "
        "with the spacing: the compliance of the contact below the size of a cell is linear");
  }
  double stiffness = 0.0;  // of the tissue between tool and nodes
  for (const PathInterval& interval : path.intervals()) {
    const double end = std::min(interval.end, path.knots().back().depth);
    if (!(interval.friction_travel > 0.0) || !(end > interval.begin)) { continue; }
    stiffness += interval.friction * (end - interval.begin) / interval.friction_travel;
  }
  if (plan.tip.value.empty()) {
    if (scene.probe && scene.probe->tip_radius) {
      plan.warnings.emplace_back(
          "probe.tip_radius has no effect, and the tip is flat: a spherical one needs the "
          "materials "
          "of layers, a mesh, an image or a lattice with weights = \"cell\"");
    }
    plan.skipped.emplace_back(
        "compliance of the contact: the grid resolves the tool, or its "
        "material is unknown");
  } else {
    double least = std::ranges::min(tip.value);
    for (const DentTable& table : tip.tables) {
      if (table.is_complete()) {
        least = table.least_compliance();
      } else if (!table.dent.empty()) {
        least = DentTable::least_slope * std::ranges::min(tip.value);
      }
    }
    stiffness += 1.0 / least;
  }
  if (stiffness == 0.0) { return; }
  double mobility = 0.0;
  for (const NeedlePath::Knot& knot : path.knots()) {
    double own = 0.0;
    for (const NeedlePath::Support& s : path.supports(knot)) {
      const Eigen::Index at = problem.coordinate(s.node);
      if (at >= 0) { own += s.weight * s.weight / problem.mass()(at); }
    }
    mobility = std::max(mobility, own);
  }
  plan.bounds.omega_upper = std::hypot(plan.bounds.omega_upper, std::sqrt(mobility * stiffness));
}

/// Warns of steps that are long against the period of an oscillator.
void see_period(const Oscillator& o, StepPlan& plan) {
  constexpr double enough = 10.0;  // steps a period; a central difference is then 1.7 % too fast
  const double omega = std::sqrt(o.stiffness / o.mass);
  const double period = 2.0 * std::numbers::pi / omega;
  const bool swings = o.viscosity < 2.0 * o.mass * omega;
  if (!swings || period >= enough * plan.h) { return; }
  const double substeps = std::ceil(plan.substeps * enough * plan.h / period);
  plan.warnings.push_back(
      "the oscillator's period of " + number(period) + " s has " + number(period / plan.h) +
      " steps: the motion is not resolved; simulation.substeps = " +
      std::to_string(std::lround(std::min(substeps, 1e6))) + " gives it " + number(enough));
}

/// Returns the one mode of an oscillator; none without a spring.
std::optional<FirstMode> mode_of(const Oscillator& o) {
  const double omega = std::sqrt(o.stiffness / o.mass);
  if (!(omega > 0.0)) { return {}; }
  return FirstMode{omega, 0.5 * o.viscosity / (o.mass * omega)};
}

/// Computes the damping that the scheme adds to the first mode, and warns if it exceeds the
/// material's.
void see_added_damping(const Scene& scene, const NetworkProblem* network, StepPlan& plan) {
  constexpr double negligible = 0.02;
  const IntegratorInfo& scheme = *plan.integrator;
  if (!(stepped_damping_ratio(scheme, {.omega = 1.0}, 0.1) > 0.01)) { return; }
  plan.first_mode = network != nullptr ? first_mode(*network) : mode_of(scene.tissue.oscillator);
  if (!plan.first_mode) { return; }
  const double own = plan.first_mode->damping_ratio;
  plan.stepped_damping_ratio = stepped_damping_ratio(scheme, *plan.first_mode, plan.h);
  const std::string mode =
      std::string(network != nullptr ? "the tissue's first mode (" : "the oscillator (") +
      number(0.5 * plan.first_mode->omega / std::numbers::pi) + " Hz) has a damping ratio of " +
      number(plan.stepped_damping_ratio) + " with steps of " + number(plan.h) +
      " s, where its material gives " + number(own);
  plan.integrator_reason += "; " + mode;
  const double allowed = std::max(own, negligible);
  if (plan.stepped_damping_ratio - own <= allowed) { return; }
  // Implicit Euler adds omega h / 2.
  const double enough = std::ceil(plan.substeps * 0.5 * plan.first_mode->omega * plan.h / allowed);
  plan.warnings.push_back(mode + ": vibrations end too soon; simulation.substeps = " +
                          std::to_string(std::lround(std::min(enough, 1e6))) +
                          " adds no more than the material's own, or " + number(negligible));
}

template <class Real> std::string instructions_of(bool lattice) {
  return lattice ? lattice_kernels<Real>().front().name : adjacency_kernels<Real>().front().name;
}

std::string kernel_name(bool lattice, bool printed, bool damped, bool single) {
  const std::string precision = single ? "float" : "double";
  if (printed) { return "springs-printed-" + precision; }
  return std::string(lattice ? "lattice" : "springs") + (damped ? "-damped-" : "-undamped-") +
         precision + "-" +
         (single ? instructions_of<float>(lattice) : instructions_of<double>(lattice));
}

}  // namespace

std::string membrane_warning(const NeedlePath& path, const DentTable& table) {
  const PathInterval& skin = path.intervals()[table.interval];
  const double thickness = (skin.end - skin.begin) * path.direction().z();
  return skin.label + " (" + number(1e3 * thickness) + " mm) is dented by about " +
         number(1e3 * table.small_dent) +
         " mm before it is cut. Its contact is linear, which such a dent is not: the depth of the "
         "puncture depends on the spacing, and palpate run --refine measures by how much";
}

StepPlan plan_steps(const Scene& scene, const Problem& problem, bool skip) {
  StepPlan plan;
  plan.skip = skip;
  plan.printed = scene.simulation.printed;
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  const bool single = scene.simulation.precision == Precision::single_precision;
  plan.bounds =
      network != nullptr ? spectral_bounds(*network) : spectral_bounds(scene.tissue.oscillator);
  if (network != nullptr) {
    warn_of_units(scene, plan);
    warn_of_grid(scene, plan);
    warn_of_shapes(scene, network->network(), plan);
    warn_of_loose_parts(scene, network->network(), plan);
    warn_of_no_effect(scene, network->network(), plan);
  }
  if (network != nullptr && (scene.needle || scene.probe)) { add_contact(scene, *network, plan); }
  if (network != nullptr && scene.drive) { add_tool(scene, plan.bounds); }
  for (const IntegratorInfo* info : integrators()) {
    plan.stable_step[std::string(info->name)] =
        network != nullptr ? stable_step(*info, plan.bounds)
                           : stable_step(*info, plan.bounds.omega_upper, plan.bounds.damping_upper);
  }
  if (network != nullptr) { choose_near(scene, *network, plan); }
  const std::size_t nodes = network != nullptr ? stepped_nodes(*network, plan) : 1;
  choose_integrator(scene, nodes, plan);
  refuse_large_factors(nodes, plan);
  if (scene.simulation.printed.lagged_velocity && !plan.integrator->one_evaluation) {
    throw std::invalid_argument(
        "integrator \"" + std::string(plan.integrator->name) +
        "\" evaluates forces more than once a step; lagged_velocity needs \"euler\", "
        "\"euler-cromer\", \"feynman-newton\" or \"feynman-newton-printed\"");
  }
  choose_substeps(scene, plan);
  if (network != nullptr) { warn_of_stride(scene, plan); }
  if (!scene.simulation.printed.any()) { see_added_damping(scene, network, plan); }
  if (network == nullptr) {
    see_period(scene.tissue.oscillator, plan);
    plan.kernel = single ? "oscillator-float" : "oscillator-double";
    if (skip) { plan.skipped.emplace_back("network, loads and gravity: a single oscillator"); }
    return plan;
  }
  const PrintedForm& printed = scene.simulation.printed;
  const bool damped = is_damped(network->network());
  const bool law_as_printed = SpringLaw::is_printed(printed);
  std::optional<LatticeShape> shape;
  const bool cells = has_volume_terms(network->network());
  const bool laws = !network->network().laws.empty();
  if (!plan.integrator->implicit && !law_as_printed && !plan.far && !cells && !laws) {
    shape = network->network().springs.lattice();
  }
  plan.lattice = shape.has_value();
  plan.kernel = kernel_name(plan.lattice, law_as_printed, damped || !skip, single);
  if (laws) { plan.kernel += "-laws"; }
  if (cells) { plan.kernel += "-cells"; }
  if (plan.far) { plan.kernel += "-far-field"; }
  choose_sleep(scene, *network, plan);
  const std::optional<LatticeRows> rows = lattice_rows(shape, single, plan.sleep_force <= 0.0);
  choose_threads(scene, rows, plan);
  if (skip) { list_skipped(scene, *network, rows, plan); }
  return plan;
}

template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_network_system(const NetworkProblem& problem,
                                                         const StepPlan& plan) {
  if (plan.lattice) {
    return make_lattice_network<Real>(problem, {.skip = plan.skip,
                                                .threads = plan.threads,
                                                .sleep_force = plan.sleep_force,
                                                .touched = plan.touched});
  }
  if (plan.far) { return make_reduced_network<Real>(problem, *plan.far); }
  const bool implicit = plan.integrator != nullptr && plan.integrator->implicit;
  const bool padded = !implicit && !SpringLaw::is_printed(plan.printed);
  return std::make_unique<ListNetwork<Real>>(problem, plan.printed, plan.h, plan.skip,
                                             ListVectors{.padded = padded});
}

template std::unique_ptr<NetworkSystem<double>> make_network_system(const NetworkProblem&,
                                                                    const StepPlan&);
template std::unique_ptr<NetworkSystem<float>> make_network_system(const NetworkProblem&,
                                                                   const StepPlan&);

}  // namespace palpate

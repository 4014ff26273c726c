// SPDX-License-Identifier: MIT
/// Network of a patient: 4,650 nodes and 49,727 springs sampled from a lumbar MRI, loaded on the
/// middle of its posterior plane for 50 ms and released.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/solver_cross_check.hpp"
#include "validation/claims/groups.hpp"
#include "validation/number_text.hpp"
#include "validation/random.hpp"
#include "validation/roll_out.hpp"
#include "validation/signal.hpp"

namespace palpate {

namespace {

constexpr int pressed_node = 2324;
constexpr double tick = 1e-3;      // s
constexpr double duration = 0.1;   // s
constexpr double released = 0.05;  // s
constexpr double demanded_digits = 8.0;

Load press() {
  Load load;
  load.nodes = {pressed_node};
  load.force = {0.0, 0.0, 0.02};  // inwards
  load.end = released;
  return load;
}

/// One scheme with the substeps a tick at which it is shown. Every explicit scheme is inside its
/// stability limit there; the numbers double, so that orders can be read off;
/// implicit Euler, slow and rough here, is shown once.
struct Rungs {
  const char* scheme;
  double order;  ///< of a damped network, from the theory of the scheme
  std::vector<int> substeps;
};

const std::vector<Rungs> ladder{{"euler", 1.0, {20, 40, 80}},
                                {"euler-cromer", 1.0, {20, 40, 80}},
                                {"feynman-newton", 1.0, {20, 40, 80}},
                                {"feynman-newton-printed", 1.0, {20, 40, 80}},
                                {"leapfrog", 2.0, {10, 20}},
                                {"velocity-verlet", 2.0, {20, 40, 80}},
                                {"rk4", 4.0, {16, 32, 64}},
                                {"implicit-euler", 1.0, {1}},
                                {"implicit-midpoint", 2.0, {1, 2}}};

reference::Reference references(const CaseContext& context, const NetworkProblem& problem) {
  using reference::solver_named;
  return reference::establish(
      problem, tick_times(tick, std::lround(duration / tick)), {.relative = 1e-11},
      {solver_named("arkode-fehlberg-7-8"), solver_named("cvode-adams"), solver_named("gsl-rk8pd")},
      {.demanded_digits = demanded_digits, .cache = context.cache});
}

void judge_references(const reference::Reference& truth, Outcome& outcome) {
  outcome.judge_at_least("digits to which the references agree, at every stored instant",
                         truth.agreed_digits, demanded_digits, "two families of solvers");
  outcome.judge_true(
      "references trustworthy", truth.trustworthy,
      "agreement, ladder of tolerances, steps" + (truth.reason.empty() ? "" : ": " + truth.reason));
  outcome.report("digits of velocity to which the references agree", truth.agreed_velocity_digits);
  for (const std::string& note : truth.notes) { outcome.notes.push_back(note); }
  outcome.timings.push_back({truth.solution.method, truth.solution.seconds});
  for (const auto& other : truth.second_opinions) {
    outcome.timings.push_back({other.method, other.seconds});
  }
}

/// Result of one scheme at one number of substeps.
struct Shown {
  const Rungs* rungs;
  int substeps;
  Trace motion;
  TrajectoryError error;
};

Shown show(const CaseContext& context, const SpringNetwork& network, const Rungs& rungs,
           int substeps, const Trace& truth) {
  Scene scene = scene_of(rungs.scheme, tick, duration, substeps);
  scene.loads = {press()};
  Shown shown{&rungs, substeps, roll_out(context, scene, &network, {.position = true}), {}};
  shown.error = trajectory_error(shown.motion.position, truth.position, truth.position.col(0));
  return shown;
}

/// Order between the two finest rungs of each scheme, and the error itself where theory bounds it.
void judge_scheme(const std::vector<Shown>& all, const Rungs& rungs, double floor,
                  Outcome& outcome) {
  std::vector<const Shown*> mine;
  for (const Shown& each : all) {
    if (each.rungs == &rungs) { mine.push_back(&each); }
  }
  const Shown& fine = *mine.back();
  const std::string name = rungs.scheme;
  const bool high_order = rungs.order >= 4.0;
  outcome.judge_at_most("largest error of " + name + ", finest step", fine.error.maximum,
                        high_order ? 1e-4 : unbounded,
                        high_order ? "asked of order four at omega_max h = 0.15" : "", "of peak");
  if (mine.size() < 2) { return; }
  const Shown& coarse = **(mine.end() - 2);
  const double order = std::log(coarse.error.maximum / fine.error.maximum) /
                       std::log(static_cast<double>(fine.substeps) / coarse.substeps);
  const bool at_floor = fine.error.maximum < 100.0 * floor;
  if (at_floor) {
    outcome.notes.push_back(
        "The order of " + name +
        " is not judged: its error is below a hundred times the floor of the references.");
  }
  outcome.judge_between("order of " + name + " between its two finest steps", order,
                        at_floor ? -unbounded : rungs.order - 0.3,
                        at_floor ? unbounded : rungs.order + 0.3,
                        at_floor ? "" : "theory, two rungs");
}

Figure error_figure(const std::vector<Shown>& all, double floor, bool over_cost) {
  Figure figure =
      plot(over_cost ? "error-over-cost" : "error-over-step",
           over_cost ? "Error against run time" : "Error against step",
           over_cost ? "What each digit costs on this machine; left and below is better."
                     : "Each scheme's error falls with its order towards the references' floor.",
           logarithmic(over_cost ? "wall time (s)" : "step h (s)"),
           logarithmic("largest error (of peak displacement)"));
  figure.timing = over_cost;
  double least = unbounded;
  double most = 0.0;
  for (const Rungs& rungs : ladder) {
    Series& series = figure.add(rungs.scheme, Series::Style::line_and_points);
    for (const Shown& each : all) {
      if (each.rungs != &rungs) { continue; }
      const double x = over_cost ? each.motion.seconds : each.motion.h;
      series.add(x, each.error.maximum);
      least = std::min(least, x);
      most = std::max(most, x);
    }
  }
  figure.add("floor of the references", {least, most}, {floor, floor}, Series::Style::dashed);
  return figure;
}

Figure motion_figure(const NetworkProblem& problem, const std::vector<Shown>& all,
                     const Trace& truth) {
  const Eigen::Index z = problem.coordinate(pressed_node) + 2;
  Figure figure = plot("pressed-node", "The pressed node",
                       "Inward displacement under 0.02 N for 50 ms and free afterwards: the "
                       "reference, and the coarsest run of three schemes.",
                       {"time (s)"}, {"displacement along z (m)"});
  const auto add = [&](const std::string& label, const Eigen::MatrixXd& position,
                       Series::Style style) {
    Series& series = figure.add(label, style);
    for (Eigen::Index n = 0; n < position.cols(); ++n) {
      series.add(truth.time[static_cast<std::size_t>(n)], position(z, n) - truth.position(z, 0));
    }
  };
  add("reference", truth.position, Series::Style::line);
  for (const char* scheme : {"euler-cromer", "rk4", "implicit-euler"}) {
    const auto found = std::ranges::find_if(
        all, [&](const Shown& each) { return each.rungs->scheme == std::string_view(scheme); });
    add(scheme, found->motion.position, Series::Style::dashed);
  }
  return figure;
}

void measure_lumbar(const CaseContext& context, Outcome& outcome) {
  const auto network =
      context.outside_network ? context.outside_network("lumbar_network") : std::nullopt;
  if (!network) {
    outcome.skip(
        "the data set lumbar_network is absent (--data DIR or PALPATE_DATA names its folder)");
    return;
  }
  const NetworkProblem problem(*network, {press()});
  const reference::Reference truth = references(context, problem);
  judge_references(truth, outcome);
  const double floor = std::ranges::max(truth.position_floor);
  std::vector<Shown> all;
  for (const Rungs& rungs : ladder) {
    for (const int substeps : rungs.substeps) {
      all.push_back(show(context, *network, rungs, substeps, truth.solution));
      const Shown& last = all.back();
      outcome.timings.push_back(
          {std::string(rungs.scheme) + ", " + std::to_string(substeps) + " substeps",
           last.motion.seconds});
    }
    judge_scheme(all, rungs, floor, outcome);
  }
  outcome.report("peak displacement", reference::peak_displacement(truth.solution.position), "m");
  Table& table = outcome.table(
      "schemes", "Every integrator on the patient's network",
      "Errors over all nodes and ticks, relative to the peak displacement.",
      {"integrator", "substeps a tick", "h (s)", "largest error (1)", "L2 error (1)", "steps (1)"});
  for (const Shown& each : all) {
    table.rows.push_back({each.rungs->scheme, each.substeps, each.motion.h, each.error.maximum,
                          each.error.l2, each.motion.steps});
  }
  outcome.figures = {motion_figure(problem, all, truth.solution), error_figure(all, floor, false),
                     error_figure(all, floor, true),
                     plot("floor", "How well the references agree",
                          "Largest disagreement of the solver families at each stored instant.",
                          {"time (s)"}, logarithmic("disagreement (of peak)"),
                          {curve("position", truth.solution.time, truth.position_floor),
                           curve("velocity", truth.solution.time, truth.velocity_floor)})};
}

/// Returns the nominal stress of a block of a material over its modulus at rest, under tension
/// along z with free sides [1].
double stress_in_tension(const Material& material, double stretch) {
  const double spacing = 1e-3;
  const NetworkProblem cell(cell_lattice({{2, 2, 2}, spacing, 26}, [&](int, int, int) {
    return CellMaterial{.youngs_modulus = material.youngs_modulus,
                        .density = material.density,
                        .poissons_ratio = material.poissons_ratio,
                        .law = law_of(material)};
  }));
  const NodeVectors& rest = cell.network().rest_position;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(cell.dof());
  // Slopes of the elastic energy by the stretch along the load and by that of the sides.
  const auto slopes = [&](double side) {
    Eigen::VectorXd place(cell.dof());
    for (const int node : cell.free_nodes()) {
      place.segment<3>(cell.coordinate(node)) =
          rest.col(node).cwiseProduct(Eigen::Vector3d(side, side, stretch));
    }
    Eigen::VectorXd force(cell.dof());
    cell.force(0.0, 0.0, place, still, force);
    std::array<double, 2> sum{};
    for (const int node : cell.free_nodes()) {
      const Eigen::Vector3d work =
          -force.segment<3>(cell.coordinate(node)).cwiseProduct(rest.col(node));
      sum[0] += work.z();
      sum[1] += work.x() + work.y();
    }
    return sum;
  };
  double low = 0.2;
  double high = 1.0;
  for (int n = 0; n < 60; ++n) {
    const double middle = 0.5 * (low + high);
    (slopes(middle)[1] < 0.0 ? low : high) = middle;
  }
  return slopes(low)[0] / (std::pow(spacing, 3.0) * material.youngs_modulus);
}

/// Ligaments of the library in tension, beside measured curves. Means over curves that were divided
/// by extension and force at 80 % of the peak (10.1016/j.jmbbm.2014.09.023);
/// scripts/ligament-springs computes them.
void judge_ligaments(const std::vector<Material>& library, Outcome& outcome) {
  struct Curves {
    const char* name;
    double modulus;                   ///< published, at large strain [Pa] (PMC2913991, table 3)
    double stretch;                   ///< at 80 % of the peak
    double count;                     ///< of curves
    std::array<double, 3> force;      ///< at 1/4, 1/2 and 3/4 of the extension [1]
    std::array<double, 3> deviation;  ///< standard deviation of the curves
  };
  const std::array<Curves, 2> measured{{{"ligamentum-flavum",
                                         19.5e6,
                                         1.0 + 4.81 / 7.0,
                                         14.0,
                                         {0.082, 0.203, 0.441},
                                         {0.076, 0.179, 0.204}},
                                        {"interspinous-ligament",
                                         11.6e6,
                                         1.0 + 5.13 / 10.0,
                                         11.0,
                                         {0.110, 0.302, 0.615},
                                         {0.117, 0.152, 0.103}}}};
  for (const Curves& curves : measured) {
    const auto found = std::ranges::find(library, curves.name, &Material::name);
    if (found == library.end()) { continue; }  // measure_library() fails for it
    const double end = stress_in_tension(*found, curves.stretch);
    Largest worst;
    for (std::size_t n = 0; n < curves.force.size(); ++n) {
      const double share = 0.25 * static_cast<double>(n + 1);
      const double force = stress_in_tension(*found, 1.0 + share * (curves.stretch - 1.0)) / end;
      worst.add(std::abs(force - curves.force[n]) * std::sqrt(curves.count) / curves.deviation[n]);
    }
    // The straight part is that between 30 and 70 % of the peak.
    const auto stretch_at = [&](double force) {
      double low = 1.0;
      double high = curves.stretch;
      for (int n = 0; n < 40; ++n) {
        const double middle = 0.5 * (low + high);
        (stress_in_tension(*found, middle) < force * end ? low : high) = middle;
      }
      return low;
    };
    const double slope =
        found->youngs_modulus * end * 0.5 / (stretch_at(0.875) - stretch_at(0.375));
    outcome.judge_near(
        std::string(curves.name) + "_modulus_of_its_straight_part", slope, curves.modulus,
        0.32 * curves.modulus,
        "published modulus at large strain, within two standard errors of that part's "
        "stiffness: 82 N/mm of the flavum, 56 to 122",
        "Pa");
    outcome.judge_at_most(std::string(curves.name) + "_less_measured_in_standard_errors",
                          worst.value(), 2.0,
                          "two standard errors of the mean of " + plain_number(curves.count) +
                              " curves, at 1/4, 1/2 and 3/4 of their extension");
  }
  outcome.notes.emplace_back(
      "The ligaments were fitted to the means that they are compared with: this shows that the "
      "springs of the model have the fitted law, not that it holds for other specimens.");
}

/// Library values from the published figures that fixtures/materials/library.toml names.
void measure_library(const CaseContext& context, Outcome& outcome) {
  if (!context.library) { throw CannotDo("not run: no library of materials is at hand"); }
  struct Published {
    const char* name;
    double youngs_modulus;  ///< [Pa]
    double needle_force;    ///< [N]
    double thickness;       ///< [m]
  };
  // Needle forces of Davidor et al. 2023, of which cutting is 61 % and friction 21 % (Barnett, Lee,
  // Moore 2015); E = 6 C10 of skin (10.1111/iwj.12877), 3 G of muscle (10.1115/1.4047651), of
  // ligaments the modulus at large strain (PMC2913991) times the measured ratio of the slopes at
  // rest and beyond.
  const std::array<Published, 5> published{
      {{"skin", 6.0 * 4.0e3, 6.04, 13.92e-3},
       {"supraspinous-ligament", 0.231 * 15e6, 4.35, 2.85e-3},
       {"interspinous-ligament", 0.231 * 11.6e6, 7.47, 21.18e-3},
       {"ligamentum-flavum", 0.108 * 19.5e6, 12.13, 7.20e-3},
       {"muscle", 3.0 * 18.55e3, 4.35, 29.1e-3 /* of paramedian.toml */}}};
  const std::vector<Material> library = context.library();
  Largest worst;
  for (const Published& each : published) {
    const auto found = std::ranges::find(library, each.name, &Material::name);
    if (found == library.end()) {
      worst.add(std::nan(""));
      continue;
    }
    worst.add(std::abs(found->youngs_modulus / each.youngs_modulus - 1.0));
    worst.add(std::abs(found->cutting_force / (0.61 * each.needle_force) - 1.0));
    worst.add(std::abs(found->friction / (0.21 * each.needle_force / each.thickness) - 1.0));
  }
  outcome.judge_at_most("library_over_published_figures_less_one", worst.value(), 5e-3,
                        "published figures, rounded to two or three digits");
  judge_ligaments(library, outcome);
  if (!context.shipped_scene) { return; }
  Largest depth;
  for (const int index : {22, 30, 40, 47}) {
    const auto scene = context.shipped_scene("epidural-bmi-" + std::to_string(index));
    if (!scene) {
      outcome.notes.emplace_back("The shipped scenes are not at hand.");
      return;
    }
    double sum = 0.0;
    for (const Layer& layer : scene->tissue.layers) {
      if (layer.tissue == "epidural space") { break; }
      sum += layer.thickness;
    }
    depth.add(std::abs(sum - 1e-3 * (17.80 + 0.978 * index)));
  }
  outcome.judge_at_most("error_of_the_depth_of_the_epidural_space", depth.value(), 1e-4,
                        "17.80 mm + 0.978 mm BMI (Ravi et al. 2011), to 0.1 mm", "m");
}

/// A box of 20.99 x 21.01 x 21.01 mm in a file in millimetres. Voxels of 2 mm are inside if their
/// centres are, of which one along each axis is at 21 mm.
void measure_surface_file(const CaseContext& context, Outcome& outcome) {
  const std::string box =
      "v 0 0 0\nv 20.99 0 0\nv 20.99 21.01 0\nv 0 21.01 0\n"
      "v 0 0 21.01\nv 20.99 0 21.01\nv 20.99 21.01 21.01\nv 0 21.01 21.01\n"
      "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
  const std::string scene =
      "[tissue]\nsource = \"mesh\"\n[tissue.mesh]\nvoxel = 0.002\n"
      "files = [{ path = \"box.obj\", material = \"gel\", scale = 0.001 }]\n"
      "[[material]]\nname = \"gel\"\nyoungs_modulus = 1e4\ndensity = 1000.0\n";
  const SpringNetwork network = context.network_of_files({{"box.obj", box}, {"scene.toml", scene}});
  outcome.judge_near("mass_of_a_box_from_a_surface", network.mass.sum(), 9.68e-3, 1e-12,
                     "10 x 11 x 11 voxels of 2 mm, of 1000 kg/m^3; rounding", "kg");
}

/// Four PNG slices of 4 x 4 equal pixels of 16 bits, written by another program (zlib of Python):
/// 511, 512, 768 and 1024. With their bytes exchanged the first would be the brightest.
void measure_slices(const CaseContext& context, Outcome& outcome) {
  const std::array<std::string_view, 4> pixels{
      "6360fc0f810cb8190018431001a3bb9420", "636062804006dc0c000274002142669a94",
      "636066804006dc0c00039c0031f0451f0f", "636061804006dc0c0004c4004176033c01"};
  std::map<std::string, std::string> files{
      {"scene.toml",
       "[tissue]\nsource = \"mri\"\n[tissue.mri]\npath = \".\"\nspacing = [1e-3, 1e-3, 1e-3]\n"
       "percentiles = [0, 100]\n"
       "lookup = [{ intensity = 0.0, material = \"soft\" }, "
       "{ intensity = 1.0, material = \"stiff\" }]\n"
       "[[material]]\nname = \"soft\"\nyoungs_modulus = 1e3\n"
       "[[material]]\nname = \"stiff\"\nyoungs_modulus = 1e5\n"}};
  const auto from_hexadecimal = [](std::string_view digits) {
    std::string bytes;
    for (std::size_t n = 0; n < digits.size(); n += 2) {
      bytes += static_cast<char>(std::stoi(std::string(digits.substr(n, 2)), nullptr, 16));
    }
    return bytes;
  };
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    files["slice" + std::to_string(n) + ".png"] = from_hexadecimal(
        "89504e470d0a1a0a0000000d4948445200000004000000041000000000dc0a1de10000000f4944415478da" +
        std::string(pixels[n]) + "0000000049454e44ae426082");
  }
  const SpringNetwork network = context.network_of_files(files);
  const std::array<double, 4> grey{511.0, 512.0, 768.0, 1024.0};
  const auto modulus = [&](std::size_t slice) {
    return 1e3 * std::pow(100.0, (grey[slice] - grey[0]) / (grey[3] - grey[0]));
  };
  const double unit = bond_stiffness(1.0, 1e-3, 26).edge;
  Largest worst;
  int upright = 0;
  for (const Spring& spring : network.springs) {
    const auto slice = static_cast<std::size_t>(spring.a / 16);
    const bool inside = spring.a % 16 == 5 && spring.b - spring.a == 16;
    if (!inside) { continue; }
    ++upright;
    const double expected = unit * 0.5 * (modulus(slice) + modulus(slice + 1));
    worst.add(std::abs(spring.stiffness / expected - 1.0));
  }
  outcome.judge_equal("springs_between_slices_of_16_bits", upright, 3.0, "four slices");
  outcome.judge_at_most("stiffness_between_slices_of_16_bits", worst.value(), 1e-5,
                        "E = 1e3 Pa * 100^intensity; intensities in single precision");
}

/// A network with an initial state is the same after it was written and read; surfaces and images
/// have the size and the numbers of their files.
void measure_files(const CaseContext& context, Outcome& outcome) {
  if (!context.through_files) { throw CannotDo("not run: no files can be written"); }
  Scene scene = s26_scene(4);
  SpringNetwork network = build_network(scene);
  scene.tissue.source = Source::network;
  scene.tissue.fixed = std::vector<Face>{};
  Random random(3);
  network.initial_velocity.setZero(3, network.node_count());
  network.initial_displacement.setZero(3, network.node_count());
  for (int n = 0; n < network.node_count(); ++n) {
    network.initial_displacement.col(n) = random.vector(3, 1e-3);
    if (!network.is_fixed(n)) { network.initial_velocity.col(n) = random.vector(3, 0.1); }
  }
  network.springs.change_each([&](Spring& s) { s.stiffness *= random(0.5, 2.0); });
  const SpringNetwork read = context.through_files(scene, network);
  Largest worst;
  worst.add((read.rest_position - network.rest_position).cwiseAbs().maxCoeff());
  worst.add((read.initial_displacement - network.initial_displacement).cwiseAbs().maxCoeff());
  worst.add((read.initial_velocity - network.initial_velocity).cwiseAbs().maxCoeff());
  const std::vector<Spring> written(network.springs.begin(), network.springs.end());
  const std::vector<Spring> found(read.springs.begin(), read.springs.end());
  worst.add(written.size() == found.size() ? 0.0 : std::nan(""));
  for (std::size_t n = 0; n < std::min(written.size(), found.size()); ++n) {
    worst.add(std::abs(found[n].stiffness - written[n].stiffness));
    worst.add(std::abs(found[n].viscosity - written[n].viscosity));
    worst.add(std::abs(found[n].rest_length - written[n].rest_length));
    worst.add(std::abs(found[n].a - written[n].a) + std::abs(found[n].b - written[n].b));
  }
  outcome.judge_at_most("largest_change", worst.value(), 0.0,
                        "17 digits hold a double: the same bits");
  measure_surface_file(context, outcome);
  measure_slices(context, outcome);
}

}  // namespace

std::vector<Case> patient_cases() {
  return {
      {"patient/library", "model",
       "Library materials and the depths of the shipped scenes are the published figures.",
       measure_library, 0.1},
      {"patient/files", "model",
       "A network is the same after it was written and read, and a surface and slices of 16 bits "
       "have the lengths and the brightness of their files.",
       measure_files, 0.1},
      {"patient/lumbar", "accuracy",
       "On a network sampled from a patient's MRI, pressed and let go, every scheme converges "
       "at its order to what independent solvers agree on",
       measure_lumbar, 100.0, false}};
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
/// What a spring costs in a step, by kernel and size, beside what the machine allows and what other engines
/// take.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/machine_limits.hpp"

namespace palpate::bench {

namespace {

struct Variant {
  const char* name;
  Precision precision = Precision::double_precision;
  bool lattice = true;  ///< else the same springs in a list
  bool uneven = false;  ///< stiffness of its own for every spring
  bool damped = true;
};

constexpr std::array<Variant, 8> variants{
    {{.name = "lattice, double"},
     {.name = "lattice, float", .precision = Precision::single_precision},
     {.name = "lattice, own stiffness, double", .uneven = true},
     {.name = "lattice, own stiffness, float", .precision = Precision::single_precision, .uneven = true},
     {.name = "lattice, undamped, double", .damped = false},
     {.name = "lattice, undamped, float", .precision = Precision::single_precision, .damped = false},
     {.name = "list, double", .lattice = false},
     {.name = "list, float", .precision = Precision::single_precision, .lattice = false}}};

/// A spring that no lattice has, so weak that it changes nothing: the network goes through its list.
void break_lattice(SpringNetwork& network) {
  const double distance = (network.rest_position.col(2) - network.rest_position.col(0)).norm();
  network.springs.push_back({0, 2, 1e-9, 0.0, distance});
}

/// One step of semi-implicit Euler a tick: one force evaluation.
std::unique_ptr<Simulation> simulation_of(const Variant& variant, int n) {
  Scene scene = s26_scene(n);
  scene.simulation.precision = variant.precision;
  SpringNetwork network = build_network(scene);
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    // Golden ratio: spread evenly between 0.75 and 1.25, no two alike.
    const double share = 0.618033988749895 * static_cast<double>(s);
    if (variant.uneven) { network.springs[s].stiffness *= 0.75 + 0.5 * (share - std::floor(share)); }
    if (!variant.damped) { network.springs[s].viscosity = 0.0; }
  }
  if (!variant.lattice) { break_lattice(network); }
  return std::make_unique<Simulation>(scene, network);
}

/// [ns] per spring and step, by variant, least and median.
std::vector<Timed> time_variants(int n) {
  std::vector<std::unique_ptr<Simulation>> simulations;
  std::vector<Contender> contenders;
  std::vector<double> springs;
  for (const Variant& variant : variants) {
    simulations.push_back(simulation_of(variant, n));
    Simulation* simulation = simulations.back().get();
    springs.push_back(static_cast<double>(simulation->spring_count()));
    contenders.push_back({variant.name, [simulation](long times) {
                            for (long k = 0; k < times; ++k) { (void)simulation->tick(); }
                          }});
  }
  std::vector<Timed> timed = time_interleaved(contenders);
  for (std::size_t v = 0; v < timed.size(); ++v) {
    timed[v].least *= 1e9 / springs[v];
    timed[v].median *= 1e9 / springs[v];
  }
  return timed;
}

/// Of a spring's square root and division alone [ns].
struct Limits {
  double in_double = 0.0;
  double in_float = 0.0;
  double bandwidth = 0.0;  ///< [bytes/s]
};

Limits measure_limits() {
  RootsAndQuotients<double> in_double;
  RootsAndQuotients<float> in_float;
  Triad triad;
  const std::vector<Timed> timed =
      time_interleaved({{"double", [&](long times) { in_double.repeat(times); }},
                        {"float", [&](long times) { in_float.repeat(times); }},
                        {"triad", [&](long times) { triad.repeat(times); }}});
  return {.in_double = 1e9 * timed[0].least / RootsAndQuotients<double>::count,
          .in_float = 1e9 * timed[1].least / RootsAndQuotients<float>::count,
          .bandwidth = Triad::bytes / timed[2].least};
}

/// Measured before this project began, one thread of a Zen 3 EPYC, g++ 12 -O3 -march=native, the same problem;
/// not measured again here.
Table peers_table() {
  Table table{.id = "peers",
              .title = "What other engines took for the same problem",
              .caption = "Nanoseconds per spring and step, one thread of another machine (AMD EPYC, Zen 3, about 3 "
                         "GHz; g++ 12.2, -O3 -march=native), measured before this project; n = 10, 20, 40.",
              .columns = {"engine", "version", "n = 10", "n = 20", "n = 40", "same physics"}};
  table.rows = {{"CHAI3D GEL, linear springs", "7c76b1f", 6.3, 7.7, 12.8, "no damping of springs"},
                {"VegaFEM, force and semi-implicit Euler", "3.1", 8.6, 8.6, 10.0, "no damping of springs"},
                {"Bullet soft body, 1 iteration", "3.25", 18.3, 19.2, 34.2, "position based"},
                {"OpenSurgSim, modified Euler", "0.7.0", 20.5, "-", "-", "yes"},
                {"SOFA regular-grid springs, explicit Euler", "v26.06", 57.5, 58.4, 58.8, "yes"},
                {"XPBD of the PBD library, 1 substep", "d0894bd", 59.0, 99.0, 247.0, "no damping"}};
  return table;
}

Table limits_table(const Limits& limits) {
  return {.id = "limits",
          .title = "What this machine allows",
          .caption = "A square root and a division for each spring, with the instructions that the kernels use; "
                     "and a = b + c x over vectors beyond every cache.",
          .columns = {"limit", "value", "unit"},
          .rows = {{"root and quotient, double", limits.in_double, "ns"},
                   {"root and quotient, float", limits.in_float, "ns"},
                   {"memory", 1e-9 * limits.bandwidth, "GB/s"}},
          .timing = true};
}

struct Sizes {
  std::vector<int> n{};
  std::vector<std::vector<Timed>> timed{};
};

Table times_table(const Sizes& sizes) {
  Table table{.id = "kernels",
              .title = "Time of a spring in a step",
              .caption = "Nanoseconds per spring and step of semi-implicit Euler, whole ticks: least, and median in "
                         "brackets, of interleaved rounds by the processor time of one thread.",
              .columns = {"kernel"},
              .timing = true};
  for (const int n : sizes.n) { table.columns.push_back("n = " + std::to_string(n) + " (ns)"); }
  for (std::size_t v = 0; v < variants.size(); ++v) {
    std::vector<Cell> row{std::string(variants[v].name)};
    for (const std::vector<Timed>& timed : sizes.timed) {
      std::array<char, 48> text{};
      std::snprintf(text.data(), text.size(), "%.2f (%.2f)", timed[v].least, timed[v].median);
      row.emplace_back(std::string(text.data()));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Figure times_figure(const Sizes& sizes, const Limits& limits) {
  Figure figure{.id = "kernels",
                .title = "Time of a spring in a step, by size",
                .caption = "Least of interleaved rounds; dashed: a square root and a division alone.",
                .x = {.label = "nodes along a side (1)", .logarithmic = true},
                .y = {.label = "time per spring and step (ns)", .logarithmic = true},
                .timing = true};
  for (std::size_t v = 0; v < variants.size(); ++v) {
    Series series{.label = variants[v].name, .style = Series::Style::line_and_points};
    for (std::size_t k = 0; k < sizes.n.size(); ++k) {
      series.x.push_back(sizes.n[k]);
      series.y.push_back(sizes.timed[k][v].least);
    }
    figure.series.push_back(std::move(series));
  }
  const double first = sizes.n.front();
  const double last = sizes.n.back();
  for (const auto& [label, value] :
       {std::pair{"limit, double", limits.in_double}, {"limit, float", limits.in_float}}) {
    figure.series.push_back(
        {.label = label, .style = Series::Style::dashed, .x = {first, last}, .y = {value, value}});
  }
  return figure;
}

void measure(const CaseContext& context, Outcome& outcome) {
  Sizes sizes{.n = context.quick ? std::vector{10, 20} : std::vector{10, 20, 40, 80}};
  const Limits limits = measure_limits();
  for (const int n : sizes.n) { sizes.timed.push_back(time_variants(n)); }
  for (std::size_t k = 0; k < sizes.n.size(); ++k) {
    const std::vector<Timed>& timed = sizes.timed[k];
    const std::string size = "n" + std::to_string(sizes.n[k]);
    outcome.judge({.name = "list_over_lattice_double_" + size,
                   .value = timed[6].least / timed[0].least,
                   .lower = 2.0,
                   .bound_from = "a kernel of its own must at least halve the cost, else it goes"});
    outcome.judge({.name = "list_over_lattice_float_" + size,
                   .value = timed[7].least / timed[1].least,
                   .lower = 2.0,
                   .bound_from = "a kernel of its own must at least halve the cost, else it goes"});
    outcome.timings.push_back({"lattice_double_" + size, timed[0].least, "ns"});
    outcome.timings.push_back({"lattice_float_" + size, timed[1].least, "ns"});
    outcome.timings.push_back({"lattice_over_limit_double_" + size, timed[0].least / limits.in_double, "1"});
  }
  outcome.tables = {times_table(sizes), limits_table(limits), peers_table()};
  outcome.figures.push_back(times_figure(sizes, limits));
}

}  // namespace

Scene s26_scene(int n) {
  Scene scene;
  scene.title = "S26, " + std::to_string(n) + " nodes a side";
  scene.simulation = {.duration = 0.1, .step = 1e-3, .integrator = "euler-cromer"};
  scene.simulation.substeps = 1;
  scene.tissue.source = Source::lattice;
  scene.tissue.fixed = std::vector<Face>{Face::z_min};
  scene.tissue.lattice = {.nodes = {n, n, n},
                          .spacing = 0.01,
                          .connectivity = 26,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.05,
                          .node_mass = 1e-3};
  const int middle = ((n - 1) * n + n / 2) * n + n / 2;
  scene.loads = {{.nodes = {middle}, .force = {0.0, 0.0, 0.1}}};
  scene.records = {{.name = "tip", .where = middle, .quantities = {RecordedQuantity::position}}};
  return scene;
}

std::vector<Case> kernel_cases() {
  return {{.name = "bench/kernels",
           .suite = "timing",
           .claim = "Kernels of regular lattices cost less than half of a list of springs, at every size.",
           .measure = measure,
           .weight = 60.0}};
}

}  // namespace palpate::bench

// SPDX-License-Identifier: MIT
#include "validation/bench/kernel_tables.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace palpate::bench {

std::string two_digits(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", value);
  return text.data();
}

namespace {

Table times_table(std::span<const KernelSize> sizes) {
  Table table{.id = "kernels",
              .title = "Time of a spring in a step",
              .caption =
                  "Nanoseconds per spring and step of semi-implicit Euler: least, and median in brackets, of "
                  "interleaved rounds by the processor time of one thread. A lattice takes the step in one "
                  "pass over memory.",
              .columns = {"kernel"},
              .timing = true};
  for (const KernelSize& size : sizes) { table.columns.push_back("n = " + std::to_string(size.n) + " (ns)"); }
  for (const KernelVariant& variant : kernel_variants()) {
    std::vector<Cell> row{std::string(variant.name)};
    for (const KernelSize& size : sizes) {
      const KernelTime* time = size.find(variant.name);
      row.emplace_back(time == nullptr ? "-"
                                       : two_digits(time->least) + " (" + two_digits(time->median) + ")");
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table bounds_table(std::span<const KernelSize> sizes) {
  Table table{.id = "bounds",
              .title = "How far lattices are from what the machine allows",
              .caption =
                  "The bound is the larger of two: a square root and a division; and the bytes that a step "
                  "in one pass cannot do without (of each node position and velocity, read and "
                  "written, the inverse mass, read; with a stiffness of its own also 13 pairs of "
                  "constants, 13 numbers undamped) at the bandwidth that a += x b reached over as much "
                  "data in the same rounds.",
              .columns = {"kernel", "n", "bytes per spring", "bandwidth (GB/s)", "memory (ns)",
                          "root, quotient (ns)", "time (ns)", "time / bound"},
              .timing = true};
  for (const KernelVariant& variant : kernel_variants()) {
    if (!variant.lattice) { continue; }
    for (const KernelSize& size : sizes) {
      const KernelTime* t = size.find(variant.name);
      if (t == nullptr) { continue; }
      table.rows.push_back({std::string(variant.name), static_cast<double>(size.n), t->bytes,
                            1e-9 * t->bandwidth, t->memory(), t->root, t->least, t->least / t->bound()});
    }
  }
  return table;
}

Table limits_table(const RootLimits& limits) {
  return {
      .id = "limits",
      .title = "What arithmetic costs here",
      .caption = "A square root and a division for each spring, with the instructions that the kernels use.",
      .columns = {"limit", "value (ns)"},
      .rows = {{"root and quotient, double", limits.in_double},
               {"root and quotient, float", limits.in_float}},
      .timing = true};
}

/// What was asked of the project on one core of the machine of the peers' table.
struct Target {
  const char* kernel;
  int n;
  double ns;
};
constexpr std::array targets{Target{"lattice, double", 20, 1.6},
                             Target{"lattice, double", 40, 1.6},
                             Target{"lattice, float", 20, 0.8},
                             Target{"lattice, float", 40, 0.8},
                             Target{"lattice, own stiffness, double", 20, 2.2},
                             Target{"lattice, own stiffness, double", 40, 2.2},
                             Target{"lattice, own stiffness, float", 20, 1.1},
                             Target{"lattice, own stiffness, float", 40, 1.1},
                             Target{"list, double", 80, 4.0}};

Table targets_table(std::span<const KernelSize> sizes) {
  Table table{.id = "targets",
              .title = "Beside the aims",
              .caption =
                  "Aims are for one core of a 3 GHz AMD EPYC, Zen 3. Machines differ, so nothing here is "
                  "judged.",
              .columns = {"kernel", "n", "aim (ns)", "least here (ns)", "here / aim (1)"},
              .timing = true};
  for (const Target& target : targets) {
    const auto size = std::ranges::find(sizes, target.n, &KernelSize::n);
    const KernelTime* time = size == sizes.end() ? nullptr : size->find(target.kernel);
    if (time == nullptr) { continue; }
    table.rows.push_back({std::string(target.kernel), static_cast<double>(target.n), target.ns, time->least,
                          time->least / target.ns});
  }
  return table;
}

/// Measured before this project began, one thread of a Zen 3 EPYC, g++ 12 -O3 -march=native, the same
/// problem; not measured again here.
struct Peer {
  const char* engine;
  const char* version;
  std::array<double, 3> ns;  ///< n = 10, 20, 40; 0: no figure
  const char* same_physics;
};
constexpr std::array peer_sizes{10, 20, 40};
constexpr std::array peers{
    Peer{"CHAI3D GEL, linear springs", "7c76b1f", {6.3, 7.7, 12.8}, "no damping of springs"},
    Peer{"VegaFEM, force and semi-implicit Euler", "3.1", {8.6, 8.6, 10.0}, "no damping of springs"},
    Peer{"Bullet soft body, 1 iteration", "3.25", {18.3, 19.2, 34.2}, "position based"},
    Peer{"OpenSurgSim, modified Euler", "0.7.0", {20.5, 0.0, 0.0}, "yes"},
    Peer{"SOFA regular-grid springs, explicit Euler", "v26.06", {57.5, 58.4, 58.8}, "yes"},
    Peer{"XPBD of the PBD library, 1 substep", "d0894bd", {59.0, 99.0, 247.0}, "no damping"}};

/// "7.7 (5.1 x)": how many times longer than the damped lattice in double takes here.
std::string peer_cell(std::span<const KernelSize> sizes, int n, double ns) {
  if (ns == 0.0) { return "-"; }
  std::array<char, 48> text{};
  const auto size = std::ranges::find(sizes, n, &KernelSize::n);
  const KernelTime* here = size == sizes.end() ? nullptr : size->find(kernel_variants().front().name);
  if (here == nullptr) {
    std::snprintf(text.data(), text.size(), "%.1f", ns);
  } else {
    std::snprintf(text.data(), text.size(), "%.1f (%.1f x)", ns, ns / here->least);
  }
  return text.data();
}

Table peers_table(std::span<const KernelSize> sizes) {
  Table table{.id = "peers",
              .title = "What other engines took for the same problem",
              .caption =
                  "Nanoseconds per spring and step, one thread of another machine (AMD EPYC, Zen 3, about 3 "
                  "GHz; g++ 12.2, -O3 -march=native), measured before this project; in brackets over the "
                  "damped lattice in double here, which is to be 4 times quicker than the fastest and 25 "
                  "times quicker than SOFA. Not judged: the machines may differ.",
              .columns = {"engine", "version", "n = 10 (ns)", "n = 20 (ns)", "n = 40 (ns)", "same physics"},
              .timing = true};
  for (const Peer& peer : peers) {
    std::vector<Cell> row{std::string(peer.engine), std::string(peer.version)};
    for (std::size_t k = 0; k < peer_sizes.size(); ++k) {
      row.emplace_back(peer_cell(sizes, peer_sizes[k], peer.ns[k]));
    }
    row.emplace_back(std::string(peer.same_physics));
    table.rows.push_back(std::move(row));
  }
  return table;
}

template <class Value>
void add_curve(std::span<const KernelSize> sizes, const KernelVariant& variant, const std::string& label,
               Series::Style style, Value&& value, Figure& figure) {
  Series series{.label = label, .style = style};
  for (const KernelSize& size : sizes) {
    const KernelTime* time = size.find(variant.name);
    if (time == nullptr) { continue; }
    series.x.push_back(size.n);
    series.y.push_back(value(*time));
  }
  figure.series.push_back(std::move(series));
}

Figure times_figure(std::span<const KernelSize> sizes, const RootLimits& limits, Precision precision) {
  const bool in_double = precision == Precision::double_precision;
  const std::string kind = in_double ? "double" : "float";
  Figure figure{.id = "kernels-" + kind,
                .title = "Time of a spring in a step by size, " + kind,
                .caption =
                    "Least of interleaved rounds. Dashed, what no damped lattice can beat: a square root and "
                    "a division; and what memory takes for the bytes of a step, in the same rounds.",
                .x = {.label = "nodes along a side (1)", .logarithmic = true},
                .y = {.label = "time per spring and step (ns)", .logarithmic = true},
                .timing = true};
  for (const KernelVariant& variant : kernel_variants()) {
    if (variant.precision != precision || (!variant.damped && (variant.uneven || !variant.lattice))) {
      continue;
    }
    const std::string name = variant.name;
    add_curve(
        sizes, variant, name.substr(0, name.rfind(',')), Series::Style::line_and_points,
        [](const KernelTime& t) { return t.least; }, figure);
  }
  const double root = in_double ? limits.in_double : limits.in_float;
  figure.series.push_back({.label = "bound: root, quotient",
                           .style = Series::Style::dashed,
                           .x = {static_cast<double>(sizes.front().n), static_cast<double>(sizes.back().n)},
                           .y = {root, root}});
  for (const KernelVariant& variant : kernel_variants()) {
    if (variant.precision != precision || !variant.lattice || !variant.damped) { continue; }
    add_curve(
        sizes, variant, variant.uneven ? "bound: memory, own stiffness" : "bound: memory",
        Series::Style::dashed, [](const KernelTime& t) { return t.memory(); }, figure);
  }
  return figure;
}

}  // namespace

const KernelTime* KernelSize::find(std::string_view name) const {
  const auto found =
      std::ranges::find_if(times, [&](const KernelTime& time) { return name == time.variant->name; });
  return found == times.end() ? nullptr : &*found;
}

std::vector<Table> kernel_tables(std::span<const KernelSize> sizes, const RootLimits& limits) {
  return {times_table(sizes), bounds_table(sizes), targets_table(sizes), limits_table(limits),
          peers_table(sizes)};
}

std::vector<Figure> kernel_figures(std::span<const KernelSize> sizes, const RootLimits& limits) {
  return {times_figure(sizes, limits, Precision::double_precision),
          times_figure(sizes, limits, Precision::single_precision)};
}

}  // namespace palpate::bench

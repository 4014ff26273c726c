// SPDX-License-Identifier: MIT
/// What a spring costs in a step, by kernel and size, beside what the machine allows and what other engines
/// take.
#include <cmath>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/kernel_tables.hpp"
#include "validation/bench/machine_limits.hpp"

namespace palpate::bench {

namespace {

RootLimits measure_roots() {
  RootsAndQuotients<double> in_double;
  RootsAndQuotients<float> in_float;
  const std::vector<Timed> timed = time_interleaved({{"double", [&](long times) { in_double.repeat(times); }},
                                                     {"float", [&](long times) { in_float.repeat(times); }}});
  return {.in_double = 1e9 * timed[0].least / RootsAndQuotients<double>::count,
          .in_float = 1e9 * timed[1].least / RootsAndQuotients<float>::count};
}

/// All kernels of one size, and for each lattice memory with as much data as it has, in the same rounds.
KernelSize measure_size(int n, std::span<const KernelVariant> variants, const RootLimits& limits) {
  std::vector<std::unique_ptr<Stepping>> steppings;
  std::vector<std::unique_ptr<VectorUpdate>> updates;
  std::vector<Contender> contenders;
  for (const KernelVariant& variant : variants) {
    steppings.push_back(stepping_of(variant, n));
    contenders.push_back(
        {variant.name, [&stepping = *steppings.back()](long times) { stepping.step(times); }});
  }
  for (const KernelVariant& variant : variants) {
    if (!variant.lattice) { continue; }
    updates.push_back(std::make_unique<VectorUpdate>(working_set(variant, n)));
    contenders.push_back({variant.name, [&update = *updates.back()](long times) { update.repeat(times); }});
  }
  const std::vector<Timed> timed = time_interleaved(contenders);
  KernelSize size{.n = n};
  std::size_t lattices = 0;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const double springs = steppings[v]->springs();
    KernelTime time{.variant = &variants[v],
                    .least = 1e9 * timed[v].least / springs,
                    .median = 1e9 * timed[v].median / springs,
                    .root = variants[v].in_double() ? limits.in_double : limits.in_float};
    if (variants[v].lattice) {
      time.bytes = bytes_moved(variants[v], n) / springs;
      time.bandwidth = updates[lattices]->bytes_moved() / timed[variants.size() + lattices].least;
      ++lattices;
    }
    size.times.push_back(time);
  }
  return size;
}

void judge_list(const KernelSize& size, const std::string& kind, Outcome& outcome) {
  const KernelTime* list = size.find("list, " + kind);
  const KernelTime* lattice = size.find("lattice, " + kind);
  if (list == nullptr || lattice == nullptr) { return; }
  outcome.judge({.name = "list_over_lattice_" + kind + "_n" + std::to_string(size.n),
                 .value = list->least / lattice->least,
                 .lower = 2.0,
                 .bound_from = "a kernel of its own must at least halve the cost, else it goes"});
}

void judge_bound(const KernelSize& size, const std::string& kind, Outcome& outcome) {
  const KernelTime* lattice = size.find("lattice, " + kind);
  if (size.n != 80 || lattice == nullptr) { return; }
  outcome.judge({.name = "lattice_over_bound_" + kind + "_n80",
                 .value = lattice->least / lattice->bound(),
                 .upper = 1.3,
                 .bound_from =
                     "asked of the project: at most so far from the larger of root and quotient, and "
                     "memory, measured in the same run"});
}

void measure(const CaseContext& context, Outcome& outcome) {
  const RootLimits limits = measure_roots();
  std::vector<KernelSize> sizes;
  for (const int n : context.quick ? std::vector{10, 20} : std::vector{10, 20, 40, 80, 100}) {
    sizes.push_back(measure_size(n, n > 80 ? largest_variants() : kernel_variants(), limits));
  }
  for (const KernelSize& size : sizes) {
    for (const char* kind : {"double", "float"}) {
      judge_list(size, kind, outcome);
      judge_bound(size, kind, outcome);
    }
    for (const KernelTime& time : size.times) {
      outcome.timings.push_back(
          {std::string(time.variant->name) + ", n = " + std::to_string(size.n), time.least, "ns"});
    }
  }
  outcome.tables = kernel_tables(sizes, limits);
  outcome.figures = kernel_figures(sizes, limits);
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
  return {
      {.name = "bench/kernels",
       .suite = "timing",
       .claim =
           "Kernels of regular lattices cost less than half of a list of springs at every size, and beyond "
           "the caches little more than what memory or a root and a quotient take.",
       .measure = measure,
       .weight = 60.0}};
}

}  // namespace palpate::bench

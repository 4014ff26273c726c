// SPDX-License-Identifier: MIT
/// What kernels for wider instruction sets are worth: the same steps of the same lattice with each that this processor
/// has.
#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "model/stepping/lattice_springs.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/kernel_variants.hpp"

namespace palpate::bench {

namespace {

/// The best first.
template <class Real>
std::vector<KernelVariant> sets_in(KernelVariant variant) {
  std::vector<KernelVariant> sets;
  for (const lattice::Kernels<Real>& kernels : lattice_kernels<Real>()) {
    variant.instructions = kernels.name;
    sets.push_back(variant);
  }
  return sets;
}

/// Nanoseconds of a spring and step with each, least of interleaved rounds.
std::vector<double> time_sets(const std::vector<KernelVariant>& sets, int n) {
  std::vector<std::unique_ptr<Stepping>> steppings;
  std::vector<Contender> contenders;
  for (const KernelVariant& set : sets) {
    steppings.push_back(stepping_of(set, n));
    contenders.push_back(
        {set.instructions, [&stepping = *steppings.back()](long times) { stepping.step(times); }});
  }
  std::vector<double> least;
  for (const Timed& timed : time_interleaved(contenders)) {
    least.push_back(1e9 * timed.least / steppings.front()->springs());
  }
  return least;
}

void measure(const CaseContext& /*context*/, Outcome& outcome) {
  if (lattice_kernels<double>().size() == 1) {
    outcome.skip("this processor has no more than the baseline, or PALPATE_INSTRUCTIONS allows no more");
    return;
  }
  Table table{.id = "instruction-sets",
              .title = "Kernels for each instruction set of this processor",
              .caption = "The problem of bench/kernels in regular lattices; nanoseconds per spring and step of "
                         "semi-implicit Euler, least of interleaved rounds by the processor time of one thread.",
              .columns = {"kernel", "n"},
              .timing = true};
  for (const lattice::Kernels<double>& kernels : lattice_kernels<double>()) {
    table.columns.push_back(std::string(kernels.name) + " (ns)");
  }
  table.columns.emplace_back("smallest / widest (1)");
  double worst = std::numeric_limits<double>::infinity();
  for (const KernelVariant& variant : largest_variants()) {
    const std::vector<KernelVariant> sets = variant.in_double() ? sets_in<double>(variant) : sets_in<float>(variant);
    for (const int n : {10, 20, 40}) {
      const std::vector<double> times = time_sets(sets, n);
      std::vector<Cell> row{std::string(variant.name), static_cast<double>(n)};
      row.insert(row.end(), times.begin(), times.end());
      row.emplace_back(times.back() / times.front());
      table.rows.push_back(std::move(row));
      for (std::size_t s = 1; s < sets.size(); ++s) { worst = std::min(worst, times[s] / times.front()); }
    }
  }
  outcome.tables.push_back(std::move(table));
  outcome.judge({.name = "least_worth_of_the_widest",
                 .value = worst,
                 .lower = 0.9,
                 .bound_from = "wanted: the kernels that are chosen are the quickest; a tenth is noise of this comparison"});
}

}  // namespace

std::vector<Case> instruction_set_cases() {
  return {{.name = "bench/instruction-sets",
           .suite = "timing",
           .claim = "Of a regular lattice's kernels for the instruction sets of this processor the widest is the quickest.",
           .measure = measure,
           .weight = 20.0}};
}

}  // namespace palpate::bench

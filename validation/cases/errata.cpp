// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "validation/cases/errata_parts.hpp"
#include "validation/cases/groups.hpp"

namespace palpate {

namespace {

using namespace errata;

struct Erratum {
  std::string name;
  std::string claim;
  Finding (*measure)(const CaseContext& context, Outcome& outcome);
};

const std::array<Erratum, 7>& all_errata() {
  static const std::array<Erratum, 7> all{
      Erratum{"sign",
              "With the printed sign a lattice diverges at the rate that its equations say.",
              measure_sign},
      Erratum{"reversed",
              "With the printed force turned round the dampers make a lattice diverge at the rate "
              "that its equations say.",
              measure_reversed},
      Erratum{"direction", "Multiplying by d instead of u makes stiffness scale with length.",
              measure_direction},
      Erratum{"half-force", "Halving each force halves stiffness and damping, exactly.",
              measure_half_force},
      Erratum{"no-time-step", "Without the time step every tick is a step of one second.",
              measure_no_time_step},
      Erratum{"lagged-velocity",
              "The printed spring velocity costs one order of accuracy and some stability.",
              measure_lagged_velocity},
      Erratum{"all-printed", "The equations as printed diverge within a few ticks.",
              measure_all_printed}};
  return all;
}

void measure_summary(const CaseContext& context, Outcome& outcome) {
  Table table{
      .id = "errata",
      .title = "What each printed form does",
      .caption =
          "Each erratum alone and all together, measured on the model and predicted "
          "from the printed equations.",
      .columns = {"erratum", "printed in", "what it does", "quantity", "measured", "predicted"}};
  for (const Erratum& erratum : all_errata()) {
    Outcome own;
    const Finding finding = erratum.measure(context, own);
    conclude(own);
    outcome.judge({.name = erratum.name + ": claims that do not hold",
                   .value = static_cast<double>(std::ranges::count_if(
                       own.quantities, [](const Quantity& q) { return q.judged() && !q.holds(); })),
                   .upper = 0.0,
                   .bound_from = "errata/" + erratum.name});
    outcome.judge({.name = erratum.name + ": measured over predicted",
                   .value = finding.measured / finding.predicted});
    table.rows.push_back({finding.erratum, finding.printed, finding.effect, finding.quantity,
                          finding.measured, finding.predicted});
  }
  outcome.tables.push_back(std::move(table));
}

}  // namespace

std::vector<Case> errata_cases() {
  std::vector<Case> cases;
  for (const Erratum& erratum : all_errata()) {
    cases.push_back({.name = "errata/" + erratum.name,
                     .suite = "model",
                     .claim = erratum.claim,
                     .measure = [&erratum](const CaseContext& context,
                                           Outcome& outcome) { erratum.measure(context, outcome); },
                     .weight = 0.5});
  }
  cases.push_back({.name = "errata/summary",
                   .suite = "model",
                   .claim = "Each printed form does what its equations predict.",
                   .measure = measure_summary,
                   .weight = 3.0});
  return cases;
}

}  // namespace palpate

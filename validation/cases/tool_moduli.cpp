// SPDX-License-Identifier: MIT
/// Published moduli of ligament under a needle, at ticks of a millisecond.
#include <cmath>

#include "validation/cases/tool_setting.hpp"

namespace palpate::tools {

namespace {

void measure_moduli(const CaseContext& context, Outcome& outcome) {
  Scene scene = seven_published_layers(8);
  scene.drive->speed = 0.02;
  const double whole = 2.1;
  std::vector<std::vector<Cell>> rows;
  Insertion runs[2];
  const char* names[] = {"auto", "velocity-verlet"};
  for (int n = 0; n < 2; ++n) {
    scene.simulation = {.duration = n == 0 ? whole : context.quick ? 0.3 : whole,
                        .step = 1e-3,
                        .integrator = names[n]};
    runs[n] = insert_tool(context, scene);
    const double ticks = static_cast<double>(runs[n].tool.size() - 1);
    rows.push_back({runs[n].integrator, static_cast<double>(runs[n].substeps),
                    1e3 * runs[n].seconds / ticks});
    outcome.timings.push_back({"ms_per_tick_" + runs[n].integrator, 1e3 * runs[n].seconds / ticks,
                               "ms"});
  }
  const Insertion& chosen = runs[0];
  outcome.judge({.name = "diverged", .value = chosen.diverged ? 1.0 : 0.0, .upper = 0.0,
                 .bound_from = "stable at ticks of 1 ms, whatever the integrator needs inside"});
  outcome.judge({.name = "loss_of_resistance", .value = static_cast<double>(
                     chosen.count("loss-of-resistance")), .lower = 1.0, .upper = 1.0,
                 .bound_from = "the needle arrives"});
  double worst = 0.0;
  double peak = 0.0;
  std::vector<double> depth, force, other;
  const std::size_t samples = std::min(runs[0].tool.size(), runs[1].tool.size());
  for (std::size_t n = 0; n < runs[0].tool.size(); ++n) {
    depth.push_back(1e3 * runs[0].tool[n].place);
    force.push_back(runs[0].tool[n].forces.total);
    peak = std::fmax(peak, force.back());
    if (n < samples) { other.push_back(runs[1].tool[n].forces.total); }
  }
  // At punctures the two may be a tick apart, where the whole force drops.
  std::size_t far = 0;
  for (std::size_t n = 0; n < samples; ++n) {
    const double error = std::abs(force[n] - other[n]);
    if (!(error <= 0.01 * peak)) { ++far; }
    worst = std::isnan(error) ? error : std::max(worst, error);
  }
  outcome.judge({.name = "share_of_ticks_more_than_1_percent_of_peak_apart",
                 .value = std::isnan(worst) ? worst
                                            : static_cast<double>(far) / static_cast<double>(samples),
                 .upper = 0.02,
                 .bound_from = "implicit and explicit stepping agree but for the ticks at punctures "
                               "and the jolt of the first contact"});
  outcome.judge({.name = "peak_force", .value = peak, .unit = "N", .lower = 8.0, .upper = 16.0,
                 .bound_from = "published: 12.1 N at the flavum (Davidor et al. 2023), within a "
                               "third"});
  outcome.tables.push_back({.id = "cost",
                            .title = "What a tick of 1 ms costs",
                            .columns = {"integrator", "substeps", "time per tick (ms)"},
                            .rows = rows,
                            .timing = true});
  Figure figure{.id = "force-depth",
                .title = "Force over depth with published moduli",
                .caption = "Seven layers at 20 mm/s: automatic stepping and explicit stepping with "
                           "a hundred substeps.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series.push_back(curve(chosen.integrator, depth, force));
  depth.resize(other.size());
  figure.series.push_back(curve("velocity-verlet", depth, other, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> moduli_cases() {
  return {{.name = "needle/published-moduli",
           .suite = "stability",
           .claim = "Ligament of 15 MPa is stable at ticks of 1 ms, and what it costs is told.",
           .measure = measure_moduli,
           .weight = 10.0}};
}

}  // namespace palpate::tools

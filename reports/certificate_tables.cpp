// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>

#include "reports/certificate_report.hpp"
#include "reports/markup.hpp"
#include "reports/shown_units.hpp"
#include "validation/certificate/miss_bound.hpp"

namespace palpate {
namespace {

using namespace certificate;

Cell time_cell(const std::optional<double>& seconds) {
  return seconds ? Cell(us * *seconds) : Cell(std::string("too few ticks"));
}

std::string place_of(const CertificateReport& report, bool empty, const Peak& worst) {
  const std::string tick = "tick " + std::to_string(worst.tick);
  if (empty) { return tick; }
  const std::string event = happening_at(report, worst.moment);
  return tick + ", scene at " + quantity(worst.moment.scene_time, "s") + (event.empty() ? "" : ", " + event);
}

std::vector<Cell> times_row(const CertificateReport& report, const NamedPhase& phase, const char* what,
                            const LatencyHistogram& times, const Peak& worst) {
  std::vector<Cell> row{phase.name, std::string(what), us * times.minimum()};
  for (const auto& [name, share] : shown_percentiles) {
    row.push_back(time_cell(times.percentile(share)));
  }
  row.emplace_back(us * times.maximum());
  row.emplace_back(place_of(report, phase.empty, worst));
  return row;
}

Table times_table(const CertificateReport& report) {
  Table table{
      .id = "times",
      .title = "Times of every tick",
      .caption =
          "In us, from the scheduled release. A percentile is the end of its bin of 1 us; it is left "
          "out where no tick lies above it.",
      .columns = {"phase", "what", "min"},
      .timing = true};
  for (const auto& [name, share] : shown_percentiles) { table.columns.emplace_back(name); }
  table.columns.insert(table.columns.end(), {"max", "max was at"});
  for (const NamedPhase& named : phases_of(report)) {
    const LoopRecord& record = named.phase->record;
    if (record.ticks() == 0) { continue; }
    table.rows.push_back(times_row(report, named, "wake-up", record.wakeup, record.worst_wakeup));
    table.rows.push_back(times_row(report, named, "computation", record.compute, record.worst_compute));
    table.rows.push_back(times_row(report, named, "response", record.response, record.worst_response));
  }
  return table;
}

Table misses_table(const CertificateReport& report) {
  Table table{
      .id = "misses",
      .title = "Missed deadlines",
      .caption =
          "The limit of the miss probability is the upper one of Clopper and Pearson, 95 %, one-sided. "
          "Recovery: from the first missed release until a tick was in time again.",
      .columns = {"phase", "ticks", "missed", "limit of the miss probability", "longest run",
                  "longest recovery (ms)", "restarts", "page faults", "thread pushed aside", "stolen (ms)"},
      .timing = true};
  for (const NamedPhase& named : phases_of(report)) {
    const Phase& phase = *named.phase;
    const Misses& misses = phase.record.misses;
    table.rows.push_back({named.name, static_cast<double>(phase.record.ticks()),
                          static_cast<double>(misses.count()),
                          miss_probability_upper(misses.count(), phase.record.ticks()),
                          static_cast<double>(misses.longest_run()), 1e3 * misses.longest_recovery(),
                          static_cast<double>(phase.restarts),
                          static_cast<double>(phase.counts.minor_faults + phase.counts.major_faults),
                          static_cast<double>(phase.counts.involuntary_switches), 1e3 * phase.times.stolen});
  }
  return table;
}

Table provocations_table(const CertificateReport& report) {
  Table table{.id = "provocations",
              .title = "Worst ticks, provoked",
              .caption =
                  "Time on the thread's own clock, the least of the repetitions, so that other work on the "
                  "machine does not count; costliest first. Instructions of the scene's costliest tick: " +
                  (report.result.budget.worst_instructions
                       ? short_number(static_cast<double>(*report.result.budget.worst_instructions))
                       : "not counted (" + report.not_counted + ")") +
                  ".",
              .columns = {"provocation", "how", "scene at (s)", "computes for (us)", "by the wall clock (us)",
                          "of the deadline (%)", "cycles (thousands)", "repetitions"},
              .timing = true};
  const double cycles = report.cycles_per_second.value_or(std::numeric_limits<double>::quiet_NaN());
  for (const Provocation& each : report.result.budget.provocations) {
    table.rows.push_back({each.name, each.what, each.scene_time, us * each.processor, us * each.wall,
                          100.0 * each.processor / report.result.claim.deadline,
                          report.cycles_per_second ? Cell(1e-3 * cycles * each.processor)
                                                   : Cell(std::string("no steady counter")),
                          static_cast<double>(each.repetitions)});
  }
  return table;
}

Table tail_table(const Tail& tail) {
  Table table{.id = "tail",
              .title = "What an extrapolation assumes",
              .caption = "Each check fails one time in a thousand where its claim is true.",
              .columns = {"claim", "found", "at least", "at most", "holds"},
              .timing = true};
  for (const TailCheck& check : tail.checks) {
    table.rows.push_back(
        {check.claim, check.value, check.lower, check.upper, std::string(check.holds() ? "yes" : "no")});
  }
  return table;
}

Table levels_table(const Tail& tail) {
  Table table{.id = "levels",
              .title = "Response times that were not seen",
              .caption =
                  "Exceeded by one tick in so many, by the generalised Pareto distribution above the lowest "
                  "threshold, with profile-likelihood limits; no further than two decades beyond the data.",
              .columns = {"one tick in", "response (us)", "95 % from (us)", "to (us)"},
              .timing = true};
  for (const ReturnLevel& level : tail.levels) {
    table.rows.push_back({1.0 / level.probability, us * level.value, us * level.lower, us * level.upper});
  }
  return table;
}

}  // namespace

std::vector<NamedPhase> phases_of(const CertificateReport& report) {
  std::vector<const LoadResult*> loads;
  for (const LoadResult& load : report.result.loads) { loads.push_back(&load); }
  std::ranges::stable_partition(loads, [&](const LoadResult* load) { return load == report.result.worst(); });
  std::vector<NamedPhase> phases;
  for (const LoadResult* load : loads) {
    const std::string suffix = loads.size() > 1 ? ", load " + load->load : "";
    phases.push_back({"empty loop" + suffix, &load->control, true});
    phases.push_back({"scene" + suffix, &load->scene, false});
  }
  return phases;
}

std::string happening_at(const CertificateReport& report, const Moment& moment) {
  if (!moment.happening) { return {}; }
  return report.happening_name ? report.happening_name(*moment.happening)
                               : std::string(palpate::name_of(moment.happening->event));
}

std::vector<Table> certificate_tables(const CertificateReport& report) {
  std::vector<Table> tables{times_table(report), misses_table(report), provocations_table(report)};
  if (const LoadResult* worst = report.result.worst()) {
    tables.push_back(tail_table(worst->tail));
    if (!worst->tail.levels.empty()) { tables.push_back(levels_table(worst->tail)); }
  }
  return tables;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "reports/certificate_report.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <sstream>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "reports/results/results_json.hpp"
#include "validation/gate/gate.hpp"

namespace palpate {
namespace {

using namespace certificate;

/// Name of an event: "puncture: skin".
std::string name_of_event(const CertificateReport& report, const ToolHappening& event) {
  return report.happening_name ? report.happening_name(event)
                               : std::string(palpate::name_of(event.event));
}

/// Name of the last event at the given tick; empty if there is none.
std::string happening_at(const CertificateReport& report, const Moment& moment) {
  return moment.happening ? name_of_event(report, *moment.happening) : "";
}

std::string place_of(const CertificateReport& report, bool empty, const Peak& worst) {
  const std::string tick = "tick " + std::to_string(worst.tick);
  if (empty) { return tick; }
  const std::string event = happening_at(report, worst.moment);
  return tick + ", scene at " + quantity(worst.moment.scene_time, "s") +
         (event.empty() ? "" : ", " + event);
}

Table times_table(const CertificateReport& report) {
  Table table =
      make_table("times", "Times of every tick",
                 "In us, from the scheduled release. A percentile is the end of its bin of 1 us; "
                 "it is left out where no tick lies above it.",
                 {"phase", "what", "min"});
  for (const auto& [name, share] : shown_percentiles) { table.columns.emplace_back(name); }
  table.columns.insert(table.columns.end(), {"max", "max was at"});
  for (const NamedPhase& named : phases_of(report)) {
    const LoopRecord& record = named.phase->record;
    if (record.ticks() == 0) { continue; }
    const auto add = [&](const char* what, const LatencyHistogram& times, const Peak& worst) {
      std::vector<Cell> row{named.name, std::string(what), us * times.minimum()};
      for (const auto& [name, share] : shown_percentiles) {
        const std::optional<double> time = times.percentile(share);
        row.push_back(time ? Cell(us * *time) : Cell(std::string("too few ticks")));
      }
      row.emplace_back(us * times.maximum());
      row.emplace_back(place_of(report, named.empty, worst));
      table.rows.push_back(std::move(row));
    };
    add("wake-up", record.wakeup, record.worst_wakeup);
    add("computation", record.compute, record.worst_compute);
    add("response", record.response, record.worst_response);
  }
  return table;
}

Table misses_table(const CertificateReport& report) {
  Table table = make_table(
      "misses", "Missed deadlines",
      "The limit of the miss probability is the upper one of Clopper and Pearson, 95 %, "
      "one-sided. Recovery: from the first missed release until a tick was in time again.",
      {"phase", "ticks", "missed", "limit of the miss probability", "longest run",
       "longest recovery (ms)", "restarts", "page faults", "thread pushed aside", "stolen (ms)"});
  for (const NamedPhase& named : phases_of(report)) {
    const Phase& phase = *named.phase;
    const Misses& misses = phase.record.misses;
    table.rows.push_back(
        {named.name, static_cast<double>(phase.record.ticks()), static_cast<double>(misses.count()),
         phase.miss_probability_upper(), static_cast<double>(misses.longest_run()),
         1e3 * misses.longest_recovery(), static_cast<double>(phase.restarts),
         static_cast<double>(phase.counts.minor_faults + phase.counts.major_faults),
         static_cast<double>(phase.counts.involuntary_switches), 1e3 * phase.times.stolen});
  }
  return table;
}

Table probes_table(const CertificateReport& report) {
  Table table = make_table(
      "provocations", "Worst ticks, provoked",
      "Time on the thread's own clock, the least of the repetitions, so that other work on the "
      "machine does not count; costliest first. Instructions of the scene's costliest tick: " +
          (report.result.budget.worst_instructions
               ? short_number(static_cast<double>(*report.result.budget.worst_instructions))
               : "not counted (" + report.not_counted + ")") +
          ".",
      {"provocation", "how", "scene at (s)", "computes for (us)", "by the wall clock (us)",
       "of the deadline (%)", "cycles (thousands)", "repetitions"});
  const double cycles = report.cycles_per_second.value_or(std::numeric_limits<double>::quiet_NaN());
  for (const WorstCaseProbe& each : report.result.budget.probes) {
    table.rows.push_back({each.name, each.what, each.scene_time, us * each.processor,
                          us * each.wall, 100.0 * each.processor / report.result.claim.deadline,
                          report.cycles_per_second ? Cell(1e-3 * cycles * each.processor)
                                                   : Cell(std::string("no steady counter")),
                          static_cast<double>(each.repetitions)});
  }
  return table;
}

Table tail_table(const Tail& tail) {
  Table table = make_table("tail", "Assumptions of the extrapolation",
                           "Each check fails one time in a thousand where its claim is true.",
                           {"claim", "found", "at least", "at most", "holds"});
  for (const Quantity& check : tail.checks) {
    table.rows.push_back({check.bound_from, check.value, check.lower, check.upper,
                          std::string(check.holds() ? "yes" : "no")});
  }
  return table;
}

Table levels_table(const Tail& tail) {
  Table table =
      make_table("levels", "Extrapolated response times",
                 "Exceeded by one tick in so many, by the generalised Pareto distribution above "
                 "the lowest threshold, with profile-likelihood limits; no further than two "
                 "decades beyond the data.",
                 {"one tick in", "response (us)", "95 % from (us)", "to (us)"});
  for (const ReturnLevel& level : tail.levels) {
    table.rows.push_back(
        {1.0 / level.probability, us * level.value, us * level.lower, us * level.upper});
  }
  return table;
}

struct NamedHistogram {
  std::string name{};
  const LatencyHistogram* times = nullptr;
};

std::vector<NamedHistogram> histograms_of(const LoadResult& load, const std::string& suffix) {
  return {{"wakeup" + suffix, &load.scene.record.wakeup},
          {"compute" + suffix, &load.scene.record.compute},
          {"response" + suffix, &load.scene.record.response},
          {"control" + suffix, &load.control.record.response}};
}

/// Lower end of a bar without height [ticks], on a logarithmic axis.
constexpr double floor_of_bars = 0.5;

/// Bars of the counts, as the outline of an area. Bars are 1 us wide, above 8 us an eighth of their
/// begin.
Series bars_of(const std::string& label, const LatencyHistogram& times) {
  Series bars{.label = label, .style = Series::Style::area};
  const auto counts = times.counts().first(times.used_bins());
  for (std::size_t begin = 0, end = 0; begin < counts.size(); begin = end) {
    end = begin + std::max<std::size_t>(1, begin / 8);
    const auto bar = counts.subspan(begin, std::min(end, counts.size()) - begin);
    const auto ticks = std::accumulate(bar.begin(), bar.end(), 0.0);
    if (ticks == 0.0 && bars.x.empty()) { continue; }
    for (const std::size_t edge : {begin, end}) {
      bars.x.push_back(std::max(static_cast<double>(edge), 0.5));
      bars.y.push_back(floor_of_bars);
      bars.y2.push_back(std::max(ticks, floor_of_bars));
    }
  }
  return bars;
}

/// Histograms of the response times of the scene and of the empty loop, and of the components of
/// the response time of the scene. Empty if no phase ran.
std::vector<Figure> histogram_figures(const CertificateReport& report) {
  const LoadResult* worst = report.result.worst();
  if (worst == nullptr || worst->control.record.ticks() == 0) { return {}; }
  Figure figure{
      .title = "Response: scene and empty loop",
      .caption =
          "Ticks by their time from the scheduled release, in bars of 1 us, above 8 us of an "
          "eighth of the time; a single late one is a bar up to 1.",
      .x = {.label = "time (us)", .logarithmic = true},
      .y = {.label = "ticks", .logarithmic = true, .minimum = floor_of_bars},
      .series = {bars_of("scene", worst->scene.record.response),
                 bars_of("empty loop", worst->control.record.response)},
      .marks = {{"deadline", 1e6 * report.result.claim.deadline}}};
  Figure parts = figure;
  parts.title = "Parts of the response of the scene";
  parts.caption = "Late wake-up and computation, in the same bars.";
  parts.series = {bars_of("computation", worst->scene.record.compute),
                  bars_of("wake-up", worst->scene.record.wakeup)};
  return {std::move(figure), std::move(parts)};
}

using Json = nlohmann::ordered_json;

Json micro(double seconds) { return finite_or_null(us * seconds); }

Json times_json(const CertificateReport& report, const LatencyHistogram& times, const Peak& worst) {
  if (times.count() == 0) { return nullptr; }
  Json json = object("min", us * times.minimum());
  for (const auto& [name, share] : shown_percentiles) {
    const std::optional<double> time = times.percentile(share);
    json[name] = time ? micro(*time) : Json(nullptr);
  }
  add_keys(json, "max", us * times.maximum(), "max_at_tick", worst.tick, "max_at_scene_s",
           worst.moment.scene_time, "max_at_event",
           text_or_null(happening_at(report, worst.moment)));
  return json;
}

Json phase_json(const CertificateReport& report, const Phase& phase) {
  const LoopRecord& record = phase.record;
  return object(
      "ticks", record.ticks(), "steps", phase.steps(), "misses", record.misses.count(),
      "miss_probability_upper_95", phase.miss_probability_upper(), "longest_miss_run",
      record.misses.longest_run(), "longest_recovery_us", us * record.misses.longest_recovery(),
      "wakeup_us", times_json(report, record.wakeup, record.worst_wakeup), "compute_us",
      times_json(report, record.compute, record.worst_compute), "response_us",
      times_json(report, record.response, record.worst_response), "given_up", phase.hopeless,
      "seconds", phase.seconds, "restarts", phase.restarts, "paused_s", phase.paused,
      "minor_faults", phase.counts.minor_faults, "major_faults", phase.counts.major_faults,
      "voluntary_switches", phase.counts.voluntary_switches, "involuntary_switches",
      phase.counts.involuntary_switches, "stolen_s", phase.times.stolen, "interrupts_s",
      phase.times.interrupts, "other_processors_busy_s", phase.times.others);
}

Json tail_json(const Tail& tail) {
  const auto check = [](const Quantity& each) {
    return object("name", each.name, "claim", each.bound_from, "value", finite_or_null(each.value),
                  "lower", finite_or_null(each.lower), "upper", finite_or_null(each.upper), "holds",
                  each.holds());
  };
  const auto threshold = [](const ThresholdFit& each) {
    return object("threshold_us", us * each.threshold, "exceedances", each.fit.count, "shape",
                  each.fit.shape, "scale_us", us * each.fit.scale);
  };
  const auto level = [](const ReturnLevel& each) {
    return object("probability", each.probability, "response_us", us * each.value, "lower_us",
                  us * each.lower, "upper_us", micro(each.upper));
  };
  return object("refused", text_or_null(tail.refusal), "checks", list_of(tail.checks, check),
                "fits", list_of(tail.fits, threshold), "levels", list_of(tail.levels, level),
                "miss_probability", tail.beyond_deadline);
}

Json budget_json(const CertificateReport& report) {
  const ComputeBudget& budget = report.result.budget;
  const double deadline = report.result.claim.deadline;
  const bool timed = !budget.probes.empty();
  const bool counted = budget.worst_instructions.has_value();
  const auto cycles = [&](double seconds) {
    return report.cycles_per_second ? Json(seconds * *report.cycles_per_second) : Json(nullptr);
  };
  const auto provocation = [deadline](const WorstCaseProbe& each) {
    return object("name", each.name, "what", each.what, "scene_s", each.scene_time, "processor_us",
                  us * each.processor, "wall_us", us * each.wall, "share_of_deadline",
                  each.processor / deadline, "ticks", each.ticks, "repetitions", each.repetitions);
  };
  return object("statement", budget_text(report.result), "worst_us",
                timed ? Json(us * budget.worst()) : Json(nullptr), "worst_cycles",
                timed ? cycles(budget.worst()) : Json(nullptr), "deadline_cycles", cycles(deadline),
                "cycles_per_second", report.cycles_per_second, "worst_instructions",
                budget.worst_instructions, "not_counted",
                counted ? Json(nullptr) : Json(report.not_counted), "provocations",
                list_of(budget.probes, provocation));
}

Json missed_tick_json(const std::optional<MissedTick>& missed) {
  if (!missed) { return nullptr; }
  const bool measured = missed->measured.has_value();
  return object("stiffness_n_per_m", missed->stiffness, "speed_m_per_s", missed->speed, "bound_mj",
                mj * missed->bound, "sampled_bound_mj", mj * missed->sampled_bound, "measured_mj",
                measured ? Json(mj * *missed->measured) : Json(nullptr), "measured_at_s",
                measured ? Json(missed->measured_at) : Json(nullptr));
}

Json value_json(std::monostate) { return nullptr; }
template <class Value> Json value_json(const Value& value) { return value; }

std::string headline(Status status) {
  const std::string text = capitalised(std::string(verdict_word(status)));
  return status == Status::inconclusive ? text + ": nothing is certified" : text;
}

std::vector<Fact> claim_facts(const CertificateReport& report) {
  const Certificate& all = report.result;
  std::vector<Fact> facts{
      {"scene", report.file,
       std::to_string(report.nodes) + " nodes, " + std::to_string(report.springs) +
           " springs; hash of all that ran " + report.scene_hash},
      {"rate", quantity(all.claim.rate, "Hz"),
       "a release every " + quantity(us * all.claim.period(), "us")},
      {"deadline", quantity(us * all.claim.deadline, "us"),
       "from the scheduled release until the tick is done"},
      {"allowed", "no miss", "under any load, nor by a provoked tick"},
      {"ticks needed", std::to_string(all.claim.ticks_needed()),
       "under each load, for fewer than one miss in " +
           short_number(1.0 / all.claim.max_miss_rate, 6) + " ticks with 95 % confidence" +
           (all.claim.ticks_per_step > 1
                ? "; one tick in " + std::to_string(all.claim.ticks_per_step) +
                      " steps the tissue and counts"
                : "")}};
  if (const LoadResult* worst = all.worst(); worst != nullptr && worst->scene.record.ticks() > 0) {
    facts.push_back({"miss probability",
                     "below " + short_number(worst->miss_probability_upper(), 3),
                     "with 95 % confidence, from " + std::to_string(worst->scene.record.ticks()) +
                         " ticks with " + std::to_string(worst->scene.record.misses.count()) +
                         " misses, load " + worst->load});
    facts.push_back({"scene began again", std::to_string(worst->scene.restarts) + " times",
                     "built anew in pauses between ticks of " + quantity(worst->scene.paused, "s") +
                         " in all"});
  }
  facts.push_back({"computation", budget_text(all), ""});
  return facts;
}

std::vector<Fact> energy_facts(const MissedTick& missed) {
  std::vector<Fact> facts{
      {"stiffness at the hand", quantity(missed.stiffness, "N/m"), ""},
      {"largest speed", quantity(missed.speed, "m/s"), "of grip or tool in the scene"},
      {"bound", quantity(mj * missed.bound, "mJ"),
       "1/2 K (v T)\u00b2: a spring whose force is held for a period T"},
      {"against a kept tick", quantity(mj * missed.sampled_bound, "mJ"),
       "K (v T)\u00b2: a sampled force is held anyway, and is now a period older"}};
  if (missed.measured) {
    const char* word =
        *missed.measured <= missed.sampled_bound
            ? "more than with the tick kept, at the grip: within that bound"
            : "more than with the tick kept, at the grip: beyond that bound, which is of a spring "
              "alone; the coupling's damper adds to it, and force jumps where tissue gives way";
    facts.push_back(
        {"measured", quantity(mj * *missed.measured, "mJ"),
         std::string(word) + ". The tick at " + quantity(missed.measured_at, "s") + " was missed"});
  } else {
    facts.push_back(
        {"measured", "no", "the scene has no device through which a hand would feel it"});
  }
  return facts;
}

std::string value_text(const EnvironmentFact& fact) {
  if (const bool* yes = std::get_if<bool>(&fact.value)) { return *yes ? "yes" : "no"; }
  if (const double* number = std::get_if<double>(&fact.value)) { return short_number(*number, 6); }
  const std::string* text = std::get_if<std::string>(&fact.value);
  return text != nullptr ? *text : "not reported by the system";
}

std::string tail_text(const Tail& tail) {
  if (!tail.refusal.empty()) { return "Extrapolation refused: " + tail.refusal + "."; }
  return tail.beyond_deadline ? "One tick in " + short_number(1.0 / *tail.beyond_deadline, 3) +
                                    " is expected beyond the deadline."
                              : "The deadline is more than two decades beyond the data; only the "
                                "limit above applies to it.";
}

Section loop_section(const CertificateReport& report, const std::vector<Table>& tables) {
  Section section{.heading = "The loop"};
  if (tables[0].rows.empty()) {
    section.parts.emplace_back(Notes{{"It did not run."}});
    return section;
  }
  Section exhibits = exhibits_of(histogram_figures(report));
  exhibits.parts.insert(exhibits.parts.begin(), {tables[0], tables[1]});
  section.parts.emplace_back(std::move(exhibits));
  return section;
}

Section tail_section(const Tail& tail, const std::vector<Table>& tables) {
  Section exhibits{.kind = Section::Kind::exhibits};
  for (std::size_t n = 3; n < tables.size(); ++n) {
    if (!tables[n].rows.empty()) { exhibits.parts.emplace_back(tables[n]); }
  }
  return {.heading = "Extrapolation", .parts = {Notes{{tail_text(tail)}}, std::move(exhibits)}};
}

}  // namespace

std::vector<NamedPhase> phases_of(const CertificateReport& report) {
  std::vector<const LoadResult*> loads;
  for (const LoadResult& load : report.result.loads) { loads.push_back(&load); }
  std::ranges::stable_partition(
      loads, [&](const LoadResult* load) { return load == report.result.worst(); });
  std::vector<NamedPhase> phases;
  for (const LoadResult* load : loads) {
    const std::string suffix = loads.size() > 1 ? ", load " + load->load : "";
    phases.push_back({"empty loop" + suffix, &load->control, true});
    phases.push_back({"scene" + suffix, &load->scene, false});
  }
  return phases;
}

std::string to_csv(const CertificateReport& report) {
  std::vector<NamedHistogram> columns;
  const LoadResult nothing("", report.result.claim.deadline);
  const LoadResult& worst = report.result.worst() != nullptr ? *report.result.worst() : nothing;
  std::ranges::move(histograms_of(worst, ""), std::back_inserter(columns));
  if (report.result.loads.size() > 1) {
    for (const LoadResult& load : report.result.loads) {
      std::ranges::move(histograms_of(load, "_" + load.load), std::back_inserter(columns));
    }
  }
  std::string csv = "bin_start_us";
  std::size_t bins = 0;
  for (const NamedHistogram& column : columns) {
    csv += "," + column.name;
    bins = std::max(bins, column.times->used_bins());
  }
  csv += "\n";
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const auto holds = [bin](const NamedHistogram& column) {
      return column.times->counts()[bin] > 0;
    };
    if (std::ranges::none_of(columns, holds)) { continue; }
    csv += std::to_string(bin);
    for (const NamedHistogram& column : columns) {
      csv += "," + std::to_string(column.times->counts()[bin]);
    }
    csv += "\n";
  }
  return csv;
}

std::string to_json(const CertificateReport& report) {
  const Certificate& all = report.result;
  const Outcome outcome = outcome_of(all);
  LoadResult nothing("", all.claim.deadline);
  nothing.tail.refusal = "no load was measured";
  const LoadResult& worst = all.worst() != nullptr ? *all.worst() : nothing;
  Json environment = Json::object();
  for (const EnvironmentFact& fact : report.environment) {
    environment[fact.key] =
        std::visit([](const auto& value) { return value_json(value); }, fact.value);
  }
  const auto of_load = [&report](const LoadResult& load) {
    return object("load", load.load, "control", phase_json(report, load.control), "scene",
                  phase_json(report, load.scene), "tail", tail_json(load.tail));
  };
  const auto of_input = [](const auto& input) {
    return object("file", input.first, "sha256", input.second);
  };
  const auto of_event = [&](const Happened& each) {
    const long tick = static_cast<long>(each.tick);
    return object("event", name_of_event(report, each.happening), "scene_s", each.happening.time,
                  "tick", tick, "in_loop", tick < worst.scene.record.ticks());
  };
  Json json = object("schema", 1, "verdict", verdict_word(outcome.status), "reason",
                     outcome.reason(), "interrupted", all.interrupted, "scene", report.file,
                     "title", report.title, "scene_hash", report.scene_hash, "rate_hz",
                     all.claim.rate, "deadline_us", us * all.claim.deadline, "duration_s",
                     all.claim.duration, "confidence", 0.95, "load", text_or_null(worst.load));
  json.update(phase_json(report, worst.scene));
  add_keys(json, "control", phase_json(report, worst.control), "tail", tail_json(worst.tail),
           "compute_budget", budget_json(report), "missed_tick", missed_tick_json(all.missed_tick),
           "environment", environment, "loads", list_of(all.loads, of_load), "notes", all.notes,
           "command", report.command, "provenance", report.provenance, "max_miss_rate",
           all.claim.max_miss_rate, "ticks_needed", all.claim.ticks_needed(), "events",
           list_of(all.budget.happenings, of_event), "events_absent", all.budget.absent, "nodes",
           report.nodes, "springs", report.springs, "resolved_scene", report.resolved_scene,
           "inputs", list_of(report.inputs, of_input), "subject_sha256",
           text_or_null(report.subject_hash), "subject_options",
           text_or_null(report.subject_options), "code_hash", report.code_hash, "program_sha256",
           report.program_hash, "histogram_sha256", io::sha256(to_csv(report)));
  return sealed_text(std::move(json), 2);
}

namespace {

/// Numbers of ticks of one column of histogram.csv by bin [us].
using Column = std::map<long, long>;

/// Ticks of each column of histogram.csv. Throws std::runtime_error.
std::map<std::string, Column> ticks_in(const std::string& histogram) {
  std::istringstream lines(histogram);
  std::string line;
  std::getline(lines, line);
  const auto words_of = [](const std::string& row) {
    std::vector<std::string> words;
    std::istringstream stream(row);
    for (std::string word; std::getline(stream, word, ',');) { words.push_back(word); }
    return words;
  };
  const std::vector<std::string> names = words_of(line);
  std::map<std::string, Column> ticks;
  for (std::size_t n = 1; n < names.size(); ++n) {
    if (!ticks.try_emplace(names[n]).second) {
      throw std::runtime_error("two columns " + names[n]);
    }
  }
  long bin = -1;
  while (std::getline(lines, line)) {
    const std::vector<std::string> words = words_of(line);
    if (words.size() != names.size()) { throw std::runtime_error("a row of other length"); }
    for (std::size_t n = 0; n < words.size(); ++n) {
      long count = 0;
      const char* end = words[n].data() + words[n].size();
      const auto [last, problem] = std::from_chars(words[n].data(), end, count);
      if (problem != std::errc() || last != end || count < 0) {
        throw std::runtime_error("no count: " + words[n]);
      }
      if (n == 0 && count <= bin) { throw std::runtime_error("bins that do not increase"); }
      if (n == 0) { bin = count; }
      if (n > 0 && count > 0) { ticks[names[n]][bin] += count; }
    }
  }
  return ticks;
}

/// Throws std::runtime_error if the numbers of a phase contradict each other.
void check_phase(const Json& phase, double deadline_us, const std::string& which) {
  const auto ticks = whole_from_json<long>(phase.at("ticks"));
  const auto steps = whole_from_json<long>(phase.at("steps"));
  const auto misses = whole_from_json<long>(phase.at("misses"));
  require_consistent(0 <= steps && steps <= ticks && 0 <= misses && misses <= ticks,
                     which + " has " + std::to_string(misses) + " misses and " +
                         std::to_string(steps) + " steps in " + std::to_string(ticks) + " ticks");
  for (const char* key :
       {"restarts", "minor_faults", "major_faults", "voluntary_switches", "involuntary_switches"}) {
    require_consistent(whole_from_json<long>(phase.at(key)) >= 0, which + " has negative " + key);
  }
  for (const char* key : {"seconds", "paused_s", "longest_recovery_us"}) {
    require_consistent(number_from_json(phase.at(key)) >= 0.0, which + " has negative " + key);
  }
  const auto run = whole_from_json<long>(phase.at("longest_miss_run"));
  require_consistent(run <= misses && (run > 0) == (misses > 0),
                     which + " has runs of " + std::to_string(run) + " misses, and " +
                         std::to_string(misses) + " in all");
  const double limit = miss_probability_upper(misses, steps);
  const double given = number_from_json(phase.at("miss_probability_upper_95"));
  constexpr double rounding = 1e-9;
  require_consistent(std::abs(given - limit) <= rounding * limit,
                     which + " has the miss probability " + short_number(given) + " instead of " +
                         short_number(limit));
  if (phase.at("response_us").is_null()) {
    require_consistent(ticks == 0, which + " has no response times");
    return;
  }
  const double slowest = number_from_json(phase.at("response_us").at("max"));
  require_consistent((slowest > deadline_us) == (misses > 0),
                     which + " has " + std::to_string(misses) +
                         " misses, and its slowest tick took " + short_number(slowest) + " us");
  // From when the first missed tick was due; the slowest tick is one of those.
  const double recovery = number_from_json(phase.at("longest_recovery_us"));
  require_consistent(misses > 0 ? recovery >= slowest * (1.0 - rounding) : recovery == 0.0,
                     which + " has a longest recovery of " + short_number(recovery) +
                         " us, and its slowest tick took " + short_number(slowest) + " us");
  for (const char* of : {"wakeup_us", "compute_us", "response_us"}) {
    double least = 0.0;
    for (const char* key : {"min", "p50", "p90", "p99", "p99.9", "p99.99", "max"}) {
      const Json& value = phase.at(of).at(key);
      if (value.is_null()) { continue; }
      const double now = number_from_json(value);
      require_consistent(
          now >= least && now <= slowest * (1.0 + rounding),
          which + " has the time " + std::string(of) + "." + key + " = " + short_number(now));
      least = now;
    }
  }
}

/// Throws std::runtime_error if a column of the histogram is not that of a phase: its ticks, least,
/// percentiles and slowest.
void check_column(const Column& column, const std::string& name, const Json& phase,
                  const char* times) {
  const auto count = whole_from_json<long>(phase.at("ticks"));
  const std::string what = "histogram.csv has other ticks in column " + name;
  long sum = 0;
  for (const auto& [bin, number] : column) { sum += number; }
  require_consistent(sum == count, what);
  if (count == 0) { return; }
  const Json& stated = phase.at(times);
  const double slowest = number_from_json(stated.at("max"));
  constexpr auto end = static_cast<double>(LatencyHistogram::bin_count);  // last: all longer times
  constexpr double rounding = 1e-6;
  const auto in_bin = [](double time, long bin) {
    const auto begin = static_cast<double>(bin);
    return std::abs(std::min(time, end - 0.5) - begin - 0.5) <= 0.5 + rounding;
  };
  require_consistent(in_bin(slowest, column.rbegin()->first), what + ": the slowest");
  require_consistent(in_bin(number_from_json(stated.at("min")), column.begin()->first),
                     what + ": the fastest");
  for (const auto& [key, share] : shown_percentiles) {
    const double rank = std::ceil(share * static_cast<double>(count) - 1e-9);
    double below = 0.0;
    auto at = column.begin();
    while (below += static_cast<double>(at->second), below < rank) { ++at; }
    const Json& value = stated.at(key);
    const bool none = !(rank < static_cast<double>(count));  // no tick lies above it
    require_consistent(value.is_null() == none, what + ": " + key);
    if (none) { continue; }
    const auto bin_end = static_cast<double>(at->first) + 1.0;
    const double limit = bin_end < end ? std::min(bin_end, slowest) : slowest;
    require_consistent(std::abs(number_from_json(value) - limit) <= rounding * limit,
                       what + ": " + key);
  }
}

/// Throws std::runtime_error if the misses of a phase are not the ticks beyond the deadline in the
/// column of its response times.
void check_misses(const Column& column, const std::string& name, const Json& phase,
                  double deadline_us) {
  const auto misses = whole_from_json<long>(phase.at("misses"));
  long late = 0;     // in bins beyond the deadline
  long perhaps = 0;  // and in the bin with the deadline
  for (const auto& [bin, number] : column) {
    if (static_cast<double>(bin) >= deadline_us) { late += number; }
    // The last bin has all longer times.
    const bool is_last = bin + 1 == static_cast<long>(LatencyHistogram::bin_count);
    if (is_last || static_cast<double>(bin) + 1.0 > deadline_us) { perhaps += number; }
  }
  require_consistent(
      late <= misses && misses <= perhaps,
      "histogram.csv has other ticks in column " + name + ": those after the deadline");
}

/// Throws std::runtime_error if the columns of the histogram are not those of the loads: four of
/// the worst load and, if there are several, four of each.
void check_histogram(const std::string& histogram, const Json& loads, const Json& worst,
                     double deadline_us) {
  const std::map<std::string, Column> columns = ticks_in(histogram);
  std::size_t checked = 0;
  const auto check_load = [&](const Json& load, const std::string& suffix) {
    const auto check = [&](const char* of, const char* phase, const char* times) {
      const std::string name = of + suffix;
      const auto found = columns.find(name);
      require_consistent(found != columns.end(), "histogram.csv has no column " + name);
      check_column(found->second, name, load.at(phase), times);
      if (times == std::string_view("response_us")) {
        check_misses(found->second, name, load.at(phase), deadline_us);
      }
      ++checked;
    };
    check("wakeup", "scene", "wakeup_us");
    check("compute", "scene", "compute_us");
    check("response", "scene", "response_us");
    check("control", "control", "response_us");
  };
  check_load(worst, "");
  if (loads.size() > 1) {
    for (const Json& load : loads) { check_load(load, "_" + load.at("load").get<std::string>()); }
  }
  require_consistent(checked == columns.size(), "histogram.csv has columns of other loads");
}

/// Throws std::runtime_error if a tail is extrapolated although a check does not hold, or without
/// checks.
void check_tail(const Json& tail) {
  const auto holds = [](const Json& check) {
    const auto number = [&check](const char* key, double none) {
      return check.at(key).is_null() ? none : number_from_json(check.at(key));
    };
    return Quantity{.value = number("value", std::numeric_limits<double>::quiet_NaN()),
                    .lower = number("lower", -unbounded),
                    .upper = number("upper", unbounded)}
        .holds();
  };
  const Json& checks = tail.at("checks");
  for (const Json& check : checks) {
    require_consistent(holds(check) == check.at("holds").get<bool>(), "a check of its tail");
  }
  require_consistent(
      !tail.at("refused").is_null() || (!checks.empty() && std::ranges::all_of(checks, holds)),
      "its tail was not refused, and a check does not hold or there is none");
}

/// Throws std::runtime_error if the events of a certified scene are not those that it declares: the
/// tool touches the tissue, and the scene is long enough for the way of its drive.
void check_events(const Json& json, const std::map<std::string, std::string>& keys) {
  const auto number = [&keys](const char* key) {
    double value = 0.0;
    if (const auto found = keys.find(key); found != keys.end()) {
      std::from_chars(found->second.data(), found->second.data() + found->second.size(), value);
    }
    return value;
  };
  const double duration = number("simulation.duration");
  const double last = duration + number("simulation.step");  // a tick may end beyond
  constexpr double rounding = 1e-9;
  bool touches = false;
  for (const Json& event : json.at("events")) {
    const double time = number_from_json(event.at("scene_s"));
    require_consistent(
        time >= 0.0 && time <= last,
        "an event at " + short_number(time) + " s in a scene of " + short_number(duration) + " s");
    touches = touches || event.at("event").get<std::string>().starts_with("contact");
  }
  const bool tool = std::ranges::any_of(keys, [](const auto& key) {
    return key.first.starts_with("needle.") || key.first.starts_with("probe.");
  });
  if (!tool) { return; }
  require_consistent(touches, "it is certified without a contact of the tool");
  const auto kind = keys.find("drive.kind");
  const double speed = number("drive.speed");
  if (kind == keys.end() || kind->second.find("trajectory") == std::string::npos ||
      !keys.contains("drive.depth") || !(speed > 0.0)) {
    return;
  }
  const double way = number("drive.depth") - number("drive.from");
  double shortest = way / speed;
  const double back = number("drive.withdraw_speed");
  if (back > 0.0) { shortest += number("drive.hold") + way / back; }
  require_consistent(duration * (1.0 + rounding) >= shortest,
                     "its scene of " + short_number(duration) +
                         " s ends before the way of the drive, " + short_number(shortest) + " s");
}

/// Throws std::runtime_error if the costliest tick is not that of the provocations, these are not
/// sorted, or one that every certificate has is missing.
void check_budget(const Json& json, const Claim& claim) {
  const Json& budget = json.at("compute_budget");
  Certificate all{.claim = claim};
  constexpr double rounding = 1e-9;
  const auto equal = [](double a, double b) { return std::abs(a - b) <= rounding * std::abs(b); };
  std::set<std::string> names;
  for (const Json& probe : budget.at("provocations")) {
    const double spent = number_from_json(probe.at("processor_us"));
    require_consistent(spent >= 0.0 && whole_from_json<long>(probe.at("ticks")) > 0 &&
                           whole_from_json<long>(probe.at("repetitions")) > 0,
                       "a provocation without ticks");
    require_consistent(
        equal(number_from_json(probe.at("share_of_deadline")) * us * claim.deadline, spent),
        "share_of_deadline is not that of processor_us and deadline_us");
    require_consistent(all.budget.probes.empty() ||
                           spent <= us * all.budget.probes.back().processor * (1.0 + rounding),
                       "its provocations are not in the order of processor_us, largest first");
    require_consistent(names.insert(probe.at("name")).second, "a provocation given twice");
    all.budget.probes.push_back({.name = probe.at("name"),
                                 .scene_time = number_from_json(probe.at("scene_s")),
                                 .processor = spent / us});
  }
  const Json& worst = budget.at("worst_us");
  require_consistent(worst.is_null() == names.empty() &&
                         (names.empty() || equal(number_from_json(worst), us * all.budget.worst())),
                     "worst_us is not that of the provocations");
  require_consistent(budget.at("statement") == budget_text(all),
                     "the statement is not that of the provocations");
  const Json& rate = budget.at("cycles_per_second");
  const auto check_cycles = [&](const char* key, double seconds, bool known) {
    require_consistent(
        budget.at(key).is_null() != known &&
            (!known || equal(number_from_json(budget.at(key)), seconds * number_from_json(rate))),
        std::string(key) + " is not that of cycles_per_second");
  };
  check_cycles("worst_cycles", all.budget.worst(), !rate.is_null() && !names.empty());
  check_cycles("deadline_cycles", claim.deadline, !rate.is_null());
  if (names.empty()) { return; }
  std::set<std::string> needed{"first tick", "costliest tick"};
  // A simulator that is not deterministic may diverge in this pass alone.
  const bool own = json.at("subject_sha256").is_null();
  if (own && !json.at("interrupted").get<bool>()) { needed.insert("cold caches"); }
  for (const Json& event : json.at("events")) { needed.insert(event.at("event")); }
  for (const std::string& name : needed) {
    require_consistent(names.contains(name), "it has no provocation \"" + name + "\"");
  }
}

/// Loads that a command line requests; "idle" if none.
std::vector<std::string> loads_of_command(const std::string& command) {
  std::vector<std::string> loads;
  const std::vector<std::string> words = gate::shell_words(command);
  for (std::size_t n = 0; n + 1 < words.size(); ++n) {
    if (words[n] == "--load") { loads.push_back(words[n + 1]); }
  }
  return loads.empty() ? std::vector<std::string>{"idle"} : loads;
}

/// Throws std::runtime_error if the loads are not those of the command, or the worst load is not
/// the one with the largest limit of the miss probability.
void check_loads(const Json& json) {
  const std::vector<std::string> requested = loads_of_command(json.at("command"));
  const Json& loads = json.at("loads");
  require_consistent(json.at("interrupted").get<bool>() || loads.empty()
                         ? loads.size() <= requested.size()
                         : loads.size() == requested.size(),
                     "it has " + std::to_string(loads.size()) + " loads, and its command " +
                         std::to_string(requested.size()));
  for (std::size_t n = 0; n < loads.size(); ++n) {
    const Json& load = loads[n].at("load");
    require_consistent(load == requested[n],
                       "its load " + load.dump() + " is " + requested[n] + " in its command");
  }
  if (loads.empty()) { return; }
  const auto limit = [](const Json& load) {
    return number_from_json(load.at("scene").at("miss_probability_upper_95"));
  };
  const Json& worst = std::ranges::max_element(loads, {}, limit)->at("load");
  require_consistent(worst == json.at("load"), "the worst load is " + json.at("load").dump() +
                                                   ", and " + worst.dump() +
                                                   " has the largest miss probability");
}

/// Throws std::runtime_error if a certificate's verdict does not follow from its numbers, or these
/// from its histogram.
void check_certificate(const Json& json, const std::string& histogram) {
  const double deadline = number_from_json(json.at("deadline_us"));
  const Json& loads = json.at("loads");
  const auto ticks_of = [](const Json& phase) { return whole_from_json<long>(phase.at("ticks")); };
  const auto late = [](const Json& phase) {
    return whole_from_json<long>(phase.at("misses")) > 0 || phase.at("given_up").get<bool>();
  };
  long ticks = 0;
  bool control_late = false;
  bool scene_late = false;
  bool enough = true;
  const auto needed = whole_from_json<long>(json.at("ticks_needed"));
  const Json* worst = nullptr;
  for (const Json& load : loads) {
    const auto name = load.at("load").get<std::string>();
    check_phase(load.at("control"), deadline, "the empty loop under load " + name);
    check_phase(load.at("scene"), deadline, "the scene under load " + name);
    if (load.at("load") == json.at("load")) { worst = &load; }
    control_late = control_late || late(load.at("control"));
    scene_late = scene_late || late(load.at("scene"));
    enough = enough && ticks_of(load.at("scene")) >= needed;
    ticks = std::max(ticks, ticks_of(load.at("scene")));
  }
  require_consistent(loads.empty() || worst != nullptr, "the worst load is none of its loads");
  check_loads(json);
  if (worst != nullptr) {
    for (const auto& [key, value] : worst->at("scene").items()) {
      require_consistent(json.at(key) == value, key + " is not that of the worst load");
    }
    require_consistent(json.at("control") == worst->at("control"),
                       "control is not that of the worst load");
    check_histogram(histogram, loads, *worst, deadline);
  }
  Claim claim{.rate = number_from_json(json.at("rate_hz")),
              .deadline = deadline / us,
              .duration = number_from_json(json.at("duration_s")),
              .max_miss_rate = number_from_json(json.at("max_miss_rate"))};
  const auto keys = io::keys_given(json.at("resolved_scene").get<std::string>(), {});
  const std::string& step = keys.at("simulation.step");
  double seconds = 0.0;
  std::from_chars(step.data(), step.data() + step.size(), seconds);
  claim.ticks_per_step = std::lround(claim.rate * seconds);
  require_consistent(whole_from_json<long>(json.at("nodes")) >= 0 &&
                         whole_from_json<long>(json.at("springs")) >= 0,
                     "negative nodes or springs");
  require_consistent(json.at("schema") == 1 && json.at("confidence") == 0.95 &&
                         json.at("events_absent").is_array(),
                     "its schema, confidence or list of absent events");
  check_tail(json.at("tail"));
  require_consistent(
      claim.max_miss_rate > 0.0 && claim.max_miss_rate < 1.0 && claim.ticks_per_step >= 1,
      "max_miss_rate, rate_hz and the step of the scene");
  require_consistent(
      needed == claim.ticks_needed(),
      "ticks_needed is not that of max_miss_rate, rate_hz and the step of the scene");
  constexpr double rounding = 1e-9;
  require_consistent(deadline <= us * claim.period() * (1.0 + rounding),
                     "deadline_us is over a period");
  for (const Json& load : loads) {
    const Json& scene = load.at("scene");
    require_consistent(
        whole_from_json<long>(scene.at("steps")) == ticks_of(scene) / claim.ticks_per_step,
        "steps are not those of rate_hz and the step of the scene");
    for (const char* phase : {"control", "scene"}) {
      const bool whole = !json.at("interrupted").get<bool>() && !load.at(phase).at("given_up");
      const long found = ticks_of(load.at(phase));
      require_consistent(whole ? found == claim.ticks() : found <= claim.ticks(),
                         "ticks are not those of rate_hz and duration_s");
      // A tick begins when it is due, and after each restart a new row of ticks begins.
      const double took = number_from_json(load.at(phase).at("seconds"));
      const long periods = found - 1 - whole_from_json<long>(load.at(phase).at("restarts"));
      require_consistent(took >= 0.999 * static_cast<double>(periods) * claim.period() &&
                             number_from_json(load.at(phase).at("paused_s")) <= took,
                         std::to_string(found) + " ticks within " + short_number(took) + " s of " +
                             short_number(claim.rate) + " Hz");
    }
  }
  check_budget(json, claim);
  std::string ran = json.at("resolved_scene");
  for (const Json& input : json.at("inputs")) {
    ran += "\n" + input.at("sha256").get<std::string>();
  }
  if (!json.at("subject_sha256").is_null()) {
    ran += "\n" + json.at("subject_sha256").get<std::string>() +
           json.at("subject_options").get<std::string>();
  }
  ran += "\n" + json.at("code_hash").get<std::string>();
  require_consistent(json.at("scene_hash") == io::sha256(ran),
                     "scene_hash is not that of resolved_scene, inputs, simulator and code_hash");
  const Json& environment = json.at("environment");
  const auto granted = [&environment](const char* key, const char* begin) {
    return environment.at(key).get<std::string>().starts_with(begin);
  };
  const std::string command = " " + json.at("command").get<std::string>() + " ";
  require_consistent(
      command.find(" --ordinary ") == command.npos ||
          (!granted("scheduling", "SCHED_FIFO") && !granted("memory", "locked")),
      "its command has --ordinary, but its environment says SCHED_FIFO or locked memory");
  const bool qualified = granted("scheduling", "SCHED_FIFO") && granted("memory", "locked") &&
                         !control_late && ticks > 0;
  const Json& computed = json.at("compute_budget").at("worst_us");
  const bool holds = !scene_late && enough && json.at("events_absent").empty() &&
                     !computed.is_null() && number_from_json(computed) <= deadline;
  const auto verdict = json.at("verdict").get<std::string>();
  // A scene that diverges is not certified in any environment.
  const bool diverges = json.at("reason").get<std::string>().starts_with("The scene diverges");
  const Status status = diverges     ? Status::fail
                        : !qualified ? Status::inconclusive
                        : holds      ? Status::pass
                                     : Status::fail;
  require_consistent(
      verdict == verdict_word(status),
      "it says \"" + verdict + "\", and its numbers \"" + std::string(verdict_word(status)) + "\"");
  if (status != Status::pass) { return; }
  check_events(json, keys);
  const Json& scene = worst->at("scene");
  require_consistent(
      json.at("reason") == certified_text(claim, ticks_of(scene),
                                          number_from_json(scene.at("miss_probability_upper_95")),
                                          loads.size(), json.at("load")),
      "reason is not that of its numbers");
}

}  // namespace

SealedVerdict verified_certificate(const std::string& json, const std::string& histogram,
                                   const std::string& file) {
  constexpr const char* allowed = "a certificate.json as palpate certify wrote it";
  SealedVerdict sealed;
  std::string hash_of_histogram;
  try {
    const Json content = parse_sealed(json);
    sealed = {.verdict = content.at("verdict"), .reason = content.at("reason")};
    hash_of_histogram = content.at("histogram_sha256");
    if (io::sha256(histogram) == hash_of_histogram) { check_certificate(content, histogram); }
  } catch (const std::exception& problem) { throw json_trouble(file, json, problem, allowed); }
  if (io::sha256(histogram) != hash_of_histogram) {
    throw InputError(file +
                     ": histogram.csv beside it is not the one that it seals; the file of "
                     "the same run");
  }
  return sealed;
}

std::string to_html(const CertificateReport& report) {
  const Certificate& all = report.result;
  const Outcome outcome = outcome_of(all);
  std::vector<Table> tables{times_table(report), misses_table(report), probes_table(report)};
  if (const LoadResult* worst = report.result.worst()) {
    tables.push_back(tail_table(worst->tail));
    if (!worst->tail.levels.empty()) { tables.push_back(levels_table(worst->tail)); }
  }
  Page page{.banner = {.title = "Real-time certificate: " +
                                (report.title.empty() ? report.file : report.title),
                       .small_print = {report.command,
                                       all.interrupted ? "interrupted: for what ran" : ""},
                       .status = outcome.status,
                       .verdict = headline(outcome.status),
                       .detail = outcome.reason()},
            .provenance = facts_of_map(report.provenance),
            .command = report.command};
  const auto add = [&page](Section section) { page.parts.emplace_back(std::move(section)); };
  add({.heading = "The claim", .parts = {claim_facts(report), Notes{all.notes}}});
  add(loop_section(report, tables));
  if (!tables[2].rows.empty()) { add({.heading = "Worst ticks", .parts = {tables[2]}}); }
  if (const LoadResult* worst = all.worst()) { add(tail_section(worst->tail, tables)); }
  if (all.missed_tick) {
    add({.heading = "Effect of one missed tick on the hand",
         .parts = {energy_facts(*all.missed_tick)}});
  }
  std::vector<Fact> environment;
  for (const EnvironmentFact& fact : report.environment) {
    environment.push_back({fact.label, value_text(fact), ""});
  }
  add({.heading = "Environment", .parts = {environment}});
  return render(page);
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "validation/bench/paired_cases.hpp"

#include <algorithm>
#include <cmath>

#include "validation/signal.hpp"

namespace palpate::bench {

namespace {

using timing::PairedStart;
using timing::PairedVerdict;

bool counted(const PairedFinding& finding) {
  return !finding.base.passes.empty() && !finding.head.passes.empty();
}

/// NaN where nobody counted.
double instruction_ratio(const PairedFinding& finding) {
  if (!counted(finding)) { return std::nan(""); }
  return static_cast<double>(finding.head.passes.front()) /
         static_cast<double>(finding.base.passes.front());
}

/// Returns true if the counts confirm the times.
bool has_a_cause(const PairedFinding& finding, const PairedVerdict& verdict) {
  return !counted(finding) || instruction_ratio(finding) > 1.0 || verdict.misses_rose();
}

Table starts_table(const PairedFinding& finding) {
  Table table{
      .id = "starts",
      .title = "Starts of the process",
      .caption =
          "Each loads the libraries in the other order. Head over base; what identical libraries "
          "show here is where they lie in memory.",
      .columns = {"start", "pairs", "median ratio", "base, median (us)", "head, median (us)"},
      .timing = true};
  for (std::size_t n = 0; n < finding.starts.size(); ++n) {
    const PairedStart& start = finding.starts[n];
    std::vector<double> base, head;
    for (const timing::Pair& pair : start.pairs) {
      base.push_back(1e6 * pair.base);
      head.push_back(1e6 * pair.head);
    }
    table.rows.push_back({static_cast<double>(n + 1), static_cast<double>(start.pairs.size()),
                          timing::judge_pairs({&start, 1}).ratio, comparison::quantile(base, 0.5),
                          comparison::quantile(head, 0.5)});
  }
  return table;
}

void tell(const PairedFinding& finding, const PairedVerdict& verdict, Outcome& outcome) {
  outcome.report("time_ratio", verdict.ratio);
  outcome.report("time_ratio_lower_99", verdict.lower);
  outcome.report("time_ratio_upper_99", verdict.upper);
  outcome.report("instruction_ratio", instruction_ratio(finding));
  outcome.report("missed_batches_of_base", static_cast<double>(verdict.base_misses));
  outcome.report("missed_batches_of_head", static_cast<double>(verdict.head_misses));
  outcome.tables.push_back(starts_table(finding));
  outcome.notes.emplace_back(finding.same_motion
                                 ? "Both builds move alike to the last bit."
                                 : "The two builds do not move alike to the last bit.");
  if (!counted(finding)) {
    outcome.notes.push_back("Instructions were not counted: " + finding.head.refusal + ".");
  }
}

void compare(const PairedFinding& finding, Outcome& outcome) {
  const PairedVerdict verdict = timing::judge_pairs(finding.starts);
  tell(finding, verdict, outcome);
  if (verdict.slower() && !has_a_cause(finding, verdict)) {
    outcome.notes.emplace_back(
        "The clock says slower, but nothing more is done and no more deadlines are missed: where "
        "code lies in memory, or the machine.");
  }
  outcome.judge_at_most(
      "slowdown_with_a_cause",
      has_a_cause(finding, verdict) ? verdict.lower : std::min(verdict.lower, 1.0),
      timing::allowed_slowdown,
      "wanted: no build is 3 % slower, with 99 % confidence, by a clock that instructions or "
      "missed deadlines bear out");
}

struct Alarms {
  int by_clock = 0;
  int in_all = 0;
  std::vector<double> ratios{};
};

Alarms alarms_of(const std::string& scene, Head head, int comparisons,
                 const PairedMeasurement& measure) {
  Alarms alarms;
  for (int n = 0; n < comparisons; ++n) {
    const PairedFinding finding = measure(scene, head, static_cast<std::uint64_t>(n) + 1);
    const PairedVerdict verdict = timing::judge_pairs(finding.starts);
    alarms.by_clock += verdict.slower() ? 1 : 0;
    alarms.in_all += is_slower(finding) ? 1 : 0;
    alarms.ratios.push_back(verdict.ratio);
  }
  return alarms;
}

void self_test(const std::string& scene, int comparisons, const PairedMeasurement& measure,
               Outcome& outcome) {
  // Fewer comparisons with the planted slowdown: false alarms must be rarer than missed slowdowns.
  const int planted_count = comparisons < 20 ? comparisons : std::max(20, comparisons / 10);
  const Alarms same = alarms_of(scene, Head::as_built, comparisons, measure);
  const Alarms planted = alarms_of(scene, Head::planted, planted_count, measure);
  outcome.judge_equal("alarms_at_the_same_build", static_cast<double>(same.in_all), 0.0,
                      "a build is not slower than itself");
  outcome.judge_equal("missed_slowdowns",
                      static_cast<double>(planted.ratios.size()) - planted.in_all, 0.0,
                      "one tick in twenty more is 5 % slower, which is more than 3 %");
  Table table{.id = "self-test",
              .title = "The comparison, compared",
              .caption = "A build against itself, and against itself with one tick in twenty more.",
              .columns = {"head", "comparisons", "alarms", "alarms of the clock alone",
                          "least ratio", "largest ratio"},
              .timing = true};
  for (const auto& [name, alarms] :
       {std::pair{"the same", &same}, std::pair{"5 % planted", &planted}}) {
    table.rows.push_back(
        {std::string(name), static_cast<double>(alarms->ratios.size()),
         static_cast<double>(alarms->in_all), static_cast<double>(alarms->by_clock),
         *std::ranges::min_element(alarms->ratios), *std::ranges::max_element(alarms->ratios)});
  }
  outcome.tables.push_back(std::move(table));
}

}  // namespace

bool is_slower(const PairedFinding& finding) {
  const PairedVerdict verdict = timing::judge_pairs(finding.starts);
  return verdict.slower() && has_a_cause(finding, verdict);
}

std::vector<Case> paired_cases(const std::vector<std::string>& scenes,
                               const PairedMeasurement& measure) {
  std::vector<Case> cases;
  for (const std::string& scene : scenes) {
    cases.push_back({"bench/paired/" + scene, "timing",
                     "Ticks of " + scene + ".toml are not slower than before.",
                     [=](const CaseContext&, Outcome& outcome) {
                       compare(measure(scene, Head::as_built, 1), outcome);
                     }});
  }
  return cases;
}

std::vector<Case> self_test_cases(const std::vector<std::string>& scenes, int comparisons,
                                  const PairedMeasurement& measure) {
  std::vector<Case> cases;
  for (const std::string& scene : scenes) {
    cases.push_back(
        {"bench/self-test/" + scene, "timing",
         "With " + scene +
             ".toml a build is never called slower than itself, and 5 % are always seen.",
         [=](const CaseContext&, Outcome& outcome) {
           self_test(scene, comparisons, measure, outcome);
         }});
  }
  return cases;
}

}  // namespace palpate::bench

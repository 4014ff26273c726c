// SPDX-License-Identifier: MIT
/// Damage of every kind that a gate exists for, planted one at a time: each must turn its verdict red.

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "validation/bench/paired_cases.hpp"
#include "validation/cases/certificate_parts.hpp"
#include "validation/cases/gate_parts.hpp"
#include "validation/cases/gate_sample.hpp"
#include "validation/gate/gate.hpp"
#include "validation/random.hpp"

namespace palpate::gating {

namespace {

using gate::Baseline;
using gate::Candidate;
using gate::Verdict;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// In the model or its motion.
std::vector<Mutation> model_faults() {
  return {{.name = "a node is not a number", .motion = [](Motion& m) { m.position(17, m.position.cols() - 1) = nan; }},
          {.name = "a node is 1 mm off", .motion = [](Motion& m) { m.position(17, m.position.cols() - 1) += 1e-3; }},
          {.name = "dampers push instead of pull",
           .model =
               [](Scene&, SpringNetwork& network) {
                 network.springs.change_each([&](Spring& s) { s.viscosity = -s.viscosity; });
               }},
          {.name = "the step is used twice", .step_twice = true},
          {.name = "stiffness + 1 %",
           .model =
               [](Scene&, SpringNetwork& network) {
                 network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
               }},
          {.name = "a spring is missing",
           .model = [](Scene&, SpringNetwork& network) {
             network.springs.edit([](std::vector<Spring>& all) { all.erase(all.begin() + 60); });
           }},
          {.name = "frames come one late",
           .motion =
               [](Motion& m) {
                 for (Eigen::Index n = m.position.cols() - 1; n > 0; --n) { m.position.col(n) = m.position.col(n - 1); }
               }},
          {.name = "the force comes one step late",
           .model =
               [](Scene& scene, SpringNetwork&) {
                 for (Load& load : scene.loads) {
                   load.start += scene.simulation.step;
                   load.end += scene.simulation.step;
                 }
               }},
          {.name = "a scheme of lower order",
           .model = [](Scene& scene, SpringNetwork&) { scene.simulation.integrator = "euler-cromer"; }}};
}

/// In what is handed to the gate, or in how it is asked.
struct HandedFault {
  std::string name{};
  std::function<void(Baseline&, Candidate&, std::vector<std::string>&)> plant{};
};

Quantity& quantity_named(Outcome& outcome, const std::string& name) {
  return *std::ranges::find(outcome.quantities, name, &Quantity::name);
}

std::vector<HandedFault> faults_of_numbers() {
  return {{"5 % more work",
           [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "work").value *= 1.05; }},
          {"2 % more work",
           [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "work").value *= 1.02; }},
          {"a number is not one",
           [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "final_energy").value = nan; }},
          {"a number is missing", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].quantities.pop_back(); }},
          {"a number is new",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].quantities.push_back({.name = "new", .value = 1.0}); }},
          {"another unit",
           [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "final_energy").unit = "mJ"; }},
          {"a wider bound",
           [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "largest_error").upper *= 2.0; }}};
}

std::vector<HandedFault> faults_of_curves() {
  return {{"a curve is missing", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].figures.pop_back(); }},
          {"a curve ends early",
           [](Baseline&, Candidate& c, auto&) {
             c.outcomes[0].figures[0].series[0].x.pop_back();
             c.outcomes[0].figures[0].series[0].y.pop_back();
           }},
          {"a curve is of another unit",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].figures[0].y.label = "position along z (mm)"; }}};
}

std::vector<HandedFault> faults_of_cases() {
  return {{"a case is missing", [](Baseline&, Candidate& c, auto&) { c.outcomes.clear(); }},
          {"a case has another name", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].name = "brick"; }},
          {"a case stands twice", [](Baseline&, Candidate& c, auto&) { c.outcomes.push_back(c.outcomes[0]); }},
          {"a case ended in an error", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].status = Status::error; }},
          {"a case is skipped", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].status = Status::skip; }},
          {"a case claims something else", [](Baseline&, Candidate& c, auto&) { c.outcomes[0].claim = "Nothing."; }},
          {"results of another command", [](Baseline&, Candidate& c, auto&) { c.command = "palpate validate other"; }},
          {"an empty baseline", [](Baseline& b, Candidate&, auto&) { b.cases.clear(); }},
          {"nothing on either side",
           [](Baseline& b, Candidate& c, auto&) {
             b.cases.clear();
             c.outcomes.clear();
           }},
          {"a selection that meets nothing",
           [](Baseline&, Candidate&, std::vector<std::string>& only) { only = {"brick"}; }}};
}

/// Six starts of 40 pairs; both builds wait for the rest of the machine, by up to 30 % in every pair.
bench::PairedFinding timed_builds(double slowdown) {
  Random random(1);
  const auto counted = [](double work) {
    return timing::InstructionCount{.passes = {std::lround(work)}};
  };
  bench::PairedFinding finding{.base = counted(1e6), .head = counted(1e6 * slowdown)};
  for (int start = 0; start < 6; ++start) {
    timing::PairedStart pairs{.batch_deadline = 1.0};
    for (int n = 0; n < 40; ++n) {
      const double base = 1e-3 * random(1.0, 1.3);
      pairs.pairs.push_back({.base = base, .head = slowdown * base * random(0.95, 1.05)});
    }
    finding.starts.push_back(std::move(pairs));
  }
  return finding;
}

/// Empty where it was not told from the same library.
std::string refusal_of_slower_library() {
  if (bench::is_slower(timed_builds(1.0)) || !bench::is_slower(timed_builds(1.05))) { return ""; }
  return "slower by pairs and by instructions; the same library is not";
}

/// What happened to one fault, as a row of the report.
class Ledger {
 public:
  void add(const std::string& fault, const Verdict& verdict) {
    const bool red = !verdict.holds();
    caught_ += red ? 1 : 0;
    std::string why = verdict.faults.empty() ? "" : verdict.faults.front();
    if (why.empty() && !verdict.cases.empty() && !verdict.cases.front().changes.empty()) {
      const gate::Change& worst = verdict.cases.front().changes.front();
      why = worst.item + (worst.item.empty() ? "" : " ") + worst.moved;
    }
    table_.rows.push_back({fault, red ? "red" : "GREEN", why});
  }
  void conclude(Outcome& outcome) {
    outcome.judge({.name = "caught",
                   .value = static_cast<double>(caught_),
                   .lower = static_cast<double>(table_.rows.size()),
                   .upper = static_cast<double>(table_.rows.size()),
                   .bound_from = "all that were planted"});
    outcome.tables.push_back(std::move(table_));
  }

 private:
  int caught_ = 0;
  Table table_{.id = "faults",
               .title = "Planted damage",
               .caption = "Each alone, against a baseline that holds without it.",
               .columns = {"planted", "verdict", "because"}};
};

void try_model_faults(const CaseContext& context, const Study& study, const Baseline& baseline, Ledger& ledger) {
  for (const Mutation& fault : model_faults()) {
    CaseContext damaged = context;
    damaged.mutation = &fault;
    ledger.add(fault.name, gate::judge(baseline, {.outcomes = {outcome_of(damaged, study)}}));
  }
  ledger.add("the reference left the force out",
             gate::judge(baseline, {.outcomes = {outcome_of(context, block_study(false))}}));
}

void try_handed_faults(const Baseline& baseline, const Candidate& sound, Ledger& ledger) {
  for (const auto& list : {faults_of_numbers(), faults_of_curves(), faults_of_cases()}) {
    for (const HandedFault& fault : list) {
      Baseline damaged_baseline = baseline;
      Candidate damaged = sound;
      std::vector<std::string> only;
      fault.plant(damaged_baseline, damaged, only);
      ledger.add(fault.name, gate::judge(damaged_baseline, damaged, only));
    }
  }
}

void measure(const CaseContext& context, Outcome& outcome) {
  const Study study = block_study();
  const Baseline baseline = accepted(context, study);
  const Candidate sound{.outcomes = {outcome_of(context, study)}};
  outcome.judge({.name = "holds_without",
                 .value = gate::judge(baseline, sound).holds() ? 1.0 : 0.0,
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "a gate that is always red would catch everything"});
  Ledger ledger;
  try_model_faults(context, study, baseline, ledger);
  try_handed_faults(baseline, sound, ledger);
  std::vector<std::pair<std::string, std::string>> refusals{
      {"a library that is 5 % slower, on a busy machine", refusal_of_slower_library()},
      {"a tail of response times that hang together", certificate::tail_of_pairs(1).refusal}};
  if (context.damaged_files) { std::ranges::copy(context.damaged_files(), std::back_inserter(refusals)); }
  for (const auto& [fault, refusal] : refusals) {
    Verdict verdict{.faults = {refusal}};
    if (refusal.empty()) { verdict = gate::judge(baseline, sound); }
    ledger.add(fault, verdict);
  }
  ledger.conclude(outcome);
}

}  // namespace

Case faults_case() {
  return {.name = "gate/faults",
          .suite = "model",
          .claim = "Damage planted in the model, its results, its baseline or its files turns the gate red.",
          .measure = measure,
          .weight = 1.0,
          .keeps = false};  // files are the program's, not the model's
}

}  // namespace palpate::gating

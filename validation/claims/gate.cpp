// SPDX-License-Identifier: MIT
/// Cases of group "gate": self-test of the harness.

#include "validation/gate/gate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>

#include "reference/solvers.hpp"
#include "validation/bench/paired_cases.hpp"
#include "validation/case.hpp"
#include "validation/claims/certificate.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"
#include "validation/gate/baseline.hpp"
#include "validation/random.hpp"

namespace palpate::gating {

Case self_case();    ///< unchanged code never fails
Case faults_case();  ///< planted faults always fail

// A small block whose results the cases of group "gate" accept once and then damage.

/// Damped block, fixed below, with a half-sine force at one node.
struct Study {
  Scene scene{};
  SpringNetwork network{};
  int probe = 0;  ///< node that is loaded and observed
  Trace truth{};  ///< by CVODE
};
/// Returns the fixture; if `loaded` is false, the truth has no load.
Study block_study(bool loaded = true);

/// Runs the block: error relative to the truth, energies, path of the node, and all nodes at six
/// instants.
Outcome outcome_of(const CaseContext& context, const Study& study);

/// Returns a context with another order of summation in every network.
CaseContext in_order(CaseContext context, std::uint64_t seed);

/// Accepts the outcome with the spread of runs in other orders.
gate::Baseline accepted(const CaseContext& context, const Study& study);

namespace {

constexpr double step = 2e-4;  ///< [s]
constexpr long steps = 600;
constexpr int instants_of_nodes = 6;
constexpr int orders = 8;  ///< number of orders of summation for the spread

Figure path_figure(const Trace& motion, int probe) {
  return {.id = "path",
          .title = "Path of the pushed node",
          .x = {.label = "time (s)"},
          .y = {.label = "position along z (m)"},
          .series = {
              networks::line("node", motion.time, networks::row(motion.position, 3 * probe + 2))}};
}

Figure node_figure(const Trace& motion) {
  Figure figure{.id = "nodes",
                .title = "How far every node has moved",
                .x = {.label = "coordinate (1)"},
                .y = {.label = "displacement (m)"}};
  for (int n = 1; n <= instants_of_nodes; ++n) {
    const Eigen::Index at = (motion.position.cols() - 1) * n / instants_of_nodes;
    const Eigen::VectorXd moved = motion.position.col(at) - motion.position.col(0);
    Series series{.label = "instant " + std::to_string(n), .style = Series::Style::points};
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(moved(i));
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

}  // namespace

Study block_study(bool loaded) {
  const networks::Block block{.relaxation = 2e-4};
  Study study{.network = networks::block_network(block)};
  networks::hold(study.network, Face::z_max);
  study.scene = scene_of("velocity-verlet", step, steps * step);
  study.probe = 5;
  study.scene.loads = {{.nodes = {study.probe},
                        .force = {0.0, 2e-3, 8e-3},
                        .end = 0.04,
                        .profile = Profile::half_sine}};
  Scene known = study.scene;
  if (!loaded) { known.loads.clear(); }
  const NetworkProblem problem = networks::problem_of(known, study.network);
  study.truth = reference::solve_cvode_adams(problem, networks::instants(step, steps), {});
  return study;
}

Outcome outcome_of(const CaseContext& context, const Study& study) {
  const Trace motion =
      roll_out(context, study.scene, &study.network, {.position = true, .energy = true});
  Outcome outcome{
      .name = "block", .suite = "accuracy", .claim = "A pushed block moves as its equations say."};
  const TrajectoryError error = networks::distance(motion, study.truth);
  outcome.judge({.name = "largest_error",
                 .value = error.maximum,
                 .upper = 0.05,
                 .bound_from = "of a sample"});
  outcome.judge({.name = "final_energy", .value = motion.values("energy_j").back(), .unit = "J"});
  outcome.judge({.name = "largest_energy",
                 .value = *std::ranges::max_element(motion.values("energy_j")),
                 .unit = "J"});
  outcome.judge(
      {.name = "work", .value = static_cast<double>(motion.steps), .unit = "evaluations"});
  outcome.figures = {path_figure(motion, study.probe), node_figure(motion)};
  conclude(outcome);
  return outcome;
}

CaseContext in_order(CaseContext context, std::uint64_t seed) {
  context.order = seed;
  return context;
}

gate::Baseline accepted(const CaseContext& context, const Study& study) {
  gate::Acceptance acceptance{.reason = "sample", .outcomes = {outcome_of(context, study)}};
  for (int n = 1; n <= orders; ++n) {
    acceptance.variants.push_back(
        {outcome_of(in_order(context, static_cast<std::uint64_t>(n)), study)});
  }
  return gate::accept({}, acceptance);
}

// False alarms: the same code compared with itself in orders of summation that the baseline does
// not contain.

namespace {

constexpr int comparisons = 200;
constexpr std::uint64_t first_seed = 1000;  ///< different from the seeds of the spread

void measure_self(const CaseContext& context, Outcome& outcome) {
  const Study study = block_study();
  const gate::Baseline baseline = accepted(context, study);
  int alarms = 0;
  int rounded = 0;
  for (int n = 0; n < comparisons; ++n) {
    const CaseContext other = in_order(context, first_seed + static_cast<std::uint64_t>(n));
    const gate::GateResult verdict =
        gate::compare(baseline, {.outcomes = {outcome_of(other, study)}});
    alarms += verdict.holds() ? 0 : 1;
    rounded += verdict.counts().identical == 0 ? 1 : 0;
  }
  const gate::GateResult again =
      gate::compare(baseline, {.outcomes = {outcome_of(context, study)}});
  outcome.judge({.name = "identical_again",
                 .value = static_cast<double>(again.counts().identical),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "the same run gives the same bits"});
  outcome.judge({.name = "alarms",
                 .value = static_cast<double>(alarms),
                 .upper = 0.0,
                 .bound_from = "nothing but the order of sums differs"});
  outcome.judge({.name = "rounded_otherwise",
                 .value = static_cast<double>(rounded),
                 .lower = 0.5 * comparisons,
                 .bound_from = "a comparison of equal bits would show nothing"});
}

}  // namespace

Case self_case() {
  return {.name = "gate/self",
          .suite = "model",
          .claim =
              "A model held against itself 200 times, its sums in another order each time, never "
              "falls.",
          .measure = measure_self,
          .weight = 2.0};
}

// Faults of every kind, planted one at a time: the gate must detect each.

namespace {

using gate::Baseline;
using gate::Candidate;
using gate::GateResult;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Faults in the model or its motion.
std::vector<Mutation> model_faults() {
  return {
      {.name = "a node is not a number",
       .trace = [](Trace& m) { m.position(17, m.position.cols() - 1) = nan; }},
      {.name = "a node is 1 mm off",
       .trace = [](Trace& m) { m.position(17, m.position.cols() - 1) += 1e-3; }},
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
       .model =
           [](Scene&, SpringNetwork& network) {
             network.springs.edit([](std::vector<Spring>& all) { all.erase(all.begin() + 60); });
           }},
      {.name = "frames come one late",
       .trace =
           [](Trace& m) {
             for (Eigen::Index n = m.position.cols() - 1; n > 0; --n) {
               m.position.col(n) = m.position.col(n - 1);
             }
           }},
      {.name = "the force comes one step late",
       .model =
           [](Scene& scene, SpringNetwork&) {
             for (Load& load : scene.loads) {
               load.start += scene.simulation.step;
               load.end += scene.simulation.step;
             }
           }},
      {.name = "a scheme of lower order", .model = [](Scene& scene, SpringNetwork&) {
         scene.simulation.integrator = "euler-cromer";
       }}};
}

/// Faults in the input or the options of the gate.
struct HandedFault {
  std::string name{};
  std::function<void(Baseline&, Candidate&, std::vector<std::string>&)> plant{};
};

Quantity& quantity_named(Outcome& outcome, const std::string& name) {
  return *std::ranges::find(outcome.quantities, name, &Quantity::name);
}

std::vector<HandedFault> faults_of_numbers() {
  return {
      {"5 % more work",
       [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "work").value *= 1.05; }},
      {"2 % more work",
       [](Baseline&, Candidate& c, auto&) { quantity_named(c.outcomes[0], "work").value *= 1.02; }},
      {"a number is not one",
       [](Baseline&, Candidate& c, auto&) {
         quantity_named(c.outcomes[0], "final_energy").value = nan;
       }},
      {"a number is missing",
       [](Baseline&, Candidate& c, auto&) { c.outcomes[0].quantities.pop_back(); }},
      {"a number is new",
       [](Baseline&, Candidate& c, auto&) {
         c.outcomes[0].quantities.push_back({.name = "new", .value = 1.0});
       }},
      {"another unit", [](Baseline&, Candidate& c,
                          auto&) { quantity_named(c.outcomes[0], "final_energy").unit = "mJ"; }},
      {"a wider bound", [](Baseline&, Candidate& c, auto&) {
         quantity_named(c.outcomes[0], "largest_error").upper *= 2.0;
       }}};
}

std::vector<HandedFault> faults_of_curves() {
  return {{"a curve is missing",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].figures.pop_back(); }},
          {"a curve ends early",
           [](Baseline&, Candidate& c, auto&) {
             c.outcomes[0].figures[0].series[0].x.pop_back();
             c.outcomes[0].figures[0].series[0].y.pop_back();
           }},
          {"a curve is of another unit", [](Baseline&, Candidate& c, auto&) {
             c.outcomes[0].figures[0].y.label = "position along z (mm)";
           }}};
}

std::vector<HandedFault> faults_of_cases() {
  return {{"a case is missing", [](Baseline&, Candidate& c, auto&) { c.outcomes.clear(); }},
          {"a case has another name",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].name = "brick"; }},
          {"a case stands twice",
           [](Baseline&, Candidate& c, auto&) { c.outcomes.push_back(c.outcomes[0]); }},
          {"a case ended in an error",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].status = Status::error; }},
          {"a case is skipped",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].status = Status::skip; }},
          {"a case claims something else",
           [](Baseline&, Candidate& c, auto&) { c.outcomes[0].claim = "Nothing."; }},
          {"results of another command",
           [](Baseline&, Candidate& c, auto&) { c.command = "palpate validate other"; }},
          {"an empty baseline", [](Baseline& b, Candidate&, auto&) { b.cases.clear(); }},
          {"nothing on either side",
           [](Baseline& b, Candidate& c, auto&) {
             b.cases.clear();
             c.outcomes.clear();
           }},
          {"a selection that meets nothing",
           [](Baseline&, Candidate&, std::vector<std::string>& only) { only = {"brick"}; }}};
}

/// Returns six starts of 40 pairs; other load delays both builds by up to 30 % in every pair.
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

/// Results of the faults as rows of the report.
class Ledger {
 public:
  void add(const std::string& fault, const GateResult& verdict) {
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

void try_model_faults(const CaseContext& context, const Study& study, const Baseline& baseline,
                      Ledger& ledger) {
  for (const Mutation& fault : model_faults()) {
    CaseContext damaged = context;
    damaged.mutation = &fault;
    ledger.add(fault.name, gate::compare(baseline, {.outcomes = {outcome_of(damaged, study)}}));
  }
  ledger.add("the reference left the force out",
             gate::compare(baseline, {.outcomes = {outcome_of(context, block_study(false))}}));
}

void try_handed_faults(const Baseline& baseline, const Candidate& sound, Ledger& ledger) {
  for (const auto& list : {faults_of_numbers(), faults_of_curves(), faults_of_cases()}) {
    for (const HandedFault& fault : list) {
      Baseline damaged_baseline = baseline;
      Candidate damaged = sound;
      std::vector<std::string> only;
      fault.plant(damaged_baseline, damaged, only);
      ledger.add(fault.name, gate::compare(damaged_baseline, damaged, only));
    }
  }
}

void measure_faults(const CaseContext& context, Outcome& outcome) {
  const Study study = block_study();
  const Baseline baseline = accepted(context, study);
  const Candidate sound{.outcomes = {outcome_of(context, study)}};
  outcome.judge({.name = "holds_without",
                 .value = gate::compare(baseline, sound).holds() ? 1.0 : 0.0,
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "a gate that is always red would catch everything"});
  Ledger ledger;
  try_model_faults(context, study, baseline, ledger);
  try_handed_faults(baseline, sound, ledger);
  std::vector<std::pair<std::string, std::string>> refusals{
      {"a library that is 5 % slower, on a busy machine", refusal_of_slower_library()},
      {"a tail of response times that hang together", certificate::tail_of_pairs(1).refusal}};
  if (context.damaged_files) {
    std::ranges::copy(context.damaged_files(), std::back_inserter(refusals));
  }
  for (const auto& [fault, refusal] : refusals) {
    GateResult verdict{.faults = {refusal}};
    if (refusal.empty()) { verdict = gate::compare(baseline, sound); }
    ledger.add(fault, verdict);
  }
  ledger.conclude(outcome);
}

}  // namespace

Case faults_case() {
  return {
      .name = "gate/faults",
      .suite = "model",
      .claim =
          "Damage planted in the model, its results, its baseline or its files turns the gate red.",
      .measure = measure_faults,
      .weight = 1.0,
      .keeps = false};  // files are the program's, not the model's
}

}  // namespace palpate::gating

namespace palpate {

std::vector<Case> gate_cases() { return {gating::self_case(), gating::faults_case()}; }

}  // namespace palpate

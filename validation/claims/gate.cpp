// SPDX-License-Identifier: MIT
/// Cases of group "gate": self-test of the harness.

#include "validation/gate/gate.hpp"

#include <iterator>

#include "validation/bench/bench_cases.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"
#include "validation/gate/baseline.hpp"

namespace palpate::gating {

// A small block whose results the cases of group "gate" accept once and then damage.

namespace {

/// Damped block, fixed below, with a half-sine force at one node.
struct Study {
  Scene scene{};
  SpringNetwork network{};
  int probe = 0;  ///< node that is loaded and observed
  Trace truth{};  ///< by CVODE
};
constexpr double step = 2e-4;  ///< [s]
constexpr long steps = 600;
constexpr int instants_of_nodes = 6;
constexpr int orders = 8;  ///< number of orders of summation for the spread

Figure node_figure(const Trace& motion) {
  Figure figure =
      plot("nodes", "How far every node has moved", "", {"coordinate (1)"}, {"displacement (m)"});
  for (int n = 1; n <= instants_of_nodes; ++n) {
    const Eigen::Index at = (motion.position.cols() - 1) * n / instants_of_nodes;
    const Eigen::VectorXd moved = motion.position.col(at) - motion.position.col(0);
    Series& series = figure.add("instant " + std::to_string(n), Series::Style::points);
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
      series.add(static_cast<double>(i), moved(i));
    }
  }
  return figure;
}

enum class TruthLoad { applied, left_out };

/// Returns the fixture; the truth has no load if it is left out.
Study block_study(TruthLoad in_truth = TruthLoad::applied) {
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
  if (in_truth == TruthLoad::left_out) { known.loads.clear(); }
  const NetworkProblem problem = networks::problem_of(known, study.network);
  study.truth = reference::solve_cvode_adams(problem, tick_times(step, steps), {});
  return study;
}

/// Runs the block: error, energies, path of the node, and all nodes at six instants.
Outcome outcome_of(const CaseContext& context, const Study& study) {
  const Trace motion =
      roll_out(context, study.scene, &study.network, {.position = true, .energy = true});
  Outcome outcome{
      .name = "block", .suite = "accuracy", .claim = "A pushed block moves as its equations say."};
  const TrajectoryError error = networks::distance(motion, study.truth);
  outcome.judge_at_most("largest_error", error.maximum, 0.05, "of a sample");
  outcome.report("final_energy", motion.values("energy_j").back(), "J");
  outcome.report("largest_energy", *std::ranges::max_element(motion.values("energy_j")), "J");
  outcome.report("work", motion.steps, "evaluations");
  const std::vector<double>& energy = motion.values("energy_j");
  const auto top = std::ranges::max_element(energy) - energy.begin();
  const auto event = [&](const char* name, double time) {
    outcome.judge({.name = name, .value = time, .unit = "s", .uncertainty = 2.0 * step});
  };
  event("event: largest energy", motion.time[static_cast<std::size_t>(top)]);
  event("event: end", motion.time.back());
  outcome.tables.push_back(make_table(std::string(gate::text_table), "Compared texts", "",
                                      {"name", "text"},
                                      {{"scene: simulation.step", "2e-4"}, {"kernel", "springs"}}));
  outcome.figures = {
      {.id = "path",
       .title = "Path of the pushed node",
       .x = {.label = "time (s)"},
       .y = {.label = "position along z (m)"},
       .series = {curve("node", motion.time, networks::row(motion.position, 3 * study.probe + 2))}},
      node_figure(motion)};
  conclude(outcome);
  return outcome;
}

/// Returns a context with another order of summation in every network.
CaseContext in_order(CaseContext context, std::uint64_t seed) {
  context.order = seed;
  return context;
}

/// Accepts the outcome with the spread of runs in other orders.
gate::Baseline accepted(const CaseContext& context, const Study& study) {
  gate::Acceptance acceptance{.reason = "sample", .outcomes = {outcome_of(context, study)}};
  for (int n = 1; n <= orders; ++n) {
    acceptance.variants.push_back(
        {outcome_of(in_order(context, static_cast<std::uint64_t>(n)), study)});
  }
  return gate::accept({}, acceptance);
}

// False alarms: the same code compared with itself in orders of summation new to the baseline.

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
  outcome.judge_equal("identical_again", again.counts().identical, 1.0,
                      "the same run gives the same bits");
  outcome.judge_at_most("alarms", alarms, 0.0, "nothing but the order of sums differs");
  outcome.judge_at_least("rounded_otherwise", rounded, 0.5 * comparisons,
                         "a comparison of equal bits would show nothing");
}

// Faults of every kind, planted one at a time: the gate must detect each.

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

/// Input and options of the gate, which a fault changes.
struct Handed {
  Baseline baseline{};
  Candidate candidate{};
  std::vector<std::string> only{};

  Outcome& outcome() { return candidate.outcomes[0]; }
  Quantity& quantity(const std::string& name) {
    return *std::ranges::find(outcome().quantities, name, &Quantity::name);
  }
};

struct HandedFault {
  std::string name{};
  void (*plant)(Handed&);
};

std::vector<HandedFault> handed_faults() {
  return {
      {"5 % more work", [](Handed& h) { h.quantity("work").value *= 1.05; }},
      {"2 % more work", [](Handed& h) { h.quantity("work").value *= 1.02; }},
      {"an error is exactly zero", [](Handed& h) { h.quantity("largest_error").value = 0.0; }},
      {"an error is rounding alone", [](Handed& h) { h.quantity("largest_error").value = 1e-16; }},
      {"every number is zero",
       [](Handed& h) {
         for (Quantity& each : h.outcome().quantities) { each.value = 0.0; }
         for (Figure& figure : h.outcome().figures) {
           for (Series& series : figure.series) { std::ranges::fill(series.y, 0.0); }
         }
       }},
      {"a case fails that passed",
       [](Handed& h) {
         h.quantity("largest_error").value = 0.06;
         conclude(h.outcome());
       }},
      {"an event three ticks late",
       [](Handed& h) { h.quantity("event: largest energy").value += 3.0 * step; }},
      {"events in another order",
       [](Handed& h) { std::swap(h.quantity("event: largest energy"), h.quantity("event: end")); }},
      {"an event is new",
       [](Handed& h) {
         h.outcome().judge({.name = "event: contact", .unit = "s", .uncertainty = step});
       }},
      {"another kernel", [](Handed& h) { h.outcome().tables[0].rows[1][1] = "lattice"; }},
      {"a warning is new",
       [](Handed& h) {
         h.outcome().tables[0].rows.push_back({"warning: too coarse", ""});
       }},
      {"a key of the scene has another value",
       [](Handed& h) { h.outcome().tables[0].rows[0][1] = "1e-4"; }},
      {"a key of the scene is missing",
       [](Handed& h) { h.outcome().tables[0].rows.erase(h.outcome().tables[0].rows.begin()); }},
      {"a number is not one", [](Handed& h) { h.quantity("final_energy").value = nan; }},
      {"a number is missing", [](Handed& h) { h.outcome().quantities.pop_back(); }},
      {"a number is new", [](Handed& h) { h.outcome().report("new", 1.0); }},
      {"another unit", [](Handed& h) { h.quantity("final_energy").unit = "mJ"; }},
      {"a wider bound", [](Handed& h) { h.quantity("largest_error").upper *= 2.0; }},
      {"a curve is missing", [](Handed& h) { h.outcome().figures.pop_back(); }},
      {"a curve ends early",
       [](Handed& h) {
         h.outcome().figures[0].series[0].x.pop_back();
         h.outcome().figures[0].series[0].y.pop_back();
       }},
      {"a curve is of another unit",
       [](Handed& h) { h.outcome().figures[0].y.label = "position along z (mm)"; }},
      {"a case is missing", [](Handed& h) { h.candidate.outcomes.clear(); }},
      {"a case has another name", [](Handed& h) { h.outcome().name = "brick"; }},
      {"a case stands twice", [](Handed& h) { h.candidate.outcomes.push_back(h.outcome()); }},
      {"a case ended in an error", [](Handed& h) { h.outcome().status = Status::error; }},
      {"a case is skipped", [](Handed& h) { h.outcome().status = Status::skip; }},
      {"a case claims something else", [](Handed& h) { h.outcome().claim = "Nothing."; }},
      {"results of another command",
       [](Handed& h) { h.candidate.command = "palpate validate other"; }},
      {"an empty baseline", [](Handed& h) { h.baseline.cases.clear(); }},
      {"nothing on either side",
       [](Handed& h) {
         h.baseline.cases.clear();
         h.candidate.outcomes.clear();
       }},
      {"a selection that meets nothing", [](Handed& h) { h.only = {"brick"}; }}};
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

/// Empty if it was not distinguished from the same library.
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
    outcome.judge_equal("caught", caught_, table_.rows.size(), "all that were planted");
    outcome.tables.push_back(std::move(table_));
  }

 private:
  int caught_ = 0;
  Table table_ = make_table("faults", "Planted damage",
                            "Each alone, against a baseline that holds without it.",
                            {"planted", "verdict", "because"});
};

void measure_faults(const CaseContext& context, Outcome& outcome) {
  const Study study = block_study();
  const Baseline baseline = accepted(context, study);
  const Candidate sound{.outcomes = {outcome_of(context, study)}};
  outcome.judge_equal("holds_without", gate::compare(baseline, sound).holds() ? 1.0 : 0.0, 1.0,
                      "a gate that is always red would catch everything");
  Ledger ledger;
  for (const Mutation& fault : model_faults()) {
    CaseContext damaged = context;
    damaged.mutation = &fault;
    ledger.add(fault.name, gate::compare(baseline, {.outcomes = {outcome_of(damaged, study)}}));
  }
  ledger.add("the reference left the force out",
             gate::compare(baseline,
                           {.outcomes = {outcome_of(context, block_study(TruthLoad::left_out))}}));
  for (const HandedFault& fault : handed_faults()) {
    Handed handed{.baseline = baseline, .candidate = sound};
    fault.plant(handed);
    ledger.add(fault.name, gate::compare(handed.baseline, handed.candidate, handed.only));
  }
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

std::vector<Case> cases() {
  constexpr bool keeps = false;  // files are the program's, not the model's
  return {
      {"gate/self", "model",
       "A model compared with itself 200 times, its sums in another order, never regresses.",
       measure_self, 2.0},
      {"gate/faults", "model",
       "Damage planted in the model, its results, its baseline or its files turns the gate red.",
       measure_faults, 1.0, true, keeps}};
}

}  // namespace palpate::gating

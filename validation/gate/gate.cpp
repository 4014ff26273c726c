// SPDX-License-Identifier: MIT

#include "validation/gate/gate.hpp"

#include <algorithm>
#include <set>

#include "validation/gate/change.hpp"

namespace palpate::gate {

namespace {

Change broken(std::string item, std::string what) {
  return {.item = std::move(item), .judgement = Judgement::broken, .moved = std::move(what)};
}

CaseVerdict broken_case(const Outcome& outcome, const std::string& what) {
  return {.name = outcome.name, .suite = outcome.suite, .changes = {broken("", what)}};
}

double spread_of(const std::map<std::string, double>& spreads, const std::string& name) {
  const auto found = spreads.find(name);
  return found == spreads.end() ? 0.0 : found->second;
}

/// A case that was judged must be judged, one that passed must pass, and none may end in an error.
std::string status_problem(const Outcome& before, const Outcome& now) {
  const std::string why = now.reason.empty() ? "" : ": " + now.reason;
  const std::string is = "is " + std::string(name_of(now.status)) + why;
  if (now.status == Status::error) { return is; }
  if (now.status == before.status || before.status == Status::skip || now.status == Status::pass) {
    return {};
  }
  return is + ", was " + std::string(name_of(before.status));
}

void judge_quantities(const AcceptedCase& accepted, const Outcome& now,
                      std::vector<Change>& changes) {
  const Outcome& before = accepted.outcome;
  for (const Quantity& quantity : before.quantities) {
    const auto found = std::ranges::find(now.quantities, quantity.name, &Quantity::name);
    changes.push_back(found == now.quantities.end()
                          ? broken(quantity.name, "is missing")
                          : judge_quantity(quantity, *found,
                                           spread_of(accepted.spread.quantities, quantity.name)));
  }
  for (const Quantity& quantity : now.quantities) {
    if (std::ranges::find(before.quantities, quantity.name, &Quantity::name) ==
        before.quantities.end()) {
      changes.push_back(broken(quantity.name, "is not in the baseline"));
    }
  }
}

bool same_axes(const Figure& a, const Figure& b) {
  return a.x.label == b.x.label && a.y.label == b.y.label && a.x.logarithmic == b.x.logarithmic &&
         a.y.logarithmic == b.y.logarithmic;
}

std::string axes_of(const Figure& figure) { return figure.y.label + " over " + figure.x.label; }

void judge_figure(const AcceptedCase& accepted, const Figure& before, const Figure& now,
                  std::vector<Change>& changes) {
  if (!same_axes(before, now)) {
    changes.push_back(broken(before.id, "shows " + axes_of(now) + ", was " + axes_of(before)));
    return;
  }
  if (before.series.size() != now.series.size()) {
    changes.push_back(broken(before.id, std::to_string(now.series.size()) + " curves, was " +
                                            std::to_string(before.series.size())));
    return;
  }
  for (std::size_t n = 0; n < before.series.size(); ++n) {
    changes.push_back(
        judge_curve(before, now, n, spread_of(accepted.spread.curves, curve_name(before, n))));
  }
}

void judge_figures(const AcceptedCase& accepted, const Outcome& now, std::vector<Change>& changes) {
  for (const Figure& figure : accepted.outcome.figures) {
    const auto found = std::ranges::find(now.figures, figure.id, &Figure::id);
    if (found == now.figures.end()) {
      changes.push_back(broken(figure.id, "the figure is missing"));
    } else {
      judge_figure(accepted, figure, *found, changes);
    }
  }
  for (const Figure& figure : now.figures) {
    const auto found = std::ranges::find(accepted.outcome.figures, figure.id, &Figure::id);
    if (found == accepted.outcome.figures.end()) {
      changes.push_back(broken(figure.id, "the figure is not in the baseline"));
    }
  }
}

/// Without what changes no result.
std::string command_of(std::string command) {
  const std::string option = " --no-skip";
  if (const auto at = command.find(option); at != std::string::npos) {
    command.erase(at, option.size());
  }
  return command;
}

std::string command_problem(const Baseline& baseline, const Candidate& candidate) {
  if (command_of(candidate.command) == command_of(baseline.command)) { return {}; }
  return "results of `" + candidate.command + "`, the baseline has those of `" + baseline.command +
         "`";
}

std::vector<std::string> repeated_names(const std::vector<Outcome>& outcomes) {
  std::set<std::string> met;
  std::vector<std::string> repeated;
  for (const Outcome& outcome : outcomes) {
    if (!met.insert(outcome.name).second) { repeated.push_back(outcome.name); }
  }
  return repeated;
}

std::string approve_hint(const std::string& what) { return what + "; palpate approve takes it in"; }

}  // namespace

bool CaseVerdict::better() const {
  return !falls() && std::ranges::any_of(changes, [](const Change& change) {
    return change.judgement == Judgement::better;
  });
}

Tally Verdict::tally() const {
  Tally sum;
  for (const CaseVerdict& one : cases) {
    int& count = one.falls()     ? sum.fallen
                 : one.identical ? sum.identical
                 : one.better()  ? sum.better
                                 : sum.unchanged;
    ++count;
  }
  return sum;
}

CaseVerdict judge_case(const AcceptedCase& accepted, const Outcome& now) {
  CaseVerdict verdict{.name = now.name, .suite = now.suite};
  if (std::string problem = status_problem(accepted.outcome, now); !problem.empty()) {
    verdict.changes.push_back(broken("", std::move(problem)));
  }
  if (now.claim != accepted.outcome.claim) {
    verdict.changes.push_back(
        broken("", "claims \"" + now.claim + "\", was \"" + accepted.outcome.claim + "\""));
  }
  if (accepted.outcome.status == Status::skip) {  // nothing to hold it against
    verdict.identical = now.status == Status::skip;
    return verdict;
  }
  if (now.status == Status::skip) { return verdict; }
  judge_quantities(accepted, now, verdict.changes);
  judge_figures(accepted, now, verdict.changes);
  std::erase_if(verdict.changes,
                [](const Change& change) { return change.judgement == Judgement::same; });
  verdict.identical = verdict.changes.empty();
  std::ranges::stable_sort(verdict.changes, std::ranges::greater{},
                           [](const Change& change) { return static_cast<int>(change.judgement); });
  return verdict;
}

Verdict judge(const Baseline& baseline, const Candidate& candidate,
              const std::vector<std::string>& only) {
  Verdict verdict;
  const auto wanted = [&](const std::string& name) {
    return only.empty() || std::ranges::find(only, name) != only.end();
  };
  if (std::string problem = command_problem(baseline, candidate);
      only.empty() && !problem.empty()) {
    verdict.faults.push_back(std::move(problem));
  }
  std::set<std::string> met;
  for (const std::string& name : repeated_names(candidate.outcomes)) {
    verdict.faults.push_back(name + " stands twice in the results");
  }
  for (const AcceptedCase& accepted : baseline.cases) {
    const std::string& name = accepted.outcome.name;
    if (!wanted(name)) { continue; }
    met.insert(name);
    const auto found = std::ranges::find(candidate.outcomes, name, &Outcome::name);
    verdict.cases.push_back(found == candidate.outcomes.end()
                                ? broken_case(accepted.outcome, "is missing from the results")
                                : judge_case(accepted, comparable(*found)));
  }
  for (const Outcome& outcome : candidate.outcomes) {
    if (!wanted(outcome.name) || !met.insert(outcome.name).second) { continue; }
    verdict.cases.push_back(broken_case(outcome, approve_hint("is not in the baseline")));
  }
  for (const std::string& name : only) {
    if (!met.contains(name)) {
      verdict.faults.push_back(name + " is neither in the results nor in the baseline");
    }
  }
  if (verdict.cases.empty()) { verdict.faults.emplace_back("nothing was compared"); }
  return verdict;
}

}  // namespace palpate::gate

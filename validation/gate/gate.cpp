// SPDX-License-Identifier: MIT

#include "validation/gate/gate.hpp"

#include <algorithm>
#include <set>

#include "validation/gate/change.hpp"

namespace palpate::gate {

namespace {

Change broken(std::string item, std::string what) {
  return {.item = std::move(item), .kind = ChangeKind::broken, .moved = std::move(what)};
}

std::string sentence_of(const Change& change) {
  return std::string(name_of(change.kind)) + ": " + change.item + (change.item.empty() ? "" : " ") +
         change.moved + (change.allowed.empty() ? "" : "; allowed " + change.allowed);
}

/// Sorts the changes, worst first, and concludes from them.
CaseChanges concluded(const Outcome& of, std::vector<Change> changes) {
  CaseChanges result{
      .outcome = {.name = of.name, .suite = of.suite, .claim = "Not worse than what was accepted."},
      .changes = std::move(changes)};
  std::ranges::stable_sort(result.changes, std::ranges::greater{}, &Change::kind);
  std::vector<Reason> parts{{Status::pass}};
  for (const Change& change : result.changes) {
    if (change.fails()) { parts.push_back({Status::fail, sentence_of(change)}); }
  }
  conclude(result.outcome, std::move(parts));
  return result;
}

double spread_of(const std::map<std::string, double>& spreads, const std::string& name) {
  const auto found = spreads.find(name);
  return found == spreads.end() ? 0.0 : found->second;
}

/// Checks the status: a judged case must be judged again, a passed one must pass, and none may end
/// in an error.
std::string status_problem(const Outcome& before, const Outcome& now) {
  const std::string why = now.reasons.empty() ? "" : ": " + now.reason();
  const std::string is = "is " + std::string(name_of(now.status)) + why;
  if (now.status == Status::error) { return is; }
  if (now.status == before.status || before.status == Status::skip || now.status == Status::pass) {
    return {};
  }
  return is + ", was " + std::string(name_of(before.status));
}

/// Compares the elements of two lists that have the same name.
template <class Items, class Name, class Compare>
void compare_by_name(const Items& before, const Items& now, Name name, const char* what,
                     std::vector<Change>& changes, Compare&& compare) {
  for (const auto& one : before) {
    const auto found = std::ranges::find(now, one.*name, name);
    if (found == now.end()) {
      changes.push_back(broken(one.*name, std::string(what) + "is missing"));
    } else {
      compare(one, *found);
    }
  }
  for (const auto& one : now) {
    if (std::ranges::find(before, one.*name, name) == before.end()) {
      changes.push_back(broken(one.*name, std::string(what) + "is not in the baseline"));
    }
  }
}

bool same(const Axis& a, const Axis& b) {
  return a.label == b.label && a.logarithmic == b.logarithmic;
}

std::string axes_of(const Figure& figure) { return figure.y.label + " over " + figure.x.label; }

void compare_figure(const AcceptedCase& accepted, const Figure& before, const Figure& now,
                    std::vector<Change>& changes) {
  if (!same(before.x, now.x) || !same(before.y, now.y)) {
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
        compare_curve(before, now, n, spread_of(accepted.spread.curves, curve_name(before, n))));
  }
}

/// Removes options that do not affect results.
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

}  // namespace

bool CaseChanges::better() const {
  return !fails() && std::ranges::any_of(changes, [](const Change& change) {
    return change.kind == ChangeKind::better;
  });
}

ChangeCounts GateResult::counts() const {
  ChangeCounts sum;
  for (const CaseChanges& one : cases) {
    int& count = one.fails()     ? sum.failed
                 : one.identical ? sum.identical
                 : one.better()  ? sum.better
                                 : sum.unchanged;
    ++count;
  }
  return sum;
}

Outcome GateResult::outcome() const {
  Outcome outcome{
      .name = "gate", .suite = "gate", .claim = "No case is worse than what was accepted."};
  std::vector<Reason> parts;
  for (const std::string& fault : faults) { parts.push_back({Status::error, fault}); }
  for (const CaseChanges& one : cases) {
    parts.push_back({one.outcome.status, one.fails()
                                             ? one.outcome.name + ": " + one.outcome.reasons.front()
                                             : std::string()});
  }
  conclude(outcome, std::move(parts));
  return outcome;
}

std::vector<Outcome> GateResult::outcomes() const {
  std::vector<Outcome> list;
  for (const std::string& fault : faults) {
    list.push_back({.name = "comparison",
                    .suite = "gate",
                    .claim = "Results and baseline belong together.",
                    .status = Status::error,
                    .reasons = {fault}});
  }
  for (const CaseChanges& one : cases) { list.push_back(one.outcome); }
  return list;
}

CaseChanges compare_case(const AcceptedCase& accepted, const Outcome& now) {
  std::vector<Change> changes;
  if (std::string problem = status_problem(accepted.outcome, now); !problem.empty()) {
    changes.push_back(broken("", std::move(problem)));
  }
  if (now.claim != accepted.outcome.claim) {
    changes.push_back(
        broken("", "claims \"" + now.claim + "\", was \"" + accepted.outcome.claim + "\""));
  }
  const bool was_judged = accepted.outcome.status != Status::skip;
  const bool is_judged = now.status != Status::skip;
  if (was_judged && is_judged) {
    compare_by_name(accepted.outcome.quantities, now.quantities, &Quantity::name, "", changes,
                    [&](const Quantity& before, const Quantity& after) {
                      changes.push_back(compare_quantity(
                          before, after, spread_of(accepted.spread.quantities, before.name)));
                    });
    compare_by_name(accepted.outcome.figures, now.figures, &Figure::id, "the figure ", changes,
                    [&](const Figure& before, const Figure& after) {
                      compare_figure(accepted, before, after, changes);
                    });
  }
  std::erase_if(changes, [](const Change& change) { return change.kind == ChangeKind::same; });
  CaseChanges result = concluded(now, std::move(changes));
  result.identical = was_judged ? is_judged && result.changes.empty() : !is_judged;
  return result;
}

GateResult compare(const Baseline& baseline, const Candidate& candidate,
                   const std::vector<std::string>& only) {
  GateResult result;
  const auto wanted = [&](const std::string& name) {
    return only.empty() || std::ranges::find(only, name) != only.end();
  };
  if (std::string problem = command_problem(baseline, candidate);
      only.empty() && !problem.empty()) {
    result.faults.push_back(std::move(problem));
  }
  std::set<std::string> met;
  for (const Outcome& outcome : candidate.outcomes) {
    if (!met.insert(outcome.name).second) {
      result.faults.push_back(outcome.name + " is twice in the results");
    }
  }
  met.clear();
  for (const AcceptedCase& accepted : baseline.cases) {
    const std::string& name = accepted.outcome.name;
    if (!wanted(name)) { continue; }
    met.insert(name);
    const auto found = std::ranges::find(candidate.outcomes, name, &Outcome::name);
    result.cases.push_back(
        found == candidate.outcomes.end()
            ? concluded(accepted.outcome, {broken("", "is missing from the results")})
            : compare_case(accepted, comparable(*found)));
  }
  for (const Outcome& outcome : candidate.outcomes) {
    if (!wanted(outcome.name) || !met.insert(outcome.name).second) { continue; }
    result.cases.push_back(
        concluded(outcome, {broken("", "is not in the baseline; palpate approve takes it in")}));
  }
  for (const std::string& name : only) {
    if (!met.contains(name)) {
      result.faults.push_back(name + " is neither in the results nor in the baseline");
    }
  }
  if (result.cases.empty()) { result.faults.emplace_back("nothing was compared"); }
  return result;
}

}  // namespace palpate::gate

// SPDX-License-Identifier: MIT
#include "validation/gate/approval.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/scene_check.hpp"
#include "validation/gate/gate.hpp"
#include "validation/number_words.hpp"

namespace palpate::gate {

namespace {

void require_sound(const Outcome& outcome) {
  constexpr const char* wanted = "; a case that ran to its end, with finite numbers";
  if (outcome.status == Status::error) { throw InputError(outcome.name + ": " + outcome.reason + wanted); }
  for (const Quantity& quantity : outcome.quantities) {
    if (std::isfinite(quantity.value)) { continue; }
    throw InputError(outcome.name + ": " + quantity.name + " is " + plain_number(quantity.value) + wanted);
  }
}

AcceptedCase* find(Baseline& baseline, const std::string& name) {
  const auto found = std::ranges::find(baseline.cases, name, [](const AcceptedCase& one) { return one.outcome.name; });
  return found == baseline.cases.end() ? nullptr : &*found;
}

/// In place, so that a partial approval moves nothing else.
void take_in(Baseline& baseline, const Outcome& outcome) {
  AcceptedCase* accepted = find(baseline, outcome.name);
  if (accepted == nullptr) { accepted = &baseline.cases.emplace_back(); }
  accepted->outcome = outcome;
}

bool is_wanted(const Acceptance& acceptance, const std::string& name) {
  return acceptance.only.empty() || std::ranges::find(acceptance.only, name) != acceptance.only.end();
}

void drop_absent(Baseline& baseline, const std::vector<Outcome>& outcomes) {
  std::erase_if(baseline.cases, [&](const AcceptedCase& one) {
    return std::ranges::find(outcomes, one.outcome.name, &Outcome::name) == outcomes.end();
  });
}

/// Of the accepted cases alone; the others keep theirs.
void measure_spreads(Baseline& baseline, const Acceptance& acceptance) {
  if (acceptance.variants.empty()) { return; }
  Baseline taken;
  for (const AcceptedCase& one : baseline.cases) {
    if (is_wanted(acceptance, one.outcome.name)) { taken.cases.push_back(one); }
  }
  measure_spread(taken, acceptance.variants);
  for (const AcceptedCase& one : taken.cases) { find(baseline, one.outcome.name)->spread = one.spread; }
}

std::string bound_text(const Quantity& quantity) {
  if (!quantity.judged()) { return "no bound"; }
  return "bound " + plain_number(quantity.lower) + " to " + plain_number(quantity.upper) + " (" +
         quantity.bound_from + ")";
}

void describe_case(const AcceptedCase& before, const AcceptedCase& now, std::vector<std::string>& lines) {
  for (const Change& change : judge_case(before, now.outcome).changes) {
    const auto quantity = std::ranges::find(now.outcome.quantities, change.item, &Quantity::name);
    std::string line = now.outcome.name + ": " + change.item;
    if (quantity != now.outcome.quantities.end() && change.judgement != Judgement::broken) {
      const int digits = digits_apart(change.before, change.now);
      line += " " + plain_number(change.before, digits) + " -> " + plain_number(change.now, digits) + " " +
              change.unit + ", " + bound_text(*quantity);
    }
    lines.push_back(line + (change.moved.empty() ? "" : ", " + change.moved));
  }
}

}  // namespace

Baseline accept(const Baseline& old, const Acceptance& acceptance) {
  Baseline updated = old;
  if (acceptance.only.empty() || old.cases.empty()) {
    updated.command = acceptance.command;
    updated.provenance = acceptance.provenance;
  }
  if (acceptance.only.empty()) { drop_absent(updated, acceptance.outcomes); }
  Approval entry{.date = acceptance.date, .reason = acceptance.reason};
  if (const auto commit = acceptance.provenance.find("commit"); commit != acceptance.provenance.end()) {
    entry.commit = commit->second;
  }
  for (const Outcome& outcome : acceptance.outcomes) {
    if (!is_wanted(acceptance, outcome.name)) { continue; }
    const Outcome taken = comparable(outcome);
    require_sound(taken);
    take_in(updated, taken);
    entry.cases.push_back(outcome.name);
  }
  if (entry.cases.empty()) { throw InputError("nothing to approve; results with at least one case"); }
  measure_spreads(updated, acceptance);
  updated.ledger.push_back(std::move(entry));
  return updated;
}

std::vector<std::string> described_changes(const Baseline& old, const Baseline& updated) {
  std::vector<std::string> lines;
  for (const AcceptedCase& now : updated.cases) {
    const AcceptedCase* before = old.find(now.outcome.name);
    if (before == nullptr) {
      lines.push_back(now.outcome.name + ": new");
    } else {
      describe_case(*before, now, lines);
    }
  }
  for (const AcceptedCase& before : old.cases) {
    if (updated.find(before.outcome.name) == nullptr) { lines.push_back(before.outcome.name + ": dropped"); }
  }
  return lines;
}

}  // namespace palpate::gate

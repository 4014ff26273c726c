// SPDX-License-Identifier: MIT

#include "validation/case.hpp"

#include <algorithm>
#include <chrono>

#include "model/problem/input_error.hpp"
#include "validation/claims/groups.hpp"

namespace palpate {

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const auto group : {oscillator::order_cases,
                           oscillator::stability_limit_cases,
                           oscillator::figure_cases,
                           errata::cases,
                           networks::elasticity_cases,
                           networks::conservation_cases,
                           networks::convergence_cases,
                           networks::kernel_cases,
                           tissue_cases,
                           patient_cases,
                           stability::limit_cases,
                           stability::robustness_cases,
                           tools::reference_cases,
                           tools::balance_cases,
                           tools::passage_cases,
                           tools::probe_cases,
                           haptics::wall_cases,
                           haptics::falcon_cases,
                           clinical::measure_cases,
                           clinical::comparison_cases,
                           clinical::calibration_cases,
                           certificate::cases,
                           gating::cases,
                           subjects::cases}) {
    std::ranges::move(group(), std::back_inserter(cases));
  }
  return cases;
}

void add_scheme_cases(
    std::vector<Case>& cases, const std::string& prefix, const std::string& suite,
    const std::function<std::string(const IntegratorInfo&)>& claim,
    const std::function<void(const IntegratorInfo&, const CaseContext&, Outcome&)>& measure,
    const SchemeWeights& weights) {
  for (const IntegratorInfo* scheme : integrators()) {
    cases.push_back({prefix + std::string(scheme->name), suite, claim(*scheme),
                     [scheme, measure](const CaseContext& context, Outcome& outcome) {
                       measure(*scheme, context, outcome);
                     },
                     scheme->implicit ? weights.implicit_scheme : weights.explicit_scheme});
  }
}

bool is_named(const Case& one, const std::string& pattern) {
  return one.name == pattern || one.name.starts_with(pattern + "/") || one.suite == pattern;
}

std::vector<Case> select_cases(const std::vector<Case>& cases,
                               std::span<const std::string> patterns, bool quick) {
  for (const std::string& pattern : patterns) {
    if (std::ranges::none_of(cases, [&](const Case& one) { return is_named(one, pattern); })) {
      throw InputError("no case is named \"" + pattern + "\"; validate --list shows them all");
    }
  }
  std::vector<Case> selected;
  for (const Case& one : cases) {
    const bool named = std::ranges::any_of(
        patterns, [&](const std::string& pattern) { return is_named(one, pattern); });
    if (patterns.empty() ? one.quick || !quick : named) { selected.push_back(one); }
  }
  if (selected.empty()) { throw InputError("the selection holds no case; at least one"); }
  return selected;
}

Outcome run_case(const Case& definition, const CaseContext& context) {
  Outcome outcome{.name = definition.name, .suite = definition.suite, .claim = definition.claim};
  const auto begin = std::chrono::steady_clock::now();
  const auto end_with_error = [&](const std::exception& problem) {
    outcome.status = Status::error;
    outcome.reasons = {problem.what()};
  };
  const auto misses = [](const Quantity& quantity) {
    return quantity.judged() && quantity.status() != Status::pass;
  };
  try {
    definition.measure(context, outcome);
    conclude(outcome);
  } catch (const Refused& refusal) { end_with_error(refusal); } catch (const CannotDo& lacking) {
    // A number that missed its bound is no reason to skip the case.
    if (std::ranges::any_of(outcome.quantities, misses)) {
      conclude(outcome);
      outcome.notes.push_back(std::string("Ended early: ") + lacking.what());
    } else {
      outcome.quantities.clear();  // of what it could do
      outcome.figures.clear();
      outcome.skip(lacking.what());
    }
  } catch (const std::exception& problem) { end_with_error(problem); }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "validation/comparison/credibility.hpp"

#include <algorithm>
#include <array>

namespace palpate::comparison {

namespace {

using Shown = CredibilityFactor::Shown;

/// Factor of verification that is shown by the cases, or groups of cases, with these names.
CredibilityFactor from(std::span<const Outcome> outcomes, const char* name, const char* goal,
                       const std::vector<std::string>& cases) {
  CredibilityFactor factor{.activity = "verification", .factor = name, .goal = goal};
  std::size_t passed = 0;
  for (const Outcome& outcome : outcomes) {
    const bool counts = std::ranges::any_of(cases, [&](const std::string& one) {
      return outcome.name == one || outcome.name.starts_with(one + "/");
    });
    if (!counts || outcome.status == Status::skip) { continue; }
    factor.links.push_back(outcome.name);
    passed += outcome.status == Status::pass ? 1 : 0;
  }
  factor.evidence = factor.links.empty() ? "not shown: none of its cases was run"
                                         : std::to_string(passed) + " of " +
                                               std::to_string(factor.links.size()) + " cases hold";
  if (passed > 0) { factor.shown = passed == factor.links.size() ? Shown::shown : Shown::in_part; }
  return factor;
}

/// Factor that the program cannot show.
CredibilityFactor never(const char* activity, const char* factor, const char* goal,
                        const char* why) {
  return {.activity = activity,
          .factor = factor,
          .goal = goal,
          .evidence = std::string("not shown: ") + why};
}

struct Evidence {
  std::size_t measured = 0;       ///< recordings of patients that could be compared
  std::size_t reconstructed = 0;  ///< rebuilt ones
  std::vector<std::string> names{};
  std::vector<std::string> codes{};  ///< of their subjects, by group
  Status worst = Status::skip;       ///< on the measured ones alone
};

/// A group that has only measured recordings is judged as a group. In a mixed group, reconstructed
/// recordings are ignored and each measured one is judged separately.
Status measured_status(const Comparison& one, const GroupComparison& comparison) {
  for (const GroupSummary& group : comparison.groups) {
    if (group.group == one.group && group.measured == group.recordings) {
      return group.outcome.status;
    }
  }
  return one.outcome.status;
}

Evidence evidence_of(const GroupComparison* comparison) {
  Evidence evidence;
  if (comparison == nullptr) { return evidence; }
  for (const Comparison& one : comparison->recordings) {
    if (one.outcome.status == Status::error) { continue; }
    if (one.kind == Recording::Kind::reconstructed) {
      ++evidence.reconstructed;
    } else {
      ++evidence.measured;
      evidence.names.push_back(one.recording);
      evidence.codes.push_back(one.subject.empty() ? "" : one.group + "/" + one.subject);
      evidence.worst = worse(evidence.worst, measured_status(one, *comparison));
    }
  }
  return evidence;
}

CredibilityFactor test_samples(const Evidence& evidence) {
  CredibilityFactor factor{.activity = "validation",
                           .factor = "test samples",
                           .goal = "recordings of at least 3 subjects"};
  const std::size_t subjects = subject_count(subject_indices(evidence.codes));
  factor.evidence = "measured recordings: " + std::to_string(evidence.measured) +
                    ", of subjects: " + std::to_string(subjects);
  if (evidence.measured == 0) { factor.evidence = "not shown: no measured recording was compared"; }
  if (evidence.reconstructed > 0) {
    factor.evidence += "; " + std::to_string(evidence.reconstructed) +
                       " rebuilt from published values do not count";
  }
  factor.links = evidence.names;
  if (evidence.measured > 0) { factor.shown = subjects >= 3 ? Shown::shown : Shown::in_part; }
  return factor;
}

/// Returns the factor for agreement with patients. "Shown" refers to the comparison; its verdict is
/// part of the evidence.
CredibilityFactor output_comparison(const Evidence& evidence) {
  CredibilityFactor factor{
      .activity = "validation",
      .factor = "output comparison",
      .goal = "features and corridor agree within stated tolerances and u_val"};
  if (evidence.measured == 0) {
    factor.evidence = "not shown: no measured recording was compared";
    return factor;
  }
  factor.evidence =
      "the verdict on what was measured is: " + std::string(verdict_word(evidence.worst));
  factor.links = evidence.names;
  factor.shown = evidence.worst == Status::pass ? Shown::shown : Shown::not_shown;
  if (evidence.worst == Status::inconclusive) { factor.shown = Shown::in_part; }
  return factor;
}

}  // namespace

std::string_view name_of(CredibilityFactor::Shown shown) {
  constexpr std::array<std::string_view, 3> names{"not shown", "in part", "shown"};
  return names[static_cast<std::size_t>(shown)];
}

std::vector<CredibilityFactor> credibility(std::span<const Outcome> outcomes,
                                           const GroupComparison* comparison) {
  const Evidence evidence = evidence_of(comparison);
  return {
      never("verification", "software quality assurance",
            "tests and their planted faults pass on every change",
            "this table sees results and not the test runs; see the project's own tests"),
      from(outcomes, "numerical code verification", "observed orders and closed forms hold",
           {"oscillator", "network", "errata"}),
      from(outcomes, "discretisation error",
           "errors fall with step and spacing at the order of theory",
           {"oscillator/order", "network/order", "needle/order"}),
      from(outcomes, "solver error",
           "two independent families of references agree with the stepping",
           {"network/reference", "needle", "stability"}),
      from(outcomes, "output comparison: the measures themselves",
           "each measure does what it says and is blind as stated", {"clinical"}),
      from(outcomes, "rendering through the device", "forces reach the hand as computed",
           {"haptics"}),
      never("verification", "use error", "inputs are checked by a second person",
            "scenes are checked for rules and not for intent"),
      never("validation", "model form", "alternative laws of tissue lead to the same verdict",
            "one law of tissue is compared at a time"),
      never("validation", "model inputs", "uncertain stiffness and cutting forces are propagated",
            "u_input is what the user states, 0 by default"),
      test_samples(evidence),
      never("validation", "test conditions",
            "needle, syringe, speed and technique are those of the trial",
            "recordings do not state them all"),
      never("validation", "equivalency of inputs", "the simulation is given what was measured",
            "anatomy and hand of the recorded subject are not known"),
      output_comparison(evidence),
      never("applicability", "relevance of the quantities",
            "what is compared is what a trainee feels", "no trial with trainees is part of this"),
      never("applicability", "relevance of the validation",
            "the patients compared are those trained for", "nobody has stated the context of use")};
}

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT

#include "validation/comparison/group_comparison.hpp"

#include <algorithm>
#include <array>
#include <ranges>

#include "validation/number_text.hpp"

namespace palpate::comparison {

namespace {

using Members = std::vector<const Comparison*>;

/// Recordings of a group that could be compared.
Members comparable(const std::vector<Comparison>& all, const std::string& group) {
  Members members;
  for (const Comparison& one : all) {
    if (one.group == group && one.outcome.status != Status::error) { members.push_back(&one); }
  }
  return members;
}

/// Returns the subject of each recording; every recording of a phantom is one of its own.
std::vector<std::size_t> subjects_of(const Members& members) {
  std::vector<std::string> codes;
  for (const Comparison* one : members) {
    codes.push_back(one->kind == Recording::Kind::measured_phantom ? "" : one->subject);
  }
  return subject_indices(codes);
}

/// Returns the union of the time ranges on the clock of the simulation, with the coarsest step.
Grid shared_grid(const Members& members) {
  double begin = unbounded;
  double end = -unbounded;
  double step = 0.0;
  for (const Comparison* one : members) {
    begin = std::min(begin, one->recorded.start);
    end = std::max(end, one->recorded.end());
    step = std::max(step, one->recorded.step);
  }
  return grid_between(begin, end, begin, step);
}

/// Returns the simulated trace where any recording was compared with it.
Samples simulated_on(const Members& members, const Grid& grid) {
  Samples whole{grid.start, grid.step, std::vector<double>(grid.count, not_measured)};
  for (const Comparison* one : members) {
    const Samples part = resample(one->simulated, grid);
    for (std::size_t n = 0; n < grid.count; ++n) {
      if (std::isnan(whole.value[n])) { whole.value[n] = part.value[n]; }
    }
  }
  return whole;
}

void lay_corridor(const Members& members, const CorridorRule& rule, GroupSummary& summary) {
  std::vector<Samples> aligned;
  if (!members.empty()) {
    const Grid grid = shared_grid(members);
    for (const Comparison* one : members) { aligned.push_back(resample(one->recorded, grid)); }
  }
  std::vector<Samples> advances;
  for (const Comparison* one : members) { advances.push_back(one->recorded_advance); }
  const auto longest = std::ranges::max_element(advances, {}, &Samples::size);
  if (longest != advances.end() && longest->size() > 0) {
    const std::size_t count = longest->size();
    for (Samples& one : advances) { one.value.resize(count, not_measured); }
    summary.advance_corridor = build_corridor(advances, rule, subjects_of(members)).corridor;
  }
  CorridorBuilt built = build_corridor(aligned, rule, subjects_of(members));
  summary.corridor_refusal = built.refusal;
  if (!built.corridor) { return; }
  summary.simulated = simulated_on(members, built.corridor->mean.grid());
  summary.coverage = coverage(*built.corridor, summary.simulated, rule);
  summary.corridor = std::move(built.corridor);
}

FeatureSummary summarise(Feature feature, const Members& members,
                         const BootstrapOptions& bootstrap) {
  FeatureSummary summary{.feature = feature, .unit = unit_of(feature, members.front()->unit)};
  std::vector<double> recorded;
  std::vector<double> simulated;
  for (const Comparison* one : members) {
    const FeatureComparison& found = one->of(feature);
    recorded.push_back(found.recorded.value.value_or(not_measured));
    if (found.simulated.value) { simulated.push_back(*found.simulated.value); }
  }
  const OverSubjects over = over_subjects(recorded, subjects_of(members));
  summary.count = over.means.size();
  summary.mean = over.mean;
  summary.deviation = over.deviation;
  summary.interval = bootstrap_mean(over.means, bootstrap);
  if (!simulated.empty()) { summary.simulated = mean_of(simulated); }
  return summary;
}

bool has_numbers(const FeatureComparison& one) { return one.recorded.value && one.simulated.value; }

/// Returns the comparison of the first recording with the most informative status: judged
/// numerically, else judged. compare_mean() replaces the members that depend on the recording.
FeatureComparison most_telling(Feature feature, const Members& members) {
  const auto rank = [&](const Comparison* one) {
    const FeatureComparison& found = one->of(feature);
    return (found.status != Status::skip ? 2 : 0) + (has_numbers(found) ? 1 : 0);
  };
  return (*std::ranges::max_element(members, {}, rank))->of(feature);  // the first of equal ones
}

/// Returns u_D of a mean. Zero and gain of a transducer are common to all recordings and do not
/// average out; individual errors are part of the spread between subjects.
double mean_data_uncertainty(Feature feature, const Members& members) {
  std::vector<double> all;
  for (const Comparison* one : members) {
    const FeatureComparison& found = one->of(feature);
    if (has_numbers(found)) { all.push_back(found.uncertainty.data); }
  }
  return mean_of(all);
}

/// Compares the simulated feature with the mean over subjects; its spread is part of u_D.
FeatureComparison compare_mean(const FeatureSummary& summary, const Members& members,
                               double coverage_factor) {
  FeatureComparison one = most_telling(summary.feature, members);
  if (summary.count > 0) { one.recorded.value = summary.mean; }
  if (summary.simulated) { one.simulated.value = summary.simulated; }
  if (one.recorded.value && summary.simulated) {
    one.error = *summary.simulated - *one.recorded.value;
  }
  const bool undecided = one.status == Status::skip || !one.reason.empty();  // an event left open
  if (undecided) { return one; }
  if (summary.count < 2) {
    one.status = Status::skip;
    one.reason = "recorded of one subject only";
    return one;
  }
  one.uncertainty.data =
      std::hypot(mean_data_uncertainty(summary.feature, members),
                 summary.deviation / std::sqrt(static_cast<double>(summary.count)));
  judge_difference(one, summary.mean, *summary.simulated, coverage_factor);
  return one;
}

Reason reason_of_corridor(const GroupSummary& summary, double least_inside) {
  if (summary.coverage.holds) { return {Status::pass}; }
  return {Status::fail,
          formatted("%.0f %% of samples lie in the corridor of %zu %s; %.0f %% needed",
                    100.0 * summary.coverage.inside, summary.corridor->subjects,
                    summary.of_phantom() ? "recordings" : "subjects", 100.0 * least_inside)};
}

void judge_by_corridor(const Members& members, const GroupOptions& options, GroupSummary& summary) {
  summary.outcome.judge_at_least("share of samples in the corridor", summary.coverage.inside,
                                 options.corridor.least_inside,
                                 "0.95 is expected at each instant; assumed margin");
  std::vector<Reason> parts{reason_of_corridor(summary, options.corridor.least_inside)};
  for (const FeatureSummary& feature : summary.features) {
    const FeatureComparison& mean = summary.means.emplace_back(
        compare_mean(feature, members, options.comparison.uncertainties.coverage_factor));
    if (mean.status != Status::skip && mean.quantity.judged()) {
      summary.outcome.judge(mean.quantity);
    }
    Reason part = reason_of(mean);
    if (!part.text.empty()) {
      part.text = std::string("mean over ") + (summary.of_phantom() ? "recordings" : "subjects") +
                  ", " + part.text;
    }
    parts.push_back(std::move(part));
  }
  const bool features_agree =
      std::ranges::any_of(parts | std::views::drop(1),
                          [](const Reason& one) { return one.status == Status::pass; }) &&
      std::ranges::all_of(parts | std::views::drop(1), [](const Reason& one) {
        return one.status == Status::pass || one.status == Status::skip;
      });
  summary.only_curve_differs = features_agree && !summary.coverage.holds;
  if (summary.only_curve_differs) {
    parts.front().text = std::string(only_curve_text) + ": " + parts.front().text;
  }
  conclude(summary.outcome, std::move(parts));
}

/// Adds the status and all reasons of an outcome, each with a label.
void add_reasons(const Outcome& outcome, Status status, const std::string& label,
                 std::vector<Reason>& parts) {
  parts.push_back({status});
  for (const std::string& reason : outcome.reasons) { parts.push_back({status, label + reason}); }
}

void judge_one_by_one(const Members& members, GroupSummary& summary) {
  std::vector<Reason> parts;
  for (const Comparison* one : members) {
    add_reasons(one->outcome, one->outcome.status,
                summary.recordings > 1 ? one->recording + ": " : "", parts);
  }
  conclude(summary.outcome, std::move(parts));
  summary.only_curve_differs =
      summary.outcome.status == Status::fail &&
      std::ranges::all_of(members, [](const Comparison* one) {
        return one->outcome.status != Status::fail || one->only_curve_differs;
      });
}

/// A subject agrees if all its recordings agree, because they are not independent.
void count_subjects(const Members& members, GroupSummary& summary) {
  const std::vector<std::size_t> subject = subjects_of(members);
  summary.subjects = subject_count(subject);
  std::vector<bool> agrees(summary.subjects, true);
  for (std::size_t n = 0; n < members.size(); ++n) {
    if (members[n]->outcome.status != Status::pass) { agrees[subject[n]] = false; }
  }
  summary.subjects_agree = static_cast<std::size_t>(std::ranges::count(agrees, true));
  summary.agree_share =
      static_cast<double>(summary.subjects_agree) / static_cast<double>(summary.subjects);
  summary.agree_interval = share_interval(summary.subjects_agree, summary.subjects);
}

GroupSummary summarise_group(const std::vector<Comparison>& all, const std::string& group,
                             const GroupOptions& options) {
  GroupSummary summary{.group = group};
  summary.outcome.name = group;
  for (const Comparison& one : all) {
    if (one.group != group) { continue; }
    ++summary.recordings;
    summary.measured += one.kind == Recording::Kind::measured ? 1 : 0;
    summary.phantoms += one.kind == Recording::Kind::measured_phantom ? 1 : 0;
    summary.tally.add(one.outcome.status);
  }
  const Members members = comparable(all, group);
  lay_corridor(members, options.corridor, summary);
  if (members.empty()) {
    for (const Comparison& one : all) {
      if (one.group != group) { continue; }
      summary.outcome.reasons.push_back((summary.recordings > 1 ? one.recording + ": " : "") +
                                        one.outcome.reasons.front());
    }
    return summary;
  }
  count_subjects(members, summary);
  for (const Feature feature : features_of(options.comparison.quantity)) {
    summary.features.push_back(summarise(feature, members, options.bootstrap));
  }
  if (summary.corridor) {
    judge_by_corridor(members, options, summary);
  } else {
    judge_one_by_one(members, summary);
  }
  return summary;
}

/// Returns the label before the reasons of a group; recordings of the unnamed group are named
/// individually.
std::string label_of(const GroupSummary& group, const std::vector<Comparison>& all) {
  if (!group.group.empty()) { return group.group + ": "; }
  return group.recordings > 1 ? ""
                              : std::ranges::find(all, "", &Comparison::group)->recording + ": ";
}

/// Returns the tolerance of a feature from the spread of the recordings of a group; absent if fewer
/// than three have it, or if it is an event.
std::optional<Tolerance> tolerance_of_repeats(Feature feature, const Members& members,
                                              double coverage_factor) {
  constexpr std::size_t least_recordings = 3;
  std::vector<double> values;
  std::vector<double> uncertainties;
  for (const Comparison* one : members) {
    const Measured& recorded = one->recorded_features[feature];
    if (!recorded.value) { continue; }
    values.push_back(*recorded.value);
    uncertainties.push_back(recorded.uncertainty);
  }
  if (is_event(feature) || values.size() < least_recordings) { return std::nullopt; }
  const double spread = 2.0 * deviation_of(values);
  // Twice the expanded uncertainty: a narrower tolerance could never be shown to hold.
  const double floor = 2.0 * coverage_factor * mean_of(uncertainties);
  const std::string of = formatted("%zu recordings of the group", values.size());
  if (spread < floor) {
    return Tolerance{
        .feature = feature,
        .absolute = floor,
        .origin = "twice the expanded uncertainty of the measurement, above the spread of " + of};
  }
  return Tolerance{
      .feature = feature, .absolute = spread, .origin = "two standard deviations over " + of};
}

/// Judges the recordings of a group of insertions again, with tolerances from their spread.
void judge_by_repeats(const std::string& group, const ComparisonOptions& options,
                      std::vector<Comparison>& all) {
  const Members members = comparable(all, group);
  ComparisonOptions with_repeats = options;
  for (const Feature feature : features_of(options.quantity)) {
    const bool given = std::ranges::count(options.tolerances, feature, &Tolerance::feature) > 0;
    const auto found =
        tolerance_of_repeats(feature, members, options.uncertainties.coverage_factor);
    if (!given && found) { with_repeats.tolerances.push_back(*found); }
  }
  for (Comparison& one : all) {
    if (one.group == group && one.outcome.status != Status::error) {
      judge_again(one, with_repeats);
    }
  }
}

}  // namespace

GroupComparison compare_all(std::span<const Recording> recordings, const Trace& simulated,
                            const GroupOptions& options) {
  GroupComparison result;
  for (const Recording& one : recordings) {
    result.recordings.push_back(compare(one, simulated, options.comparison));
  }
  for (const Comparison& one : result.recordings) {
    const auto known = [&](const GroupSummary& summary) { return summary.group == one.group; };
    if (std::ranges::any_of(result.groups, known)) { continue; }
    if (options.comparison.quantity == QuantityKind::insertion) {
      judge_by_repeats(one.group, options.comparison, result.recordings);
    }
    result.groups.push_back(summarise_group(result.recordings, one.group, options));
  }
  std::vector<Reason> parts;
  for (const GroupSummary& group : result.groups) {
    // A group that cannot be compared does not decide about the others.
    const bool compared = group.outcome.status != Status::error;
    add_reasons(group.outcome, compared ? group.outcome.status : Status::skip,
                result.groups.size() > 1 ? label_of(group, result.recordings) : "", parts);
  }
  conclude(result.outcome, std::move(parts));
  if (result.outcome.status == Status::skip) { result.outcome.status = Status::error; }
  if (recordings.empty()) { result.outcome.reasons.emplace_back("there is no recording"); }
  return result;
}

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
  std::size_t measured = 0;       ///< recordings that could be compared, apart from the following
  std::size_t phantoms = 0;       ///< recordings of phantoms
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
    } else if (one.kind == Recording::Kind::measured_phantom) {
      ++evidence.phantoms;
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
  if (evidence.phantoms > 0) {
    factor.evidence +=
        "; " + std::to_string(evidence.phantoms) + " of a measured phantom are no subjects";
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

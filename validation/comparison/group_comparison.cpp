// SPDX-License-Identifier: MIT

#include "validation/comparison/group_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "validation/comparison/comparison.hpp"

namespace palpate::comparison {

namespace {

using Members = std::vector<const Comparison*>;

/// What could be compared of a group.
Members comparable(const std::vector<Comparison>& all, const std::string& group) {
  Members members;
  for (const Comparison& one : all) {
    if (one.group == group && one.verdict != Verdict::not_comparable) { members.push_back(&one); }
  }
  return members;
}

/// Whose each of them is.
std::vector<std::size_t> subjects_of(const Members& members) {
  std::vector<std::string> codes;
  for (const Comparison* one : members) { codes.push_back(one->subject); }
  return subject_indices(codes);
}

/// All that any of them covers on the simulation's clock, with the coarsest of their steps.
Grid shared_grid(const Members& members) {
  double begin = std::numeric_limits<double>::infinity();
  double end = -begin;
  double step = 0.0;
  for (const Comparison* one : members) {
    begin = std::min(begin, one->recorded.start);
    end = std::max(end, one->recorded.end());
    step = std::max(step, one->recorded.step);
  }
  return grid_between(begin, end, begin, step);
}

/// The simulated trace where any of them was compared with it.
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
    const FeatureVerdict& verdict = one->features[static_cast<std::size_t>(feature)];
    recorded.push_back(verdict.recorded.value.value_or(not_measured));
    if (verdict.simulated.value) { simulated.push_back(*verdict.simulated.value); }
  }
  const OverSubjects over = over_subjects(recorded, subjects_of(members));
  summary.count = over.means.size();
  summary.mean = over.mean;
  summary.deviation = over.deviation;
  summary.interval = bootstrap_mean(over.means, bootstrap);
  if (!simulated.empty()) { summary.simulated = mean_of(simulated); }
  return summary;
}

bool has_numbers(const FeatureVerdict& one) { return one.recorded.value && one.simulated.value; }

/// The verdict of the first recording that tells most of the feature: judged by numbers, else
/// judged. Which recording comes first must not matter for the rest: judge_mean() replaces what is
/// its own.
FeatureVerdict most_telling(Feature feature, const Members& members) {
  const auto n = static_cast<std::size_t>(feature);
  const auto rank = [&](const Comparison* one) {
    const bool judged = one->features[n].verdict != Verdict::not_judged;
    return (judged ? 2 : 0) + (has_numbers(one->features[n]) ? 1 : 0);
  };
  return (*std::ranges::max_element(members, {}, rank))->features[n];  // the first of equal ones
}

/// u_D of a mean: zero and gain of a transducer are the same in all, so that they do not average
/// out; what is each recording's own is part of the spread between subjects.
double mean_data_uncertainty(Feature feature, const Members& members) {
  std::vector<double> all;
  for (const Comparison* one : members) {
    const FeatureVerdict& verdict = one->features[static_cast<std::size_t>(feature)];
    if (has_numbers(verdict)) { all.push_back(verdict.uncertainty.data); }
  }
  return mean_of(all);
}

/// The feature of the simulation against the mean over subjects; its spread is part of u_D.
FeatureVerdict judge_mean(const FeatureSummary& summary, const Members& members,
                          double coverage_factor) {
  FeatureVerdict one = most_telling(summary.feature, members);
  if (summary.count > 0) { one.recorded.value = summary.mean; }
  if (summary.simulated) { one.simulated.value = summary.simulated; }
  if (one.recorded.value && summary.simulated) {
    one.error = *summary.simulated - *one.recorded.value;
  }
  if (one.verdict == Verdict::not_judged || !one.reason.empty()) {
    return one;
  }  // an event left open
  if (summary.count < 2) {
    one.verdict = Verdict::not_judged;
    one.reason = "recorded of one subject only";
    return one;
  }
  one.lower = one.tolerance.lower(summary.mean);
  one.upper = one.tolerance.upper(summary.mean);
  one.uncertainty.data =
      std::hypot(mean_data_uncertainty(summary.feature, members),
                 summary.deviation / std::sqrt(static_cast<double>(summary.count)));
  one.expanded = coverage_factor * one.uncertainty.total();
  one.below_uncertainty = std::abs(one.error) < one.uncertainty.total();
  one.verdict = judge(*summary.simulated, one.lower, one.upper, one.expanded);
  return one;
}

void judge_by_corridor(const Members& members, const GroupOptions& options, GroupSummary& summary) {
  summary.verdict = summary.coverage.holds ? Verdict::agrees : Verdict::differs;
  std::vector<Reason> reasons;
  if (!summary.coverage.holds) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.0f %% of samples lie in the corridor of %zu subjects; %.0f %% needed",
                  100.0 * summary.coverage.inside, summary.corridor->subjects,
                  100.0 * options.corridor.least_inside);
    reasons.push_back({Verdict::differs, text});
  }
  for (const FeatureSummary& feature : summary.features) {
    const FeatureVerdict& mean = summary.means.emplace_back(
        judge_mean(feature, members, options.comparison.uncertainties.coverage_factor));
    summary.verdict = worse(summary.verdict, mean.verdict);
    if (mean.verdict != Verdict::agrees && mean.verdict != Verdict::not_judged) {
      reasons.push_back({mean.verdict, "mean over subjects, " + sentence_of(mean)});
    }
  }
  summary.reasons = worst_first(std::move(reasons));
}

void judge_one_by_one(const Members& members, GroupSummary& summary) {
  summary.verdict = Verdict::not_judged;
  std::vector<Reason> reasons;
  for (const Comparison* one : members) {
    summary.verdict = worse(summary.verdict, one->verdict);
    for (const std::string& reason : one->reasons) {
      reasons.push_back(
          {one->verdict, summary.recordings > 1 ? one->recording + ": " + reason : reason});
    }
  }
  summary.reasons = worst_first(std::move(reasons));
}

void count(const std::vector<Comparison>& all, GroupSummary& summary) {
  for (const Comparison& one : all) {
    if (one.group != summary.group) { continue; }
    ++summary.recordings;
    summary.measured += one.kind == Recording::Kind::measured ? 1 : 0;
    summary.agree += one.verdict == Verdict::agrees ? 1 : 0;
    summary.not_distinguishable += one.verdict == Verdict::not_distinguishable ? 1 : 0;
    summary.differ += one.verdict == Verdict::differs ? 1 : 0;
    summary.not_comparable += one.verdict == Verdict::not_comparable ? 1 : 0;
  }
}

/// A subject agrees when all of the recordings do: they are not independent of each other.
void count_subjects(const Members& members, GroupSummary& summary) {
  const std::vector<std::size_t> subject = subjects_of(members);
  summary.subjects = subject_count(subject);
  std::vector<bool> agrees(summary.subjects, true);
  for (std::size_t n = 0; n < members.size(); ++n) {
    if (members[n]->verdict != Verdict::agrees) { agrees[subject[n]] = false; }
  }
  summary.subjects_agree = static_cast<std::size_t>(std::ranges::count(agrees, true));
  summary.agree_share =
      static_cast<double>(summary.subjects_agree) / static_cast<double>(summary.subjects);
  summary.agree_interval = share_interval(summary.subjects_agree, summary.subjects);
}

GroupSummary summarise_group(const std::vector<Comparison>& all, const std::string& group,
                             const GroupOptions& options) {
  GroupSummary summary{.group = group};
  count(all, summary);
  const Members members = comparable(all, group);
  lay_corridor(members, options.corridor, summary);
  if (members.empty()) {
    for (const Comparison& one : all) {
      if (one.group != group) { continue; }
      summary.reasons.push_back((summary.recordings > 1 ? one.recording + ": " : "") +
                                one.reasons.front());
    }
    return summary;
  }
  count_subjects(members, summary);
  for (std::size_t n = 0; n < feature_count; ++n) {
    summary.features.push_back(summarise(static_cast<Feature>(n), members, options.bootstrap));
  }
  if (summary.corridor) {
    judge_by_corridor(members, options, summary);
  } else {
    judge_one_by_one(members, summary);
  }
  return summary;
}

/// Before the reasons of one of several groups; recordings of the one without a name tell
/// themselves.
std::string label_of(const GroupSummary& group, const std::vector<Comparison>& all) {
  if (!group.group.empty()) { return group.group + ": "; }
  return group.recordings > 1 ? ""
                              : std::ranges::find(all, "", &Comparison::group)->recording + ": ";
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
    result.groups.push_back(summarise_group(result.recordings, one.group, options));
  }
  Verdict worst = Verdict::not_judged;
  std::vector<Reason> reasons;
  for (const GroupSummary& group : result.groups) {
    // What cannot be compared does not decide of the others.
    const Verdict verdict =
        group.verdict == Verdict::not_comparable ? Verdict::not_judged : group.verdict;
    worst = worse(worst, verdict);
    const std::string label = result.groups.size() > 1 ? label_of(group, result.recordings) : "";
    for (const std::string& reason : group.reasons) {
      reasons.push_back({verdict, label + reason});
    }
  }
  result.reasons = worst_first(std::move(reasons));
  if (worst != Verdict::not_judged) { result.verdict = worst; }
  if (recordings.empty()) { result.reasons.emplace_back("there is no recording"); }
  return result;
}

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT

#include "validation/campaign/findings.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "device/seeded.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

namespace palpate::campaign {

using comparison::quantile;

Domain tested_domain(const Scene& scene, const Trace& trace) {
  Domain domain;
  const auto add = [&domain](const char* key, double value) {
    widen(domain, {{key, {value, value}}});
  };
  const Tissue& tissue = scene.tissue;
  std::set<std::string> used;
  if (tissue.source == Source::lattice) { used.insert(tissue.lattice.material); }
  if (tissue.source == Source::layers) {
    for (const Layer& layer : tissue.layers) { used.insert(layer.material); }
  }
  for (const Material& material : scene.materials) {
    if (used.contains(material.name)) { add("youngs_modulus_pa", material.youngs_modulus); }
  }
  if (scene.needle) { add("needle_diameter_m", scene.needle->diameter); }
  if (!scene.needle && !scene.probe) { return domain; }
  const Drive drive = scene.drive.value_or(Drive{});
  if (drive.kind == Drive::Kind::trajectory) { add("speed_m_per_s", drive.speed); }
  if (const Column* depth = trace.find("tool.depth_m"); depth != nullptr && trace.rows() > 0) {
    const auto [low, high] = std::ranges::minmax(depth->values);
    widen(domain, {{"depth_m", {std::max(0.0, low), high}}});
  }
  return domain;
}

void widen(Domain& domain, const Domain& by) {
  for (const auto& [key, range] : by) {
    const auto [found, fresh] = domain.emplace(key, range);
    if (fresh) { continue; }
    found->second = {std::min(found->second[0], range[0]), std::max(found->second[1], range[1])};
  }
}

namespace {

/// Sums of one base sample: what the estimators need of A, B and A with one value from B.
struct BaseSample {
  double a = 0.0;
  double b = 0.0;
  std::vector<double> mixed{};
};

std::vector<BaseSample> base_samples(std::span<const double> values, std::size_t parameters) {
  const std::size_t block = parameters + 2;
  std::vector<BaseSample> samples;
  for (std::size_t at = 0; at + block <= values.size(); at += block) {
    const auto part = values.subspan(at, block);
    if (!std::ranges::all_of(part, [](double v) { return std::isfinite(v); })) { continue; }
    samples.push_back({part[0], part[1], {part.begin() + 2, part.end()}});
  }
  return samples;
}

/// Returns first-order and total index of every parameter: first[0], total[0], first[1], ...
std::vector<double> indices_of(const std::vector<const BaseSample*>& samples,
                               std::size_t parameters) {
  const auto count = static_cast<double>(samples.size());
  double mean = 0.0;
  for (const BaseSample* each : samples) { mean += 0.5 * (each->a + each->b) / count; }
  double variance = 0.0;
  std::vector<double> indices(2 * parameters, 0.0);
  for (const BaseSample* each : samples) {
    const double a = each->a - mean;
    const double b = each->b - mean;
    variance += 0.5 * (a * a + b * b) / count;
    for (std::size_t k = 0; k < parameters; ++k) {
      const double change = each->mixed[k] - each->a;
      indices[2 * k] += b * change / count;
      indices[2 * k + 1] += 0.5 * change * change / count;
    }
  }
  for (double& index : indices) { index /= variance; }
  return indices;
}

}  // namespace

std::vector<Sensitivity> sensitivity_of(std::span<const double> values, std::size_t parameters,
                                        const comparison::BootstrapOptions& options) {
  constexpr std::size_t fewest = 8;
  const std::vector<BaseSample> all = base_samples(values, parameters);
  const bool varies = std::ranges::any_of(all, [&](const BaseSample& each) {
    return each.a != all.front().a || each.b != all.front().a;
  });
  if (all.size() < fewest || !varies) { return {}; }
  std::vector<const BaseSample*> chosen;
  for (const BaseSample& each : all) { chosen.push_back(&each); }
  const std::vector<double> best = indices_of(chosen, parameters);
  std::vector<std::vector<double>> drawn(best.size());
  device::Seeded seeded(options.seed);
  const auto count = static_cast<double>(all.size());
  for (std::size_t draw = 0; draw < options.draws; ++draw) {
    for (const BaseSample*& each : chosen) {
      each = &all[static_cast<std::size_t>(seeded.uniform(0.0, count))];
    }
    const std::vector<double> again = indices_of(chosen, parameters);
    for (std::size_t n = 0; n < again.size(); ++n) { drawn[n].push_back(again[n]); }
  }
  const double tail = 0.5 * (1.0 - options.level);
  const auto interval = [&](std::size_t n) {
    return comparison::Interval{quantile(drawn[n], tail), quantile(drawn[n], 1.0 - tail)};
  };
  std::vector<Sensitivity> result;
  for (std::size_t k = 0; k < parameters; ++k) {
    result.push_back(
        {best[2 * k], best[2 * k + 1], interval(2 * k), interval(2 * k + 1), all.size()});
  }
  return result;
}

namespace {

/// Jobs that fail for one reason, and the smallest of them.
struct Cause {
  std::size_t jobs = 0;
  const JobResult* smallest = nullptr;
};

bool broken(const Claim& claim, double value) {
  return !(value >= claim.lower.value_or(-unbounded) && value <= claim.upper.value_or(unbounded));
}

std::map<std::string, Cause> causes_of(const Campaign& campaign,
                                       std::span<const JobResult> results) {
  std::map<std::string, Cause> causes;
  const auto add = [&causes](const std::string& text, const JobResult& job) {
    Cause& cause = causes[text];
    ++cause.jobs;
    const bool smaller = cause.smallest == nullptr || job.nodes < cause.smallest->nodes ||
                         (job.nodes == cause.smallest->nodes && job.id < cause.smallest->id);
    if (smaller) { cause.smallest = &job; }
  };
  for (const JobResult& job : results) {
    if (job.status != "ok") {
      add(job.status + (job.cause.empty() ? "" : ": " + job.cause), job);
      continue;
    }
    for (const Claim& claim : campaign.claims) {
      const auto found = job.quantities.find(claim.quantity);
      if (found == job.quantities.end()) {
        add(claim.quantity + " is not in the result", job);
      } else if (broken(claim, found->second)) {
        add(claim.quantity + " is outside its bounds", job);
      }
    }
  }
  return causes;
}

Outcome jobs_outcome(const Campaign& campaign, std::span<const JobResult> results) {
  Outcome outcome{.name = "campaign/jobs",
                  .suite = "campaign",
                  .claim = "Every job ends, and its result can be trusted"};
  const auto failed =
      std::ranges::count_if(results, [](const JobResult& job) { return job.status != "ok"; });
  outcome.judge_equal("failed_jobs", failed, 0, "every job must have the status ok");
  outcome.report("jobs", results.size());
  const auto causes = causes_of(campaign, results);
  if (!causes.empty()) {
    Table& table = outcome.table("causes", "Failures by cause",
                                 "Each cause with the job of the fewest nodes that shows it.",
                                 {"cause", "jobs (1)", "smallest scene", "nodes (1)", "job"});
    for (const auto& [text, cause] : causes) {
      table.rows.push_back(
          {text, cause.jobs, cause.smallest->group, cause.smallest->nodes, cause.smallest->id});
    }
  }
  conclude(outcome);
  return outcome;
}

/// Values of the jobs that ended well: until it diverges, a run says nothing of the rest.
std::vector<double> values_of(const std::string& quantity, std::span<const JobResult> results) {
  std::vector<double> values;
  for (const JobResult& job : results) {
    const auto found = job.quantities.find(quantity);
    if (job.status == "ok" && found != job.quantities.end() && std::isfinite(found->second)) {
      values.push_back(found->second);
    }
  }
  return values;
}

/// Returns a figure id: lower-case letters, digits and '-'.
std::string id_of(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    id += kept ? c : '-';
  }
  return id;
}

void add_histogram(Outcome& outcome, const std::string& quantity,
                   const std::vector<double>& values) {
  constexpr std::size_t bins = 30;
  const auto [low, high] = std::ranges::minmax(values);
  if (!(high > low) || !std::isfinite(high - low)) { return; }
  std::vector<double> count(bins, 0.0);
  for (const double value : values) {
    const double share = (value - low) / (high - low);
    ++count[std::min(bins - 1, static_cast<std::size_t>(share * bins))];
  }
  Figure& figure = outcome.plot("distribution-" + id_of(quantity), "Distribution of " + quantity,
                                "Number of jobs in each of 30 equal intervals.",
                                {.label = quantity}, {.label = "jobs (1)", .minimum = 0.0});
  Series series{.label = "jobs", .style = Series::Style::line};
  for (std::size_t n = 0; n < bins; ++n) {  // the outline of the bars
    const double width = (high - low) / bins;
    series.add(low + width * static_cast<double>(n), count[n]);
    series.add(low + width * static_cast<double>(n + 1), count[n]);
  }
  figure.series.push_back(std::move(series));
}

std::vector<Cell> distribution_row(const std::string& quantity, const std::vector<double>& values) {
  const auto [low, high] = std::ranges::minmax(values);
  return {quantity,
          values.size(),
          comparison::mean_of(values),
          values.size() > 1 ? comparison::deviation_of(values) : 0.0,
          low,
          quantile(values, 0.05),
          quantile(values, 0.5),
          quantile(values, 0.95),
          high};
}

const std::vector<std::string> distribution_columns{
    "quantity", "jobs (1)", "mean",   "standard deviation", "smallest", "5 %",
    "median",   "95 %",     "largest"};

Outcome claim_outcome(const Claim& claim, std::span<const JobResult> results) {
  Outcome outcome{.name = "campaign/" + claim.quantity, .suite = "campaign"};
  outcome.claim = claim.quantity + " is within its bounds in every job";
  const std::vector<double> values = values_of(claim.quantity, results);
  outcome.judge_equal("jobs_without_value", results.size() - values.size(), 0,
                      "every job must end well with a finite value");
  if (!values.empty()) {
    const auto [low, high] = std::ranges::minmax(values);
    if (claim.lower) {
      outcome.judge_at_least("smallest", low, *claim.lower, claim.bound_from);
    } else {
      outcome.report("smallest", low);
    }
    if (claim.upper) {
      outcome.judge_at_most("largest", high, *claim.upper, claim.bound_from);
    } else {
      outcome.report("largest", high);
    }
    outcome.table("distribution", "Distribution over the jobs", "", distribution_columns)
        .rows.push_back(distribution_row(claim.quantity, values));
    add_histogram(outcome, claim.quantity, values);
  }
  conclude(outcome);
  return outcome;
}

std::set<std::string> quantities_of(std::span<const JobResult> results) {
  std::set<std::string> names;
  for (const JobResult& job : results) {
    for (const auto& [name, value] : job.quantities) { names.insert(name); }
  }
  return names;
}

Outcome distributions_outcome(std::span<const JobResult> results) {
  Outcome outcome{.name = "campaign/quantities",
                  .suite = "campaign",
                  .claim = "Distribution of every quantity over the jobs"};
  outcome.skip("shown only: the bounds of a claim decide");
  Table& table = outcome.table("distributions", "Distributions", "", distribution_columns);
  for (const std::string& name : quantities_of(results)) {
    const std::vector<double> values = values_of(name, results);
    if (!values.empty()) { table.rows.push_back(distribution_row(name, values)); }
  }
  return outcome;
}

Outcome sensitivity_outcome(const Campaign& campaign, std::span<const JobResult> results) {
  Outcome outcome{.name = "campaign/sensitivity",
                  .suite = "campaign",
                  .claim = "Share of the variance that each parameter causes"};
  if (campaign.design.method != Method::saltelli) {
    outcome.skip("not computed: it needs method = \"saltelli\"");
    return outcome;
  }
  outcome.skip("shown only: a share of a variance has no bound");
  Table& table = outcome.table(
      "indices", "Sobol indices with 95 % bootstrap intervals",
      "First order: alone. Total: with all interactions. Differences of intervals that overlap are "
      "not shown by these samples.",
      {"quantity", "scene", "parameter", "first order", "from", "to", "total", "from", "to",
       "base samples (1)"});
  const std::size_t rows = row_count(campaign.design);
  const std::vector<Parameter>& parameters = campaign.design.parameters;
  std::map<std::string, std::vector<const JobResult*>> groups;
  for (const JobResult& job : results) { groups.try_emplace(job.group); }
  constexpr std::size_t most_groups = 20;
  if (groups.size() > most_groups) {
    outcome.notes.push_back("The first 20 of " + std::to_string(groups.size()) +
                            " combinations of scene, patient, seed, subject and build are shown.");
    groups.erase(std::next(groups.begin(), most_groups), groups.end());
  }
  for (auto& [label, group] : groups) { group.resize(rows); }
  for (const JobResult& job : results) {
    const auto group = groups.find(job.group);
    if (group == groups.end()) { continue; }
    for (const std::size_t row : job.rows) { group->second.at(row) = &job; }
  }
  for (const std::string& name : quantities_of(results)) {
    for (const auto& [label, group] : groups) {
      std::vector<double> values;
      for (const JobResult* job : group) {
        const bool has = job != nullptr && job->status == "ok" && job->quantities.contains(name);
        values.push_back(has ? job->quantities.at(name) : std::nan(""));
      }
      const std::vector<Sensitivity> indices = sensitivity_of(values, parameters.size());
      for (std::size_t k = 0; k < indices.size(); ++k) {
        const Sensitivity& each = indices[k];
        table.rows.push_back({name, label, parameters[k].key, each.first, each.first_interval.lower,
                              each.first_interval.upper, each.total, each.total_interval.lower,
                              each.total_interval.upper, each.samples});
      }
    }
  }
  return outcome;
}

/// The timing claim; empty if the campaign has none.
std::optional<Outcome> timing_outcome(std::span<const JobResult> results) {
  Outcome outcome{.name = "campaign/timing",
                  .suite = "timing",
                  .claim = "The mean time of a tick keeps the deadline in every job"};
  std::size_t judged = 0;
  std::size_t late = 0;
  std::string reason;
  for (const JobResult& job : results) {
    if (job.timing.empty()) { return std::nullopt; }
    judged += job.timing == "not judged" ? 0 : 1;
    late += job.timing == "fail" ? 1 : 0;
    if (job.timing == "not judged") { reason = job.timing_reason; }
  }
  if (judged < results.size()) {
    outcome.report("jobs_judged", judged);
    outcome.skip("not judged: " + reason);
    return outcome;
  }
  outcome.judge_equal("late_jobs", late, 0, "deadline of the campaign");
  conclude(outcome);
  return outcome;
}

}  // namespace

std::vector<Outcome> outcomes_of(const Campaign& campaign, std::span<const JobResult> results) {
  std::vector<Outcome> outcomes{jobs_outcome(campaign, results)};
  for (const Claim& claim : campaign.claims) { outcomes.push_back(claim_outcome(claim, results)); }
  if (auto timing = timing_outcome(results)) { outcomes.push_back(std::move(*timing)); }
  outcomes.push_back(distributions_outcome(results));
  outcomes.push_back(sensitivity_outcome(campaign, results));
  return outcomes;
}

}  // namespace palpate::campaign

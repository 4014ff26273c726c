// SPDX-License-Identifier: MIT
#pragma once
/// Findings of a campaign as outcomes: failures by cause, distributions, claims, sensitivity.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "validation/campaign/plan.hpp"
#include "validation/outcome.hpp"
#include "validation/statistics.hpp"

namespace palpate::campaign {

/// Smallest and largest tested value by key: "speed_m_per_s", "depth_m", "needle_diameter_m",
/// "youngs_modulus_pa".
using Domain = std::map<std::string, std::array<double, 2>>;

/// Extends the ranges so that they contain the others.
void widen(Domain& domain, const Domain& by);

/// Returns what a run has tested.
Domain tested_domain(const Scene& scene, const Trace& trace);

/// Bounds that a quantity must keep in every job.
struct Claim {
  std::string quantity{};
  std::optional<double> lower{};
  std::optional<double> upper{};
  std::string bound_from{};
};

struct JobResult {
  std::string id{};
  std::string scene{};              ///< as named by the campaign
  std::string group{};              ///< scene, patient, seed, subject and build
  std::vector<std::size_t> rows{};  ///< of the design, that have these inputs
  long nodes = 0;                   ///< of the scene's network
  std::string status{};             ///< ok, unreliable, diverged or error
  std::string cause{};              ///< of a status other than ok, without numbers
  std::map<std::string, double> quantities{};
  Domain domain{};
  std::string timing{};  ///< pass, fail or not judged; empty: the campaign claims no time
  std::string timing_reason{};
};

struct Campaign {
  std::string title{};
  Design design{};
  std::vector<Claim> claims{};
};

/// Sobol indices of one parameter with 95 % bootstrap intervals over the base samples.
struct Sensitivity {
  double first = 0.0;
  double total = 0.0;
  comparison::Interval first_interval{};
  comparison::Interval total_interval{};
  std::size_t samples = 0;  ///< base samples with finite values only
};

/// Returns the indices of `parameters` parameters from the values of Saltelli's design in the order
/// of rows_of(): first order by Saltelli et al. (2010), total by Jansen, Comput. Phys. Commun. 117
/// (1999) 35. Base samples with a value that is not finite are left out. Empty if fewer than 8
/// remain or the values do not vary.
std::vector<Sensitivity> sensitivity_of(std::span<const double> values, std::size_t parameters,
                                        const comparison::BootstrapOptions& options = {
                                            .draws = 400});

/// Returns the outcomes of a complete list of results.
std::vector<Outcome> outcomes_of(const Campaign& campaign, std::span<const JobResult> results);

}  // namespace palpate::campaign

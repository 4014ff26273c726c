// SPDX-License-Identifier: MIT
#pragma once
/// Contents of a merged campaign, and the domain that runs have tested.

#include <array>
#include <map>
#include <string>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "reports/results/results.hpp"

namespace palpate::cli {

/// Smallest and largest tested value by key: "speed_m_per_s", "depth_m", "needle_diameter_m",
/// "youngs_modulus_pa".
using Domain = std::map<std::string, std::array<double, 2>>;

/// Extends the ranges so that they contain the others.
void widen(Domain& domain, const Domain& by);

/// Returns what a run has tested.
Domain tested_domain(const Scene& scene, const Trace& trace);

/// Returns the findings of a merged file, and extends the domain by its jobs with the status ok.
/// `name` is used in messages. Throws InputError.
Results campaign_findings(const std::string& text, const std::string& name, Domain& domain);

}  // namespace palpate::cli

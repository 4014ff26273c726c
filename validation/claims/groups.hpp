// SPDX-License-Identifier: MIT
#pragma once
/// Case groups: one function for each file of claims.

#include <functional>
#include <string>
#include <vector>

#include "model/stepping/integrator.hpp"
#include "validation/case.hpp"
#include "validation/certificate/tail.hpp"

namespace palpate {

std::vector<Case> patient_cases();  ///< a network sampled from a patient's MRI
std::vector<Case> tissue_cases();   ///< tissue from surfaces and images: solids and phantoms

namespace subjects {
std::vector<Case> cases();  ///< any simulator under test
Case cost_case();           ///< bench/subject: time of a step
}  // namespace subjects

namespace oscillator {
std::vector<Case> order_cases();            ///< closed forms, observed orders, sweep of damping
std::vector<Case> stability_limit_cases();  ///< oscillator/stability-limit/<scheme>
std::vector<Case> figure_cases();           ///< the paper's Figs. 6-10 and Table 1
}  // namespace oscillator

namespace errata {
std::vector<Case> cases();  ///< each printed erratum separately and all together
}

namespace networks {
std::vector<Case> elasticity_cases();    ///< at rest, shear (Fig. 12), frequencies, dispersion
std::vector<Case> conservation_cases();  ///< momentum, energy, work, invariance
std::vector<Case> convergence_cases();   ///< Figs. 13-15, manufactured solutions, orders
std::vector<Case> kernel_cases();        ///< kernels, approximations, steps on which a load acts
}  // namespace networks

namespace stability {
std::vector<Case> limit_cases();       ///< spectral bounds, step limits, contrast
std::vector<Case> robustness_cases();  ///< extreme inputs, random steps, denormals, drift
}  // namespace stability

namespace tools {
std::vector<Case> balance_cases();    ///< parts, momentum, energy, friction
std::vector<Case> passage_cases();    ///< layers, bone, published moduli, extremes
std::vector<Case> probe_cases();      ///< continuum solutions, palpation, sliding
std::vector<Case> reference_cases();  ///< exact curves and a reference with root finding
}  // namespace tools

namespace haptics {
std::vector<Case> wall_cases();    ///< virtual walls compared with the theory of sampled loops
std::vector<Case> falcon_cases();  ///< hand, emulated Falcon and tissue in one loop; drivers
}  // namespace haptics

namespace clinical {
std::vector<Case> measure_cases();      ///< distances, ratings, filter, features, detection
std::vector<Case> comparison_cases();   ///< verdicts, corridors, round trip through the link
std::vector<Case> calibration_cases();  ///< parameters from recordings
}  // namespace clinical

namespace certificate {
std::vector<Case> cases();  ///< the statistics of a real-time certificate
/// Returns the tail of responses in which every late one makes the next one late.
Tail tail_of_pairs(std::uint64_t seed);
}  // namespace certificate

namespace gating {
std::vector<Case> cases();  ///< self-test of the harness: changes that its gate must detect
}

/// Expected seconds of a case by the kind of its integrator.
struct SchemeWeights {
  double explicit_scheme = 1.0;
  double implicit_scheme = 1.0;
};
/// Appends a case for every integrator; its name follows `prefix`.
void add_scheme_cases(
    std::vector<Case>& cases, const std::string& prefix, const std::string& suite,
    const std::function<std::string(const IntegratorInfo&)>& claim,
    const std::function<void(const IntegratorInfo&, const CaseContext&, Outcome&)>& measure,
    const SchemeWeights& weights = {});

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Case groups, one file or folder each.

#include <vector>

#include "validation/case.hpp"

namespace palpate {

std::vector<Case> oscillator_cases();   ///< the paper's Figs. 6-10 and Table 1
std::vector<Case> errata_cases();       ///< each printed erratum separately and all together
std::vector<Case> network_cases();      ///< elasticity, waves, invariants, order on networks
std::vector<Case> patient_cases();      ///< a network sampled from a patient's MRI
std::vector<Case> stability_cases();    ///< margins under stress
std::vector<Case> haptic_cases();       ///< haptic loops with a device
std::vector<Case> tool_cases();         ///< needle, probe, syringe
std::vector<Case> certificate_cases();  ///< the statistics of a real-time certificate
std::vector<Case>
clinical_cases();  ///< measures of the comparison of recorded with simulated insertions
std::vector<Case> gate_cases();  ///< self-test of the harness: changes that its gate must detect

// Claims about tissue built from surfaces and images, tested with solids and phantoms with known
// results.

std::vector<Case> patient_tissue_cases();

Case skin_case();   ///< "tissue/skin"
Case hertz_case();  ///< "tissue/hertz"

}  // namespace palpate

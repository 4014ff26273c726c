// SPDX-License-Identifier: MIT
#pragma once
/// The groups of cases, one file or folder each.

#include <vector>

#include "validation/case.hpp"

namespace palpate {

std::vector<Case> oscillator_cases();   ///< the paper's Figs. 6-10 and Table 1
std::vector<Case> errata_cases();       ///< each printed erratum alone and all together
std::vector<Case> network_cases();      ///< elasticity, waves, invariants, order on networks
std::vector<Case> patient_cases();      ///< a network sampled from a patient's MRI
std::vector<Case> stability_cases();    ///< margins under stress
std::vector<Case> haptic_cases();       ///< loops through a device
std::vector<Case> tool_cases();         ///< needle, probe, syringe
std::vector<Case> certificate_cases();  ///< the statistics of a real-time certificate
std::vector<Case>
clinical_cases();                ///< recorded against simulated insertions: the measures themselves
std::vector<Case> gate_cases();  ///< the harness judged by itself: what its gate must see

// Claims about tissue that is built from surfaces and images, of solids and phantoms with known
// answers.

std::vector<Case> patient_tissue_cases();

Case skin_case();   ///< "tissue/skin"
Case hertz_case();  ///< "tissue/hertz"

}  // namespace palpate

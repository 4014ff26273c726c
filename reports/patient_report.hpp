// SPDX-License-Identifier: MIT
#pragma once
/// What a run's page says of tissue that came from a patient's files.

#include <vector>

#include "model/dynamics/scene.hpp"
#include "reports/html_page.hpp"

namespace palpate {

/// What was read and what became of it, and the layers on the needle's line; nothing for other tissues.
std::vector<Fact> patient_facts(const Scene& scene);

/// Of an image: one plane through it, along the needle, as brightness and as the modulus that each lookup
/// makes of it. Nothing for other tissues.
std::vector<Figure> lookup_figures(const Scene& scene);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// One case as results.json and baselines hold it. Figures go without the numbers of their curves, which
/// figure_data.hpp keeps.

#include <nlohmann/json.hpp>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

nlohmann::ordered_json case_json(const Outcome& outcome);
nlohmann::ordered_json cases_json(const std::vector<Outcome>& outcomes);

/// Throws what the JSON library throws, or std::runtime_error.
Outcome case_from_json(const nlohmann::ordered_json& json);

/// A number, or the text that stands for one which JSON lacks: "nan", "inf", "-inf".
double number_from_json(const nlohmann::ordered_json& json);

}  // namespace palpate

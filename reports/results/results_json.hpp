// SPDX-License-Identifier: MIT
#pragma once
/// results.json: outcomes as JSON and back.

#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/problem/input_error.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// A number; NaN and infinity, which JSON lacks, as text.
inline nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) { return value; }
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

/// A number, or null where there is no limit.
inline nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

// Errors in a JSON file, without the terms of the JSON library.

/// "FILE:LINE: not JSON from here on; ALLOWED", or "FILE: WHAT; ALLOWED" when what is wrong has no
/// place.
InputError json_trouble(const std::string& file, const std::string& text,
                        const std::exception& problem, const std::string& allowed);

// One case as results.json and baselines hold it. Figures go without the numbers of their curves,
// which figure_data.hpp keeps.

nlohmann::ordered_json case_json(const Outcome& outcome);
nlohmann::ordered_json cases_json(const std::vector<Outcome>& outcomes);

/// Throws what the JSON library throws, or std::runtime_error.
Outcome case_from_json(const nlohmann::ordered_json& json);

/// A number, or the text of one that JSON lacks: "nan", "inf", "-inf".
double number_from_json(const nlohmann::ordered_json& json);

// results.json (docs/formats.md): what was found, and which data set of which trace file every
// figure draws. The numbers of figures are in the trace files, not here.

/// Same data, same bytes. Only these vary from run to run: "seconds", "timings",
/// "provenance" and in tables and figures marked "timing".
std::string to_json(const Results& results);

/// The reverse; figures come without their numbers (figure_data.hpp adds them). `name` is used in
/// messages. Throws InputError.
Results results_from_json(const std::string& text, const std::string& name);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of outcomes to and from results.json.

#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/problem/input_error.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Converts a number to JSON. NaN and infinity, which JSON lacks, become text.
inline nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) { return value; }
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

/// Converts a limit to JSON; null if there is no limit.
inline nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

// Error messages for JSON files, without internal terms of the JSON library.

/// Returns the error "FILE:LINE: not JSON from here on; ALLOWED", or "FILE: WHAT; ALLOWED" if the
/// problem has no position.
InputError json_trouble(const std::string& file, const std::string& text,
                        const std::exception& problem, const std::string& allowed);

// One case in results.json and in baselines. Figures are stored without the samples of their
// curves.

nlohmann::ordered_json case_json(const Outcome& outcome);
nlohmann::ordered_json cases_json(const std::vector<Outcome>& outcomes);

/// Parses one case. Throws exceptions of the JSON library, or std::runtime_error.
Outcome case_from_json(const nlohmann::ordered_json& json);

/// Parses a number, or one of the texts "nan", "inf" and "-inf".
double number_from_json(const nlohmann::ordered_json& json);

// results.json (docs/formats.md): outcomes, and for every figure the trace file and data set of its
// numbers. The numbers of figures are only in the trace files.

/// Writes results.json. Output is deterministic except for "seconds", "timings", "provenance" and
/// tables and figures marked "timing".
std::string to_json(const Results& results);

/// Parses results.json. Figures have no numbers; read_figure_data() adds them. `name` is used in
/// error messages. Throws InputError.
Results results_from_json(const std::string& text, const std::string& name);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of outcomes to and from results.json.

#include <cmath>
#include <cstdint>
#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "model/problem/input_error.hpp"
#include "model/problem/trace.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Parses a text. Throws an exception of the library if it is not JSON, or if it is nested deeper
/// than any file of this program: the library copies, prints and deletes by recursion.
nlohmann::ordered_json parse_json(std::string_view text);

/// Converts a number to JSON. NaN and infinity, which JSON lacks, become text.
inline nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) { return value; }
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

/// Converts a limit to JSON; null if there is no limit.
inline nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

/// Value of a key: numbers by json_number(), null for an empty optional, texts and lists as they
/// are.
template <class Value> nlohmann::ordered_json json_value(const Value& value) {
  if constexpr (std::is_floating_point_v<Value>) {
    return json_number(value);
  } else {
    return value;
  }
}
template <class Value> nlohmann::ordered_json json_value(const std::optional<Value>& value) {
  return value ? json_value(*value) : nlohmann::ordered_json(nullptr);
}

/// Adds keys, each followed by its value.
inline void add_keys(nlohmann::ordered_json&) {}
template <class Value, class... Rest>
void add_keys(nlohmann::ordered_json& json, const char* key, const Value& value,
              const Rest&... rest) {
  json[key] = json_value(value);
  add_keys(json, rest...);
}

/// Returns an object: object("name", "tip", "time_s", 0.5).
template <class... KeysAndValues>
nlohmann::ordered_json object(const KeysAndValues&... keys_and_values) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  add_keys(json, keys_and_values...);
  return json;
}

/// Returns a list of the converted items.
template <class Items, class Convert>
nlohmann::ordered_json list_of(const Items& items, const Convert& convert) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& item : items) { list.push_back(convert(item)); }
  return list;
}

/// Text of a JSON file, with a line end. Invalid UTF-8 becomes the replacement character.
inline std::string json_text(const nlohmann::ordered_json& json, int indent = 1) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// Text of a JSON file with the last key "seal": the SHA-256 of the same text with 64 zeros in its
/// place. It detects a change by accident or by hand; whoever wants to can compute another one.
std::string sealed_text(nlohmann::ordered_json json, int indent = 1);

/// Parses such a text. Throws std::runtime_error if it has no seal or the seal of another text.
nlohmann::ordered_json parse_sealed(const std::string& text);

/// Text of a JSON value for a script element, without the character '<'.
std::string script_text(const nlohmann::ordered_json& json);

/// Null for an empty text.
inline nlohmann::ordered_json text_or_null(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(text);
}

// Error messages for JSON files, without internal terms of the JSON library.

/// Returns the error "FILE:LINE: not JSON from here on; ALLOWED", or "FILE: WHAT; ALLOWED" if the
/// problem has no position.
InputError json_trouble(const std::string& file, const std::string& text,
                        const std::exception& problem, const std::string& allowed);

// One case in results.json and in baselines. Figures are stored without the samples of their
// curves.

nlohmann::ordered_json case_json(const Outcome& outcome);

/// Parses one case. Throws exceptions of the JSON library, or std::runtime_error.
Outcome case_from_json(const nlohmann::ordered_json& json);

/// Throws std::runtime_error if a case says pass and its quantities do not: this program does not
/// write such a case.
void check_verdict(const Outcome& outcome);

/// Throws std::runtime_error if a summary.json contradicts the trace of its run.
void check_summary(const nlohmann::ordered_json& summary, const Trace& trace);

/// Parses a number, or one of the texts "nan", "inf" and "-inf".
double number_from_json(const nlohmann::ordered_json& json);

/// Throws std::runtime_error for numbers of a sealed file that contradict each other.
inline void require_consistent(bool holds, const std::string& what) {
  if (!holds) { throw std::runtime_error("contradicts itself: " + what); }
}

/// Parses a whole number. Throws std::runtime_error if it has a fraction or does not fit the type:
/// the library converts such a number with undefined behaviour.
template <class Whole> Whole whole_from_json(const nlohmann::ordered_json& json) {
  const bool fits = json.is_number_unsigned() ? std::in_range<Whole>(json.get<std::uint64_t>())
                                              : json.is_number_integer() &&
                                                    std::in_range<Whole>(json.get<std::int64_t>());
  if (!fits) { throw std::runtime_error(json.dump() + " is no whole number that is allowed here"); }
  return json.get<Whole>();
}

// results.json (docs/formats.md): outcomes, and for every figure the trace file and data set of its
// numbers. The numbers of figures are only in the trace files.

/// Writes results.json. Output is deterministic except for "seconds", "timings", "provenance" and
/// tables and figures marked "timing".
std::string to_json(const Results& results);

/// Parses results.json. Figures have no numbers; read_figure_data() adds them. `name` is used in
/// error messages. Throws InputError.
Results results_from_json(const std::string& text, const std::string& name);

}  // namespace palpate

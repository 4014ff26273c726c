// SPDX-License-Identifier: MIT
#pragma once
/// History of benchmark runs: one line of JSON per run, oldest first.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "reports/results/results.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::timing {

struct HistoryValue {
  double value = 0.0;
  std::string unit{};
};

struct HistoryLine {
  std::string date{};
  std::string commit{};
  std::string compiler{};
  std::map<std::string, HistoryValue> quantities{};  ///< finite quantities by "case: quantity"
};

HistoryLine history_line_of(const Results& results);

/// Reads a history file. A missing file gives an empty history. Throws InputError with file and
/// line if a line does not have the format of to_text(). A last line that was cut short is ignored.
std::vector<HistoryLine> read_history(const std::filesystem::path& file);

std::string to_text(const HistoryLine& line);

/// Appends one line whole or not at all, and removes a last line that was cut short. Throws
/// InputError if the file cannot be written.
void append_line(const std::filesystem::path& file, const std::string& line);

/// Calls read() for each line. A missing file has no lines; a last line that was cut short is
/// ignored. Throws InputError with file and line, and what is `expected`, if read() throws.
void for_each_line(const std::filesystem::path& file,
                   const std::function<void(const std::string&)>& read,
                   const std::string& expected);

/// Trends of the counted quantities of the last run, over all runs with the same compiler.
std::vector<Trend> trends_of(const std::vector<HistoryLine>& history);

/// Outcome of the case "bench/history": checks for gradual regressions, with one figure per trend.
Outcome history_outcome(const std::vector<HistoryLine>& history);

}  // namespace palpate::timing

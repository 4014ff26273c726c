// SPDX-License-Identifier: MIT
#pragma once
/// Runs of the benchmark, one line of JSON each, oldest first.

#include <filesystem>
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
  std::map<std::string, HistoryValue> quantities{};  ///< by "case: quantity", finite ones
};

HistoryLine history_line_of(const Results& results);

/// Throws InputError, naming file and line, when one is not what to_text() writes. A file that is
/// not there holds none.
std::vector<HistoryLine> read_history(const std::filesystem::path& file);

std::string to_text(const HistoryLine& line);

/// All of it or nothing. Throws InputError when the file cannot be written.
void append_history(const std::filesystem::path& file, const HistoryLine& line);

/// What is counted, over the runs with the compiler of the last one; only what the last one has.
std::vector<Trend> trends_of(const std::vector<HistoryLine>& history);

/// The case "bench/history": whether anything has crept, with a figure of every trend.
Outcome history_outcome(const std::vector<HistoryLine>& history);

}  // namespace palpate::timing

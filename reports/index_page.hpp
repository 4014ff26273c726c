// SPDX-License-Identifier: MIT
#pragma once
/// Page over the results in one folder (palpate-out/index.html) and its ledger (index.jsonl), which
/// has one line for each finished command.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

struct IndexValue {
  std::string name{};
  double value = 0.0;
  std::string unit{};   ///< "1" for counts
  bool timing = false;  ///< differs from run to run
};

/// One result: what a command left in its folder.
struct IndexLine {
  std::string folder{};  ///< name of its folder beside the ledger
  std::string kind{};    ///< command, such as "run"
  std::string title{};
  std::string verdict{};
  std::string date{};     ///< UTC, ISO 8601
  std::string command{};  ///< that repeats it
  int exit_code = 0;
  std::vector<IndexValue> values{};
};

/// Reads the result in a folder from its summary.json, results.json, gate.json, certificate.json,
/// comparison.json or calibration.json, whichever is the newest. `kind` is empty if there is none.
IndexLine index_line_of(const std::filesystem::path& folder);

/// Result of a run from the text of its summary.json, without folder, date and command. Throws
/// Json::exception if it is damaged.
IndexLine index_line_of_run(const std::string& summary);

/// Differences between two results of one folder: verdict, scene and values. Run times and their
/// counts are left out.
std::vector<std::string> changes_between(const IndexLine& before, const IndexLine& now);

/// Reads a ledger, oldest line first. A missing file has no lines. Throws InputError with file and
/// line if a line is damaged; a last line that was cut short is ignored.
std::vector<IndexLine> read_index(const std::filesystem::path& ledger);

std::string to_text(const IndexLine& line);

/// Title of the page, by which `palpate index` knows its own.
inline constexpr std::string_view index_title = "Palpate results";

/// HTML page: what changed since the run before, then each folder of the ledger with its verdict,
/// values and their history, newest first. Folders that no longer exist are omitted.
std::string index_html(const std::vector<IndexLine>& lines, const std::filesystem::path& parent);

/// Appends the result in a folder to the ledger beside it and writes the page again. Does nothing
/// if the folder has no result. Throws InputError if the files cannot be written.
void add_to_index(const std::filesystem::path& folder, const std::string& command, int exit_code);

/// Appends the result of every folder in `parent` that the ledger lacks, writes the page, and
/// returns the number of results. Throws InputError.
std::size_t index_folders_in(const std::filesystem::path& parent);

}  // namespace palpate

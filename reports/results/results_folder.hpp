// SPDX-License-Identifier: MIT
#pragma once
/// The numbers behind figures: traces/<case, '/' as '-'>.h5, one group per figure, one per series.

#include <filesystem>

#include "fixtures/io/hdf5_file.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Name of a case's file inside traces/.
std::string trace_file_name(const std::string& case_name);

/// Groups inside the file: "/figures/error-over-step/series_0" holds x, y and for a band or an area
/// y2.
std::string series_group(const Figure& figure, std::size_t index);
/// Holds x, y and the row-major z.
std::string heat_map_group(const Figure& figure);

/// Writes the file of a case that has figures; does nothing otherwise.
void write_figure_data(const std::filesystem::path& traces, const Outcome& outcome);

/// Fills in the numbers of the outcome's figures. Throws InputError when they are not
/// there or do not fit together.
void read_figure_data(const std::filesystem::path& traces, Outcome& outcome);

/// The same below a group of any file; `path` names it in messages.
void write_figures(io::Hdf5File& file, const std::string& above,
                   const std::vector<Figure>& figures);
void read_figures(const io::Hdf5File& file, const std::filesystem::path& path,
                  const std::string& above, std::vector<Figure>& figures);

// A results folder: results.json, results.xml, report.html and traces/.

/// Writes every file under a temporary name and renames it; report.html last.
void write_results_folder(const std::filesystem::path& folder, const Results& results);

/// From results.json and traces/ alone. Throws InputError.
Results read_results_folder(const std::filesystem::path& folder);

// What `palpate run` left in a folder, as a case that a gate can hold against another run of the
// scene.

/// Whether a folder holds a run, and no results.json.
bool is_run_folder(const std::filesystem::path& folder);

/// One outcome, "run": facts, energies and events as quantities, every column of the trace as a
/// figure over time, and how far every node has moved. A run that diverged or was cut short is an
/// error. Throws InputError.
Results read_run_folder(const std::filesystem::path& folder);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// The numbers behind figures: traces/<case, '/' as '-'>.h5, one group per figure, one per series.

#include <filesystem>

#include "fixtures/io/hdf5_file.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Name of a case's file inside traces/.
std::string trace_file_name(const std::string& case_name);

/// Groups inside the file: "/figures/error-over-step/series_0" holds x, y and for a band or an area y2.
std::string series_group(const Figure& figure, std::size_t index);
/// Holds x, y and the row-major z.
std::string heat_map_group(const Figure& figure);

/// Writes the file of a case that has figures; does nothing otherwise.
void write_figure_data(const std::filesystem::path& traces, const Outcome& outcome);

/// Fills in the numbers of the outcome's figures. Throws InputError when they are not
/// there or do not fit together.
void read_figure_data(const std::filesystem::path& traces, Outcome& outcome);

/// The same below a group of any file; `path` names it in messages.
void write_figures(io::Hdf5File& file, const std::string& above, const std::vector<Figure>& figures);
void read_figures(const io::Hdf5File& file, const std::filesystem::path& path, const std::string& above,
                  std::vector<Figure>& figures);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Numbers of figures in traces/CASE.h5 ('/' in the case name becomes '-'): one group per figure,
/// one subgroup per series.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fixtures/io/hdf5_file.hpp"
#include "model/problem/trace.hpp"
#include "reports/results/results.hpp"
#include "validation/gate/baseline.hpp"

namespace palpate {

/// File name of a case in traces/.
std::string trace_file_name(const std::string& case_name);

/// Path of the HDF5 group of a series: "/figures/error-over-step/series_0". It holds x, y and, for
/// a band or an area, y2.
std::string series_group(const Figure& figure, std::size_t index);
/// Path of the HDF5 group of a heat map. It holds x, y and z in row-major order.
std::string heat_map_group(const Figure& figure);

/// Writes the file of a case. Does nothing if the case has no figures.
void write_figure_data(const std::filesystem::path& traces, const Outcome& outcome);

/// Reads the numbers of the outcome's figures into the outcome. Throws InputError if they are
/// missing or inconsistent.
void read_figure_data(const std::filesystem::path& traces, Outcome& outcome);

/// Write and read figures below the group `above` of any HDF5 file. `path` is used in error
/// messages.
void write_figures(io::Hdf5File& file, const std::string& above, const std::deque<Figure>& figures);
void read_figures(const io::Hdf5File& file, const std::filesystem::path& path,
                  const std::string& above, std::deque<Figure>& figures);

/// Names of the files that write_results_folder() writes.
std::vector<std::string> files_of_results();

/// Writes every file under a temporary name and renames it; report.html is last.
void write_results_folder(const std::filesystem::path& folder, const Results& results);

/// Reads results.json and traces/ of a folder. Throws InputError.
Results read_results_folder(const std::filesystem::path& folder);

// Output folder of `palpate run` as a case, so that a gate can compare two runs of one scene.

/// Returns true if a folder contains a run and no results.json.
bool is_run_folder(const std::filesystem::path& folder);

/// Reads a run as one outcome named "run". Quantities: energies, and the times of events and of new
/// layers. Compared texts: sizes, integrator, kernel, warnings, and the keys and input files of the
/// scene. Figures over time: every trace column and the displacement of every node. A run that
/// diverged or was interrupted has the status error. Throws InputError.
Results read_run_folder(const std::filesystem::path& folder);

/// Largest values of a run with a tool.
struct Peaks {
  double force = 0.0;                ///< [N]
  double force_depth = 0.0;          ///< insertion at the largest force [m]
  double deepest = 0.0;              ///< [m]
  std::optional<double> pressure{};  ///< [Pa], with a syringe
};

/// Returns those of a trace; empty without a tool.
std::optional<Peaks> peaks_of(const Trace& trace);

/// Returns what trace.h5 tells of the input of a run, as far as it is there: "scene" (text),
/// "overrides" (one a line), "scene_file" and "script" (paths), "no_skip" ("yes"), "every" (s
/// between rows), "inputs": the other input files, "NAME SHA-256" in each line, with the name
/// --script for the script, and "simulator_files": likewise, of another simulator, with whole
/// paths. Throws InputError.
std::map<std::string, std::string> inputs_of_run(const std::filesystem::path& folder);

/// Returns the files among these inputs of a run, each with its SHA-256: scene, files that it
/// names, script, and files of another simulator.
std::vector<std::pair<std::filesystem::path, std::string>> files_of_run(
    const std::map<std::string, std::string>& inputs);

/// Returns the first of these files that is gone or has another SHA-256; empty if none has.
std::string changed_file(const std::vector<std::pair<std::filesystem::path, std::string>>& files);

// Baseline on disk (docs/gate.md). Numbers, spreads and the ledger are readable JSON. The samples
// of curves are in an HDF5 file beside it whose name contains its own hash: NAME.HASH.h5.

/// Writes a baseline: the curves under their own name, then the JSON by a rename, then removes the
/// curves that it replaces (Baseline::curves). A failure leaves the old baseline whole. The caller
/// must hold a lock from reading the old baseline on, if others may write it. Throws InputError.
void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline);

/// Reads a baseline. Throws InputError if either file is missing, damaged or edited by hand, if the
/// files do not match, or if a number is not finite.
gate::Baseline read_baseline(const std::filesystem::path& path);

/// Damages baseline and results files in one way at a time. Returns each damage with the resulting
/// error message; the message is empty if the damage was not detected. Works in its own temporary
/// folder. Throws InputError if the folder cannot be created.
std::vector<std::pair<std::string, std::string>> try_damaged_files();

}  // namespace palpate

// SPDX-License-Identifier: MIT
#include "reports/results_folder.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/figure_data.hpp"
#include "reports/html_report.hpp"
#include "reports/junit.hpp"
#include "reports/results_json.hpp"

namespace palpate {

void write_results_folder(const std::filesystem::path& folder, const Results& results) {
  const std::filesystem::path traces = folder / "traces";
  std::error_code problem;
  std::filesystem::create_directories(traces, problem);
  if (problem) {
    throw InputError(traces.string() + ": cannot be made; a folder that can be written");
  }
  for (const Outcome& outcome : results.outcomes) { write_figure_data(traces, outcome); }
  io::replace_file(folder / "results.json", to_json(results));
  io::replace_file(folder / "results.xml", to_junit(results));
  io::replace_file(folder / "report.html", to_html(results));
}

Results read_results_folder(const std::filesystem::path& folder) {
  constexpr std::size_t most_bytes = 1U << 30U;
  const std::filesystem::path file = folder / "results.json";
  Results results = results_from_json(io::read_text(file, most_bytes), file.string());
  for (Outcome& outcome : results.outcomes) { read_figure_data(folder / "traces", outcome); }
  return results;
}

}  // namespace palpate

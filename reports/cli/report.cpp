// SPDX-License-Identifier: MIT

#include <cstdio>

#include "fixtures/io/file_bytes.hpp"
#include "reports/cli/commands.hpp"
#include "reports/html/results_page.hpp"
#include "reports/results/results_folder.hpp"

namespace palpate::cli {
namespace {

struct ReportOptions : CommonOptions {
  std::filesystem::path results{};
};

int run_report(const ReportOptions& options) {
  const Results results = read_results_folder(options.results);
  const std::string page = to_html(results);
  const std::filesystem::path folder =
      options.out.empty() ? options.results : options.make_folder();
  io::replace_file(folder / "report.html", page);
  if (!options.quiet) { std::printf("%s\n", (folder / "report.html").string().c_str()); }
  return done;
}

}  // namespace

void add_report(Program& program) {
  const auto [command, options] =
      add_command(program, "report", "render report.html again from a results folder", run_report);
  add_value(command, "results", options.results, "RESULTS", "folder with results.json and traces/")
      ->required();
}

}  // namespace palpate::cli

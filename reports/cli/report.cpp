// SPDX-License-Identifier: MIT

#include <cstdio>

#include "fixtures/io/file_bytes.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/html/results_page.hpp"
#include "reports/results/results_folder.hpp"

namespace palpate::cli {

int report(const ReportOptions& options) {
  const Results results = read_results_folder(options.results);
  const std::string page = to_html(results);
  const std::filesystem::path folder =
      options.out.empty() ? options.results : make_folder(options.out);
  io::replace_file(folder / "report.html", page);
  if (!options.quiet) { std::printf("%s\n", (folder / "report.html").string().c_str()); }
  return done;
}

}  // namespace palpate::cli

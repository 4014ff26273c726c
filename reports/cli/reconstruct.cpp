// SPDX-License-Identifier: MIT

#include <cstdio>

#include "fixtures/io/recording_file.hpp"
#include "reports/cli/commands.hpp"
#include "reports/reconstructed_set.hpp"

namespace palpate::cli {
namespace {

struct ReconstructOptions : CommonOptions {
  std::filesystem::path table{};
};

int run_reconstruct(const ReconstructOptions& options) {
  const std::vector<Recording> recordings =
      reconstructed_recordings(io::read_published_values(options.table));
  const std::filesystem::path folder = options.make_folder();
  for (const Recording& recording : recordings) {
    io::write_recording_hdf5(folder / (recording.name + ".h5"), recording);
  }
  if (!options.quiet) {
    std::printf("%zu recordings, reconstructed from published summary values: %s\n",
                recordings.size(), folder.c_str());
  }
  return done;
}

}  // namespace

void add_reconstruct(Program& program) {
  const auto [command, options] =
      add_command(program, "reconstruct", "recordings rebuilt from a table of published values",
                  run_reconstruct);
  add_value(command, "table", options.table, "TABLE",
            "fixtures/clinical/published_values.csv, or one like it")
      ->required();
  command.footer(
      "Writes one .h5 per recording into DIR. They are no measurements, and each says so\n"
      "(fixtures/recordings/README.md).");
}

}  // namespace palpate::cli

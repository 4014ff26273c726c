// SPDX-License-Identifier: MIT

#include <cstdio>

#include "fixtures/io/recording_file.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/reconstructed_set.hpp"

namespace palpate::cli {

int reconstruct(const ReconstructOptions& options) {
  const std::vector<Recording> recordings =
      reconstructed_recordings(io::read_published_values(options.table));
  const std::filesystem::path folder = make_folder(options.folder("reconstruct"));
  for (const Recording& recording : recordings) {
    io::write_recording_hdf5(folder / (recording.name + ".h5"), recording);
  }
  if (!options.quiet) {
    std::printf("%zu recordings, reconstructed from published summary values: %s\n",
                recordings.size(), folder.c_str());
  }
  return done;
}

}  // namespace palpate::cli

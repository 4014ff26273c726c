// SPDX-License-Identifier: MIT
#include "reports/cli/scene_run.hpp"

#include <cstdio>
#include <unistd.h>

#include "reports/cli/interrupt.hpp"
#include "reports/cli/provenance.hpp"

namespace palpate::cli {

RollOutOptions roll_out_options(const LoadedScene& loaded, bool quiet) {
  RollOutOptions options{.frames = loaded.file.scene.output.frames, .stop = &interrupted};
  if (!quiet && isatty(STDERR_FILENO) != 0) {
    options.progress = [](double share) { std::fprintf(stderr, "\r%3.0f %%", 100.0 * share); };
  }
  return options;
}

std::map<std::string, std::string> scene_provenance(const LoadedScene& loaded) {
  std::map<std::string, std::string> provenance = build_provenance();
  provenance["scene"] = loaded.file.text;
  std::string overrides;
  for (const std::string& each : loaded.file.overrides) { overrides += each + "\n"; }
  if (!overrides.empty()) { provenance["overrides"] = overrides; }
  return provenance;
}

}  // namespace palpate::cli

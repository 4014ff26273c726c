// SPDX-License-Identifier: MIT
#include "reports/cli/source_folder.hpp"

std::filesystem::path palpate::cli::source_folder() { return PALPATE_SOURCE_DIR; }

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace palpate::cli {

/// Where this program was built from: shipped scenes lie there, and data shared with other projects beside it.
std::filesystem::path source_folder();

}  // namespace palpate::cli

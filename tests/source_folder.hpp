// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace scratch {

/// The project's root, where shipped scenes and recordings lie.
std::filesystem::path source_folder();

}  // namespace scratch

// SPDX-License-Identifier: MIT
#pragma once
/// Baselines and results on disk, damaged one way at a time, to see that none is taken for sound.

#include <string>
#include <utility>
#include <vector>

namespace palpate {

/// What was done to the files, and the message that refused them; empty where they were taken. Works in a
/// temporary folder of its own. Throws InputError where that cannot be made.
std::vector<std::pair<std::string, std::string>> try_damaged_files();

}  // namespace palpate

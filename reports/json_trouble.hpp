// SPDX-License-Identifier: MIT
#pragma once
/// What is wrong with a JSON file, in words of the file rather than of the library that read it.

#include <exception>
#include <string>

#include "model/dynamics/scene_check.hpp"

namespace palpate {

/// "FILE:LINE: not JSON from here on; ALLOWED", or "FILE: WHAT; ALLOWED" when what is wrong has no place.
InputError json_trouble(const std::string& file, const std::string& text, const std::exception& problem,
                        const std::string& allowed);

}  // namespace palpate

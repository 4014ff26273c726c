// SPDX-License-Identifier: MIT
#pragma once
/// List of known failures of a simulator (docs/subjects.md, "Known failures").

#include <filesystem>
#include <string>
#include <vector>

#include "validation/case.hpp"

namespace palpate::cli {

struct ExpectedFailure {
  std::string of{};        ///< name of the case
  std::string quantity{};  ///< that fails; "error": the case ends with an error
  std::string reason{};
};

/// Reads [[failure]] with case, quantity and reason. Throws InputError, also for a case that is
/// not in the list.
std::vector<ExpectedFailure> read_expected(const std::filesystem::path& file,
                                           const std::vector<Case>& cases);

}  // namespace palpate::cli

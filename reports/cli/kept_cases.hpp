// SPDX-License-Identifier: MIT
#pragma once
/// Cases that need not run again: what they found is kept under everything that it depends on.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "validation/case.hpp"

namespace palpate::cli {

class KeptCases {
 public:
  /// `given`: what cases depend on beside the code, as text: options, data outside the project.
  KeptCases(const std::filesystem::path& cache, const std::string& given);

  /// Nothing where the case never ran so, where it did not pass, or where what was kept is damaged.
  [[nodiscard]] std::optional<Outcome> find(const Case& definition) const;
  /// Takes those out of a list that need not run again, and gives what they found, by name.
  [[nodiscard]] std::map<std::string, Outcome> take(std::vector<Case>& cases) const;
  /// Cases that passed. A disk that is full or read-only is no error.
  void keep(const Outcome& outcome) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(const std::string& name) const;

  std::filesystem::path folder_;
};

/// Object code, processor, and the shared libraries that are loaded, with their sizes and times.
std::string what_runs();

/// Names, sizes and times of the files below folders.
std::string what_lies_in(const std::vector<std::filesystem::path>& folders);

}  // namespace palpate::cli

// SPDX-License-Identifier: MIT
#pragma once
/// Pairs of two builds over several starts of a process, and where the builds come from.

#include <atomic>
#include <filesystem>

#include "validation/bench/paired_cases.hpp"

namespace palpate::timing {

struct PairedRuns {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scenes{};  ///< folder of NAME.toml
  int starts = 12;                 ///< at a time; an even number: either library is loaded first as often
  int pairs = 40;                  ///< in each
  const std::atomic<bool>* stop = nullptr;
};

/// Each start is `palpate steps --library BASE --beside HEAD`; instructions are counted once for each library and
/// scene.
bench::PairedMeasurement measurement_of(const PairedRuns& runs);

/// The step library of the build that runs. Throws InputError when it does not lie beside the program.
std::filesystem::path own_library();

/// That of a revision of `source`, built by scripts/build-base unless `cache` holds it; or the file itself where one
/// of that name exists. Throws InputError with the script's words.
std::filesystem::path library_of(const std::string& revision, const std::filesystem::path& source,
                                 const std::filesystem::path& cache, const std::atomic<bool>* stop);

}  // namespace palpate::timing

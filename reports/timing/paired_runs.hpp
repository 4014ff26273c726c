// SPDX-License-Identifier: MIT
#pragma once
/// Paired timing of two step libraries (step_library.h), and the location of such libraries.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "reports/timing/step_library.h"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::timing {

/// Step library that is loaded at run time, with its own copy of all code and data.
class LoadedLibrary {
 public:
  using Steps = std::unique_ptr<palpate_steps, decltype(palpate_steps_destroy)*>;

  /// Loads a library. A file that is loaded twice gives one shared library; copy the file first.
  /// Throws InputError if the file is not a step library.
  explicit LoadedLibrary(const std::filesystem::path& file);

  /// Creates the simulation of a scene, which must not outlive the library. Throws InputError with
  /// the library's message if the library rejects the scene.
  [[nodiscard]] Steps create(const std::filesystem::path& scene) const;

  // Functions of the library.
  decltype(palpate_steps_create)* make = nullptr;
  decltype(palpate_steps_run)* run = nullptr;
  decltype(palpate_steps_digest)* digest = nullptr;
  decltype(palpate_steps_kernel)* kernel = nullptr;
  decltype(palpate_steps_tick_count)* tick_count = nullptr;
  decltype(palpate_steps_tick_length)* tick_length = nullptr;
  decltype(palpate_steps_destroy)* destroy = nullptr;

 private:
  std::string name_;
  std::unique_ptr<void, int (*)(void*)> handle_;
};

struct PairedPlan {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scene{};
  int pairs = 40;
  std::uint64_t seed = 1;   ///< seed of the order within pairs
  bool head_first = false;  ///< if true, the head library is loaded and set up first
  bool planted = false;     ///< the head computes 5 % more ticks: a slowdown to be detected
};

/// Ticks per batch are a multiple of this number, so that 5 % of them is a whole number.
inline constexpr long planted_every = 20;

struct PairedReport {
  PairedStart start{};
  bool same_motion = false;  ///< true if both final states are equal to the last bit
};

/// Times pairs of batches of at least 0.5 ms. When a scene ends, both scenes restart outside the
/// timed section. Throws InputError for a scene of fewer than 20 ticks, and every exception of
/// LoadedLibrary.
PairedReport time_pairs(const PairedPlan& plan);

/// Writes the report as text, one number per line, without loss of precision.
std::string to_text(const PairedReport& report);
/// Parses the text of to_text(). Throws InputError for any other text.
PairedReport paired_report_from(const std::string& text);

struct PairedRuns {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scenes{};  ///< folder of the files NAME.toml
  int starts =
      12;  ///< process starts per call; even, so that each library is loaded first equally often
  int pairs = 40;  ///< pairs per start
  const std::atomic<bool>* stop = nullptr;
};

/// Returns a measurement that runs `palpate steps --library BASE --beside HEAD` once per start.
/// Instructions are counted once per library and scene.
bench::PairedMeasurement measurement_of(const PairedRuns& runs);

/// Path of the step library of the running build. Throws InputError if it is not in the folder of
/// the program.
std::filesystem::path own_library();

/// Returns the step library of a revision of `source`. It is built by scripts/build-base unless
/// `cache` contains it. If a file named `revision` exists, it is used. Throws InputError with the
/// script's message.
std::filesystem::path library_of(const std::string& revision, const std::filesystem::path& source,
                                 const std::filesystem::path& cache, const std::atomic<bool>* stop);

}  // namespace palpate::timing

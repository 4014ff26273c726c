// SPDX-License-Identifier: MIT
#pragma once
/// Step library (step_library.h) that is loaded at run time, with its own copy of all code and
/// data.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "reports/timing/step_library.h"
#include "validation/bench/paired_cases.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::timing {

/// Simulation of one scene by the code of one library. The library must outlive it.
class LibrarySteps;

class LoadedLibrary {
 public:
  /// Loads a library. A file that is loaded twice gives one shared library; copy the file first.
  /// Throws InputError if the file is not a step library.
  explicit LoadedLibrary(const std::filesystem::path& file);
  ~LoadedLibrary();
  LoadedLibrary(const LoadedLibrary&) = delete;
  LoadedLibrary& operator=(const LoadedLibrary&) = delete;

  /// Creates the simulation of a scene. Throws InputError with the library's message if the library
  /// rejects the scene.
  [[nodiscard]] LibrarySteps create(const std::filesystem::path& scene) const;

 private:
  friend class LibrarySteps;
  template <class Function> void find(Function*& function, const char* name);

  std::string name_;
  void* handle_ = nullptr;
  decltype(palpate_steps_create)* create_ = nullptr;
  decltype(palpate_steps_run)* run_ = nullptr;
  decltype(palpate_steps_digest)* digest_ = nullptr;
  decltype(palpate_steps_kernel)* kernel_ = nullptr;
  decltype(palpate_steps_tick_count)* tick_count_ = nullptr;
  decltype(palpate_steps_tick_length)* tick_length_ = nullptr;
  decltype(palpate_steps_destroy)* destroy_ = nullptr;
};

class LibrarySteps {
 public:
  LibrarySteps(const LoadedLibrary& library, palpate_steps* steps)
      : library_(&library), steps_(steps, library.destroy_) {}
  void run(long ticks) { (void)library_->run_(steps_.get(), ticks); }
  [[nodiscard]] std::string digest() {
    char text[33] = {};
    library_->digest_(steps_.get(), text);
    return text;
  }
  [[nodiscard]] std::string kernel() const { return library_->kernel_(steps_.get()); }
  [[nodiscard]] long tick_count() const { return library_->tick_count_(steps_.get()); }
  [[nodiscard]] double tick_length() const {
    return library_->tick_length_(steps_.get());
  }  ///< tick length [s]

 private:
  const LoadedLibrary* library_;
  std::unique_ptr<palpate_steps, decltype(palpate_steps_destroy)*> steps_;
};

// Paired timing of two step libraries in one process, and the text format of its result.

struct PairedPlan {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scene{};
  int pairs = 40;
  std::uint64_t seed = 1;   ///< seed of the order within pairs
  bool head_first = false;  ///< if true, the head library is loaded and set up first
  bool planted =
      false;  ///< if true, the head computes 5 % more ticks: a slowdown that must be detected
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

// Paired timing of two builds over several process starts, and the location of their libraries.

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

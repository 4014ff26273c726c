// SPDX-License-Identifier: MIT
#pragma once
/// A step library (step_library.h) that was loaded at run time, with its own copy of everything.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "reports/timing/step_library.h"
#include "validation/bench/paired_cases.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::timing {

/// A scene in motion by the code of one library; the library outlives it.
class LibrarySteps;

class LoadedLibrary {
 public:
  /// The same file loaded twice is one library: copy it. Throws InputError when it is none.
  explicit LoadedLibrary(const std::filesystem::path& file);
  ~LoadedLibrary();
  LoadedLibrary(const LoadedLibrary&) = delete;
  LoadedLibrary& operator=(const LoadedLibrary&) = delete;

  /// Throws InputError with the library's words when it refuses the scene.
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
  }  ///< [s]

 private:
  const LoadedLibrary* library_;
  std::unique_ptr<palpate_steps, decltype(palpate_steps_destroy)*> steps_;
};

// Two step libraries in one process, timed in turn; and how its parent reads what it says.

struct PairedPlan {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scene{};
  int pairs = 40;
  std::uint64_t seed = 1;   ///< of the order within pairs
  bool head_first = false;  ///< is loaded, and set up
  bool planted = false;  ///< the head takes one tick more in twenty: a slowdown that must be seen
};

/// Ticks of a batch are a whole multiple, so that a twentieth of them is a whole number.
inline constexpr long planted_every = 20;

struct PairedReport {
  PairedStart start{};
  bool same_motion = false;  ///< to the last bit, after as many ticks
};

/// Batches of half a millisecond at least; both scenes begin anew, outside the times, where they
/// end. Throws InputError for a scene of fewer than 20 ticks, and what LoadedLibrary throws.
PairedReport time_pairs(const PairedPlan& plan);

/// One line for each number, exact.
std::string to_text(const PairedReport& report);
/// Throws InputError when it is not what to_text() wrote.
PairedReport paired_report_from(const std::string& text);

// Pairs of two builds over several starts of a process, and where the builds come from.

struct PairedRuns {
  std::filesystem::path base{};
  std::filesystem::path head{};
  std::filesystem::path scenes{};  ///< folder of NAME.toml
  int starts = 12;  ///< at a time; an even number: either library is loaded first as often
  int pairs = 40;   ///< in each
  const std::atomic<bool>* stop = nullptr;
};

/// Each start is `palpate steps --library BASE --beside HEAD`; instructions are counted once for
/// each library and scene.
bench::PairedMeasurement measurement_of(const PairedRuns& runs);

/// The step library of the build that runs. Throws InputError when it does not lie beside the
/// program.
std::filesystem::path own_library();

/// That of a revision of `source`, built by scripts/build-base unless `cache` holds it; or the file
/// itself where one of that name exists. Throws InputError with the script's words.
std::filesystem::path library_of(const std::string& revision, const std::filesystem::path& source,
                                 const std::filesystem::path& cache, const std::atomic<bool>* stop);

}  // namespace palpate::timing

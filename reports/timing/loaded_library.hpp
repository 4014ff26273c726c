// SPDX-License-Identifier: MIT
#pragma once
/// A step library (step_library.h) that was loaded at run time, with its own copy of everything.

#include <filesystem>
#include <memory>
#include <string>

#include "reports/timing/step_library.h"

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
  template <class Function>
  void find(Function*& function, const char* name);

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
  [[nodiscard]] double tick_length() const { return library_->tick_length_(steps_.get()); }  ///< [s]

 private:
  const LoadedLibrary* library_;
  std::unique_ptr<palpate_steps, decltype(palpate_steps_destroy)*> steps_;
};

}  // namespace palpate::timing

// SPDX-License-Identifier: MIT
#include "reports/timing/loaded_library.hpp"

#include <array>
#include <dlfcn.h>

#include "model/dynamics/scene_check.hpp"

namespace palpate::timing {

namespace {

constexpr int known_version = 1;

}  // namespace

template <class Function>
void LoadedLibrary::find(Function*& function, const char* name) {
  function = reinterpret_cast<Function*>(dlsym(handle_, name));
  if (function == nullptr) {
    throw InputError(name_ + ": has no " + name + "; a step library, as scripts/build-base makes it");
  }
}

LoadedLibrary::LoadedLibrary(const std::filesystem::path& file) : name_(file.string()) {
  const std::filesystem::path whole = std::filesystem::absolute(file);  // else it is searched for
  handle_ = dlopen(whole.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) { throw InputError(name_ + ": cannot be loaded: " + dlerror() + "; a step library"); }
  decltype(palpate_steps_version)* version = nullptr;
  find(version, "palpate_steps_version");
  if (version() != known_version) {
    throw InputError(name_ + ": version " + std::to_string(version()) + " of its functions; " +
                     std::to_string(known_version));
  }
  find(create_, "palpate_steps_create");
  find(run_, "palpate_steps_run");
  find(digest_, "palpate_steps_digest");
  find(kernel_, "palpate_steps_kernel");
  find(tick_count_, "palpate_steps_tick_count");
  find(tick_length_, "palpate_steps_tick_length");
  find(destroy_, "palpate_steps_destroy");
}

LoadedLibrary::~LoadedLibrary() {
  if (handle_ != nullptr) { dlclose(handle_); }
}

LibrarySteps LoadedLibrary::create(const std::filesystem::path& scene) const {
  std::array<char, 2048> problem{};
  palpate_steps* steps = create_(scene.c_str(), problem.data(), problem.size());
  if (steps == nullptr) { throw InputError(name_ + " refuses " + problem.data()); }
  return {*this, steps};
}

}  // namespace palpate::timing

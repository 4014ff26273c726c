// SPDX-License-Identifier: MIT

#include "reports/cli/commands.hpp"

#include <csignal>

#include "model/stepping/integrator.hpp"

namespace palpate::cli {

std::atomic<bool> interrupted{false};

void catch_interrupts() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  const auto note = [](int signal) {
    interrupted.store(true);
    std::signal(signal, SIG_DFL);  // a second signal ends the program at once
  };
  std::signal(SIGINT, note);
  std::signal(SIGTERM, note);
}

void add_common(CLI::App& command, CommonOptions& options, const std::string& name) {
  command.add_option("--out", options.out, "output folder [palpate-out/" + name + "]")
      ->type_name("DIR");
  command.add_flag("--quiet", options.quiet, "print errors only");
}

void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file) {
  command
      .add_option("--set", options.overrides,
                  file + " key to override, value in TOML syntax; repeatable")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
}

void add_scene(CLI::App& command, CommonOptions& options, std::filesystem::path& scene) {
  command.add_option("scene", scene, "scene file (TOML, docs/scenes.md)")
      ->required()
      ->type_name("SCENE");
  add_overrides(command, options, "scene");
}

std::string integrator_help() {
  std::string text = "Integrators:\n";
  for (const IntegratorInfo* info : integrators()) {
    std::string name(info->name);
    name.resize(26, ' ');
    text += "  " + name + std::string(info->summary) + "\n";
  }
  return text +
         "  auto                      chosen for the scene; `palpate inspect` shows which and "
         "why\n";
}

}  // namespace palpate::cli

// SPDX-License-Identifier: MIT
#include "reports/cli/kept_cases.hpp"

#include <algorithm>
#include <cstdlib>
#include <link.h>

#include "palpate_code_hash.hpp"

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/figure_data.hpp"
#include "reports/results_json.hpp"

namespace palpate::cli {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_bytes = 1U << 28U;

std::string file_facts(const fs::path& file) {
  std::error_code problem;
  const auto size = fs::file_size(file, problem);
  const auto time = fs::last_write_time(file, problem).time_since_epoch().count();
  return file.string() + " " + std::to_string(size) + " " + std::to_string(time) + "\n";
}

int add_library(dl_phdr_info* info, std::size_t, void* list) {
  if (info->dlpi_name != nullptr && *info->dlpi_name == '/') {
    static_cast<std::vector<std::string>*>(list)->emplace_back(info->dlpi_name);
  }
  return 0;
}

}  // namespace

KeptCases::KeptCases(const fs::path& cache, const std::string& given)
    : folder_(cache / "cases" / io::content_hash(what_runs() + given)) {}

fs::path KeptCases::file_of(const std::string& name) const {
  return folder_ / (fs::path(trace_file_name(name)).replace_extension(".json"));
}

std::optional<Outcome> KeptCases::find(const Case& definition) const {
  const fs::path file = file_of(definition.name);
  if (!definition.keeps || !fs::exists(file)) { return std::nullopt; }
  try {
    Results kept = results_from_json(io::read_text(file, most_bytes), file.string());
    Outcome& outcome = kept.outcomes.at(0);
    read_figure_data(folder_, outcome);
    const bool same = outcome.name == definition.name && outcome.status == Status::pass;
    return same ? std::optional(std::move(outcome)) : std::nullopt;
  } catch (const std::exception&) { return std::nullopt; }  // damaged: as if it had never run
}

void KeptCases::keep(const Outcome& outcome) const {
  if (outcome.status != Status::pass) { return; }
  try {
    fs::create_directories(folder_);
    write_figure_data(folder_, outcome);
    io::replace_file(file_of(outcome.name), to_json(Results{.title = "kept", .outcomes = {outcome}}));
  } catch (const std::exception&) {}  // it will run again
}

std::map<std::string, Outcome> KeptCases::take(std::vector<Case>& cases) const {
  std::map<std::string, Outcome> taken;
  for (const Case& one : cases) {
    if (auto outcome = find(one)) { taken.emplace(one.name, std::move(*outcome)); }
  }
  std::erase_if(cases, [&](const Case& one) { return taken.contains(one.name); });
  return taken;
}

std::string what_runs() {
  std::vector<std::string> libraries;
  dl_iterate_phdr(add_library, &libraries);
  std::ranges::sort(libraries);
  std::string text = std::string(build::code_hash) + "\n" + build_provenance().at("processor") + "\n";
  for (const char* choice : {"GLIBC_TUNABLES", "PALPATE_INSTRUCTIONS"}) {  // of functions of the C library, and of kernels
    const char* value = std::getenv(choice);
    text += std::string(value != nullptr ? value : "") + "\n";
  }
  for (const std::string& library : libraries) { text += file_facts(library); }
  return text;
}

std::string what_lies_in(const std::vector<fs::path>& folders) {
  std::vector<std::string> files;
  for (const fs::path& folder : folders) {
    std::error_code problem;
    for (fs::recursive_directory_iterator at(folder, problem), end; !problem && at != end; at.increment(problem)) {
      if (at->is_regular_file(problem)) { files.push_back(file_facts(at->path())); }
    }
  }
  std::ranges::sort(files);
  std::string text;
  for (const std::string& file : files) { text += file; }
  return text;
}

}  // namespace palpate::cli

// SPDX-License-Identifier: MIT
/// The command `init`: a first scene, or the skeleton of a simulator.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "init_templates.hpp"

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace palpate::cli {
namespace {

namespace fs = std::filesystem;

struct InitOptions : CommonOptions {
  std::string kind = "needle";
};

struct Kind {
  std::string_view name;
  std::vector<TemplateFile> files;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{{"needle", {{"scene.toml", init::needle}}},
                                     {"palpation", {{"scene.toml", init::palpation}}},
                                     {"mri", {{"scene.toml", init::mri}}},
                                     {"mesh",
                                      {{"scene.toml", init::mesh},
                                       {"vertebrae.obj", init::vertebrae},
                                       {"ligament.obj", init::ligament},
                                       {"flavum.obj", init::flavum}}},
                                     {"subject", {}}};
  return all;
}

/// Single-file NIfTI-1 image of 8-bit pixels of 1 mm: fat, muscle and ligament along z.
std::string synthetic_image() {
  constexpr std::array<std::int16_t, 8> dimensions{3, 31, 31, 40, 1, 1, 1, 1};
  constexpr std::array<float, 8> pixel{1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F};
  constexpr std::size_t header_bytes = 348;
  constexpr std::size_t data_offset = 352;
  std::string file(data_offset, '\0');
  // Offsets of the fields in the NIfTI-1 header.
  const auto put = [&file](std::size_t offset, const auto& value) {
    std::memcpy(file.data() + offset, &value, sizeof(value));
  };
  put(0, static_cast<std::int32_t>(header_bytes));
  put(40, dimensions);
  put(70, std::int16_t{2});  // unsigned char
  put(72, std::int16_t{8});  // bits of a pixel
  put(76, pixel);
  put(108, static_cast<float>(data_offset));
  put(112, 1.0F);                                   // slope of the intensities
  put(123, static_cast<char>(2));                   // millimetres
  put(344, std::array<char, 4>{'n', '+', '1', 0});  // one file
  constexpr char fat = static_cast<char>(230);
  constexpr char muscle = 110;
  constexpr char ligament = 25;
  for (int z = 0; z < dimensions[3]; ++z) {
    const char brightness = z < 8 ? fat : z < 26 ? muscle : ligament;
    file.append(static_cast<std::size_t>(dimensions[1]) * static_cast<std::size_t>(dimensions[2]),
                brightness);
  }
  return file;
}

int run_init(const InitOptions& options) {
  const auto kind = std::ranges::find(kinds(), options.kind, &Kind::name);
  if (kind == kinds().end()) {
    std::vector<std::string_view> names;
    for (const Kind& each : kinds()) { names.push_back(each.name); }
    const std::string_view nearest = io::nearest_word(options.kind, names);
    throw InputError("init " + options.kind + ": unknown kind; " +
                     (nearest.empty() ? "" : "did you mean " + std::string(nearest) + "? ") +
                     "needle, palpation, mri, mesh or subject");
  }
  fs::path folder = options.out.empty() ? options.output_folder() / options.kind : options.out;
  if (folder.string().starts_with("-")) { folder = "." / folder; }  // no option of the next command
  std::string next;
  if (kind->files.empty()) {
    next = write_subject_skeleton("c", folder);
  } else {
    std::vector<TemplateFile> files = kind->files;
    const std::string image = synthetic_image();
    if (kind->name == "mri") { files.push_back({"image.nii", image}); }
    write_new_folder(folder, files);
    next = "palpate run " + in_shell_quotes((folder / "scene.toml").string());
  }
  if (!options.quiet) {
    std::printf("%s: written. Next:\n", io::printable(folder.string()).c_str());
  }
  std::printf("%s\n", io::printable(next).c_str());
  return done;
}

}  // namespace

void write_new_folder(const fs::path& folder, const std::vector<TemplateFile>& files) {
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder))) {
    throw InputError(folder.string() +
                     ": exists and is not an empty folder; a new folder is needed");
  }
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem) { throw InputError(folder.string() + ": " + problem.message()); }
  const io::WholeWrite whole;
  for (const TemplateFile& file : files) { io::replace_file(folder / file.name, file.text); }
}

void add_init(Program& program) {
  const auto [command, options] =
      add_command(program, "init",
                  "write a first scene with comments, or the skeleton of a simulator", run_init);
  add_value(command, "kind", options.kind, "KIND",
            "needle, palpation, mri, mesh or subject [needle]");
  command.footer(
      "Writes scene.toml and the files that it needs, and prints the next command.\n"
      "A folder that is not empty is refused. Default of --out: palpate-out/init/KIND.");
}

}  // namespace palpate::cli

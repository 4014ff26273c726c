// SPDX-License-Identifier: MIT
// Fuzz test of all readers of files. A reader returns, or throws InputError with a message; nothing
// else is allowed. Built twice: with a main() that replays stored inputs (corpus/READER/*), and for
// libFuzzer (PALPATE_FUZZ), where the environment variable PALPATE_READER selects the reader.

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <string_view>

#include "fixtures/io/csv_tables.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/image_file.hpp"
#include "fixtures/io/mesh_file.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/recording_file.hpp"
#include "fixtures/io/scene_file.hpp"
#include "fixtures/io/trace_file.hpp"
#include "reports/recording_input.hpp"
#include "reports/recording_preset.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/history.hpp"

namespace {

using namespace palpate;
namespace fs = std::filesystem;

[[noreturn]] void broken(const char* what) {
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

const fs::path& folder() {
  static const io::ScratchFolder scratch;
  return scratch.path();
}

fs::path file_with(std::string_view bytes, const std::string& name) {
  const fs::path path = folder() / name;
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return path;
}

/// Removes the text up to the next zero byte from the front and returns it.
std::string_view next_part(std::string_view& bytes) {
  const std::size_t end = std::min(bytes.find('\0'), bytes.size());
  const std::string_view part = bytes.substr(0, end);
  bytes.remove_prefix(std::min(end + 1, bytes.size()));
  return part;
}

/// Removes the first byte and returns it modulo `count`.
std::size_t choice(std::string_view& bytes, std::size_t count) {
  if (bytes.empty()) { return 0; }
  const auto first = static_cast<unsigned char>(bytes.front());
  bytes.remove_prefix(1);
  return first % count;
}

void read_network(std::string_view bytes) {
  const fs::path nodes = file_with(next_part(bytes), "nodes.csv");
  const fs::path springs = file_with(next_part(bytes), "springs.csv");
  io::NetworkPaths paths{.nodes = nodes, .springs = springs};
  if (!bytes.empty()) { paths.initial = file_with(bytes, "initial.csv"); }
  io::Problems problems;
  (void)io::read_network_csv(paths, problems);
  problems.throw_if_any();
}

void read_poses(std::string_view bytes) {
  io::Problems problems;
  const auto any = [](const Eigen::Vector3d&) { return std::string_view(); };
  (void)io::read_pose_csv(file_with(bytes, "poses.csv"), any, problems);
  problems.throw_if_any();
}

void read_override(std::string_view bytes) {
  static const fs::path scene = file_with(
      "[simulation]\nduration = 0.1\n[tissue]\nsource = \"lattice\"\n[tissue.lattice]\n"
      "nodes = [3, 3, 3]\nspacing = 0.005\nmaterial = \"fat\"\n",
      "plain.toml");
  (void)io::read_scene(scene, {std::string(bytes)});
}

void read_any_mesh(std::string_view bytes) {
  constexpr std::array<const char*, 3> names{"m.obj", "m.stl", "m.ply"};
  const std::size_t n = choice(bytes, names.size());
  (void)io::read_mesh(file_with(bytes, names[n]));
}

void read_any_nifti(std::string_view bytes) {
  constexpr std::array<const char*, 2> names{"i.nii", "i.nii.gz"};
  const std::size_t n = choice(bytes, names.size());
  (void)io::read_nifti(file_with(bytes, names[n]));
}

using Reader = std::function<void(std::string_view)>;

const std::map<std::string, Reader>& readers() {
  static const std::map<std::string, Reader> all{
      {"scene",
       [](std::string_view bytes) { (void)io::read_scene(file_with(bytes, "s.toml"), {}); }},
      {"override", read_override},
      {"results",
       [](std::string_view bytes) { (void)results_from_json(std::string(bytes), "results.json"); }},
      {"baseline", [](std::string_view bytes) { (void)read_baseline(file_with(bytes, "b.json")); }},
      {"history",
       [](std::string_view bytes) { (void)timing::read_history(file_with(bytes, "h.jsonl")); }},
      {"network", read_network},
      {"poses", read_poses},
      {"values",
       [](std::string_view bytes) { (void)io::read_published_values(file_with(bytes, "v.csv")); }},
      {"recording",  // CSV and raw link
       [](std::string_view bytes) { (void)read_any_recording(file_with(bytes, "r.csv")); }},
      {"trace", [](std::string_view bytes) { (void)io::read_trace(file_with(bytes, "t.csv")); }},
      {"hdf5",
       [](std::string_view bytes) {
         const fs::path file = file_with(bytes, "f.h5");
         try {
           (void)io::read_recording_hdf5(file);
         } catch (const InputError&) { (void)io::read_trace_hdf5(file); }
       }},
      {"mesh", read_any_mesh},
      {"nifti", read_any_nifti},
      {"dicom",
       [](std::string_view bytes) { (void)io::read_dicom_series({file_with(bytes, "d.dcm")}); }},
      {"png", [](std::string_view bytes) {
         (void)io::read_png_slices({file_with(bytes, "p.png")}, {1e-3, 1e-3, 1e-3});
       }}};
  return all;
}

void read(const Reader& reader, std::string_view bytes) {
  try {
    reader(bytes);
  } catch (const InputError& refusal) {
    if (*refusal.what() == '\0') { broken("a refusal without a message"); }
  } catch (const std::exception& other) { broken(other.what()); }
}

}  // namespace

#ifdef PALPATE_LIBFUZZER
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Reader& reader = [&]() -> const Reader& {
    const char* name = std::getenv("PALPATE_READER");
    const auto found = readers().find(name != nullptr ? name : "");
    if (found == readers().end()) { broken("PALPATE_READER names no reader"); }
    return found->second;
  }();
  read(reader, {reinterpret_cast<const char*>(data), size});
  return 0;
}
#else
int main(int argc, char** argv) {
  int count = 0;
  for (const auto& [name, reader] : readers()) {
    const fs::path inputs = fs::path(argc > 1 ? argv[1] : ".") / name;
    if (!fs::is_directory(inputs)) { broken("a reader without stored inputs"); }
    for (const auto& entry : fs::directory_iterator(inputs)) {
      std::printf("%s\n", entry.path().string().c_str());
      std::fflush(stdout);  // the last name is the one that broke
      std::ifstream file(entry.path(), std::ios::binary);
      read(reader, std::string{std::istreambuf_iterator<char>(file), {}});
      ++count;
    }
  }
  std::printf("%d inputs\n", count);
  return count > 0 ? 0 : 1;
}
#endif

// SPDX-License-Identifier: MIT
// Fuzz test of all readers of files. A reader returns, or throws InputError with a message; nothing
// else is allowed. Built twice: with a main() that replays stored inputs (corpus/READER/*), and for
// libFuzzer (PALPATE_FUZZ), where the environment variable PALPATE_READER selects the reader.

#include <algorithm>
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
#include <random>
#include <string>
#include <string_view>
#include <vector>

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
namespace {

struct Input {
  std::string name;
  std::string bytes;
};

std::vector<Input> stored_inputs(const fs::path& folder_of_reader) {
  if (!fs::is_directory(folder_of_reader)) { broken("a reader without stored inputs"); }
  std::vector<Input> inputs;
  for (const auto& entry : fs::directory_iterator(folder_of_reader)) {
    std::ifstream file(entry.path(), std::ios::binary);
    inputs.push_back({entry.path().string(), {std::istreambuf_iterator<char>(file), {}}});
  }
  std::ranges::sort(inputs, {}, &Input::name);
  return inputs;
}

/// Changes some bytes, removes or repeats a part, or appends a part of another input.
std::string mutated(std::string bytes, const std::string& other, std::mt19937_64& random) {
  const auto below = [&](std::size_t count) {
    return count == 0 ? std::size_t{0} : static_cast<std::size_t>(random() % count);
  };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes.size() + 1);
    const std::size_t size = std::min(below(64), bytes.size() - at);
    const std::string part = bytes.substr(at, size);
    constexpr std::string_view marks("\0\xff\x7f\x80-9.,;\"[]{}\n", 16);
    switch (below(6)) {
      case 0: bytes.erase(at, size); break;
      case 1: bytes.insert(at, part + part); break;
      case 2: bytes.insert(at, other.substr(below(other.size()), below(200))); break;
      case 3: bytes.insert(at, 1, marks[below(marks.size())]); break;
      default:
        if (at < bytes.size()) {
          bytes[at] = below(2) == 0 ? marks[below(marks.size())] : static_cast<char>(below(256));
        }
    }
  }
  return bytes;
}

}  // namespace

/// fuzz_readers CORPUS [MUTATIONS SEED [READER]]: replays the stored inputs, and that many
/// mutations of each reader's.
int main(int argc, char** argv) {
  const std::size_t mutations = argc > 2 ? std::stoul(argv[2]) : 0;
  std::mt19937_64 random(argc > 3 ? std::stoul(argv[3]) : 1);
  std::size_t count = 0;
  for (const auto& [name, reader] : readers()) {
    if (argc > 4 && name != argv[4]) { continue; }
    const std::vector<Input> inputs = stored_inputs(fs::path(argc > 1 ? argv[1] : ".") / name);
    for (const Input& input : inputs) {
      std::printf("%s\n", input.name.c_str());
      std::fflush(stdout);  // the last name is the one that broke
      read(reader, input.bytes);
    }
    for (std::size_t n = 0; n < mutations; ++n) {
      const std::string bytes = mutated(inputs[random() % inputs.size()].bytes,
                                        inputs[random() % inputs.size()].bytes, random);
      (void)file_with(bytes, "last");
      read(reader, bytes);
    }
    count += inputs.size() + mutations;
  }
  std::printf("%zu inputs\n", count);
  return count > 0 ? 0 : 1;
}
#endif

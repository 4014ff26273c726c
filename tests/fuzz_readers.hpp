// SPDX-License-Identifier: MIT
#pragma once
/// Fuzz test of readers of files. A reader returns, or throws InputError with a message; nothing
/// else is allowed. A source file that includes this one defines readers(). Built twice: with a
/// main() that replays stored inputs (corpus/READER/*) and mutations of them, and for libFuzzer
/// (PALPATE_FUZZ), where the environment variable PALPATE_READER selects the reader.

#include <algorithm>
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

#include "fixtures/io/file_bytes.hpp"

namespace {

using namespace palpate;
namespace fs = std::filesystem;

using Reader = std::function<void(std::string_view)>;
const std::map<std::string, Reader>& readers();

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

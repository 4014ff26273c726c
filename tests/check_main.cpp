// SPDX-License-Identifier: MIT

#include "tests/check.hpp"

std::filesystem::path scratch::source_folder() { return PALPATE_SOURCE_DIR; }

int main(int argc, char** argv) {
  std::string_view file;
  std::string_view name;
  for (int n = 1; n < argc; ++n) {
    const std::string_view argument = argv[n];
    if (argument == "--file" && n + 1 < argc) {
      file = argv[++n];
    } else {
      name = argument;
    }
  }
  return check::run(file, name);
}

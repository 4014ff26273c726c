// SPDX-License-Identifier: MIT
/// Prints a results.json without the data that may differ between two runs.

#include <cstdio>
#include <exception>

#include "fixtures/io/file_bytes.hpp"
#include "reports/results/results_json.hpp"

int main(int argc, char** argv) {
  try {
    const std::string text = palpate::io::read_text(argc > 1 ? argv[1] : "", 1U << 30U);
    const palpate::Results results = palpate::results_from_json(text, argv[1]);
    std::fputs(palpate::to_json(palpate::without_what_varies(results)).c_str(), stdout);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 2;
  }
  return 0;
}

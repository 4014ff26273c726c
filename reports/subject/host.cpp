// SPDX-License-Identifier: MIT
/// palpate-subject-host PATH.so: a shared library behind the pipe, in a process of its own.
/// Standard output of the library goes to standard error, so that it cannot damage the frames.

#include <cstdio>
#include <exception>
#include <unistd.h>

#include "reports/subject/connection.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "palpate-subject-host: one shared library is needed\n");
    return 2;
  }
  const int frames = dup(STDOUT_FILENO);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  try {
    return palpate::serve_library(palpate::open_library(argv[1]), STDIN_FILENO, frames);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}

// SPDX-License-Identifier: MIT
#pragma once
/// Any simulator behind palpate_subject.h as a Subject, and the values of --subject.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fixtures/io/scene_file.hpp"
#include "reports/subject/connection.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

/// Choice of the simulator under test on a command line.
struct SubjectChoice {
  std::string subject{};            ///< "", "model", PATH.so, exec:COMMAND or trace:FILE.csv
  std::string options_json = "{}";  ///< passed to load()
  bool in_process = false;          ///< a library runs in this process
  SubjectLimits limits{};
  std::vector<std::string> columns{};  ///< NAME=ROLE of a trace

  [[nodiscard]] bool foreign() const { return !subject.empty() && subject != "model"; }
};

/// Connects and creates a subject. `file` is the file of the scene that load() will receive;
/// nullptr if it is made in memory. Throws InputError and SubjectFailure.
std::unique_ptr<Subject> make_subject(const SubjectChoice& choice,
                                      std::shared_ptr<const io::SceneFile> file = nullptr);

}  // namespace palpate

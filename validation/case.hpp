// SPDX-License-Identifier: MIT
#pragma once
/// A case is one claim about the model and the code that measures it. all_cases() returns the
/// registry; `palpate validate` runs a selection of it.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/solution.hpp"
#include "validation/outcome.hpp"
#include "validation/roll_out.hpp"

namespace palpate {

/// Settings and services of a run of cases. No state is global, so tests can run cases with
/// different contexts.
struct CaseContext {
  bool quick = false;  ///< use the shorter form, which judges the same claims
  bool skip = true;    ///< false: also compute the parts that a scene does not need
  /// Seed of a random order of nodes and springs, which changes only rounding; 0: keep the order.
  /// Tissue with a tool keeps its order, because its layers are ranges of nodes.
  std::uint64_t order = 0;
  std::uint64_t seed = 0;  ///< of scenes that are drawn at run time; 0: another at every run
  /// Creates the simulator under test; empty: the model in this process.
  std::function<std::unique_ptr<Subject>()> subject{};
  [[nodiscard]] std::unique_ptr<Subject> make_subject() const {
    return subject ? subject() : std::make_unique<ModelSubject>();
  }
  /// Fault planted in the candidate, never in a reference; checks that a faulty candidate fails.
  const Mutation* mutation = nullptr;
  const reference::Cache* cache = nullptr;  ///< cache of slow reference solutions; nullptr: none
  /// Returns a network that is stored outside the project, by name; empty if it is not available.
  std::function<std::optional<SpringNetwork>(std::string_view)> outside_network{};
  /// Returns damaged gate files: the kind of damage, and the error message of the reader (empty:
  /// the file was accepted).
  std::function<std::vector<std::pair<std::string, std::string>>()> damaged_files{};
  /// Materials of the library; empty: the caller reads no files, which also holds for the next
  /// three.
  std::function<std::vector<Material>()> library{};
  /// Returns a shipped scene by name; empty if the program was installed without its scenes.
  std::function<std::optional<Scene>(std::string_view)> shipped_scene{};
  /// Writes a scene with its network as files and returns the network that they hold.
  std::function<SpringNetwork(const Scene&, const SpringNetwork&)> through_files{};
  /// Returns the network of "scene.toml" among files, by name.
  std::function<SpringNetwork(const std::map<std::string, std::string>&)> network_of_files{};
};

struct Case {
  std::string name{};   ///< "oscillator/order/leapfrog"
  std::string suite{};  ///< "accuracy", "stability", "haptics", "clinical", "timing", "model"
  std::string claim{};  ///< the sentence that is judged
  std::function<void(const CaseContext&, Outcome&)> measure{};
  double weight = 1.0;  ///< expected seconds: long cases start first
  bool quick = true;    ///< part of --quick
  bool keeps =
      true;  ///< the result can be reused until code, options or data change; false: always run
  bool any_subject = false;  ///< judges any simulator under test, not only the model
};

/// Returns all cases in the order of the groups.
std::vector<Case> all_cases();

/// Returns true if the case has that name or suite, or is in the group of that name.
bool is_named(const Case& one, const std::string& pattern);

/// Returns the cases whose name equals a pattern or begins with a pattern followed by '/'; all
/// cases without patterns. Throws InputError if a pattern matches no case or the selection is
/// empty.
std::vector<Case> select_cases(const std::vector<Case>& cases,
                               std::span<const std::string> patterns, bool quick);

/// Measures and judges one case. Exceptions become an outcome with status error.
Outcome run_case(const Case& definition, const CaseContext& context);

}  // namespace palpate

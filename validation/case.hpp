// SPDX-License-Identifier: MIT
#pragma once
/// A case is one claim about the model with the code that measures it. The registry is the sum of
/// the groups in cases/; `palpate validate` runs what is selected from it.

#include <cstdint>
#include <functional>
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

/// What a case may use besides the code: nothing here is global, so a test can give each its own.
struct CaseContext {
  bool quick = false;  ///< a shorter form that judges the same claims
  bool skip = true;    ///< false: compute what scenes do not need
  /// Not 0: nodes and springs of networks stand in an order of chance, which moves nothing but
  /// rounding. Tissue with a tool in it stays as it is: its layers are ranges of nodes.
  std::uint64_t order = 0;
  /// Makes the simulator under test; empty: the model in this process.
  std::function<std::unique_ptr<Subject>()> subject{};
  /// Damages the candidate (never a reference), to see that a verdict turns red.
  const Mutation* mutation = nullptr;
  const reference::Cache* cache = nullptr;  ///< of slow references; nullptr: none
  /// Networks that live outside the project, by name; empty when absent.
  std::function<std::optional<SpringNetwork>(std::string_view)> outside_network{};
  /// Files of a gate, each damaged in one way: what was done, and the message that refused it
  /// (empty: none did).
  std::function<std::vector<std::pair<std::string, std::string>>()> damaged_files{};
};

struct Case {
  std::string name{};   ///< "oscillator/order/leapfrog"
  std::string suite{};  ///< "accuracy", "stability", "haptics", "clinical", "timing", "model"
  std::string claim{};  ///< the sentence that is judged
  std::function<void(const CaseContext&, Outcome&)> measure{};
  bool quick = true;    ///< part of --quick
  double weight = 1.0;  ///< expected seconds: long cases start first
  bool keeps =
      true;  ///< what it found holds until code, options or data change; false: it always runs
};

/// Every case, in the order of the groups.
std::vector<Case> all_cases();

/// Those whose name equals a pattern, or begins with one followed by '/'; all when there is none.
/// Throws InputError when a pattern matches nothing or the selection is empty.
std::vector<Case> select_cases(const std::vector<Case>& cases,
                               std::span<const std::string> patterns, bool quick);

/// Measures and judges one case. What it throws becomes an error outcome, never a crash.
Outcome run_case(const Case& definition, const CaseContext& context);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// From what was measured to a word and a sentence.

#include <string>
#include <string_view>
#include <vector>

#include "validation/certificate/certificate.hpp"

namespace palpate::certificate {

enum class Verdict { certified, not_certified, not_qualified };

/// "certified", "not certified", "environment not qualified".
std::string_view name_of(Verdict verdict);

struct Judgement {
  Verdict verdict = Verdict::not_qualified;
  std::string reason{};  ///< one sentence
};

/// A scene that diverges is not certified anywhere. Otherwise the environment comes first: without the right
/// scheduling and locked memory, or where the empty loop alone missed, nothing is said against the scene. It
/// is certified where no tick missed under any load and no provoked tick takes longer than the deadline.
Judgement judge(const Certificate& certificate);

/// Who may have stolen the time of a loop that missed, as the counters tell; empty where they tell nothing.
std::string suspects(const Phase& phase);

/// What the computation alone says, whatever the environment: the costliest tick against the deadline.
std::string budget_words(const Certificate& certificate);

}  // namespace palpate::certificate

// SPDX-License-Identifier: MIT
#pragma once
/// One thing that a gate looked at, and what it thinks of it.

#include <string>
#include <string_view>

namespace palpate::gate {

enum class Judgement {
  same,      ///< to the last bit
  rounding,  ///< differs by no more than rounding was seen to
  within,    ///< differs by less than is allowed
  better,    ///< an error shrank, or a cost
  worse,     ///< an error grew, or a cost
  moved,     ///< by more than is allowed; whether for the better cannot be told
  broken     ///< cannot be compared: missing, not finite, of another unit, judged by another bound
};
std::string_view name_of(Judgement judgement);

struct Change {
  std::string item{};  ///< name of a quantity or a curve; empty: the case itself
  Judgement judgement = Judgement::same;
  double before = 0.0;
  double now = 0.0;
  std::string unit{};
  std::string moved{};    ///< "0.31 digits worse", or what is broken
  std::string allowed{};  ///< "0.1 digits"

  [[nodiscard]] bool falls() const {
    return judgement == Judgement::worse || judgement == Judgement::moved || judgement == Judgement::broken;
  }
};

}  // namespace palpate::gate

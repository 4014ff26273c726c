// SPDX-License-Identifier: MIT
#pragma once
/// Whether and where a pressure shows the loss of resistance, by the published rule: a drop that is held
/// for more than 5 s with a stable low plateau (Vaira et al. 2019; J Clin Monit Comput 2022;36:283).

#include <string>
#include <string_view>

#include "validation/comparison/samples.hpp"

namespace palpate::comparison {

/// Drops are relative to the pressure above zero gauge at the peak before them.
struct LossRule {
  /// Published means are 0.73 for true and 0.33 for false ones, the rule of thumb is 0.5, and 6 of 60 true
  /// ones stayed under it; 0.4 lies above the false mean and lets a true one of 0.45 pass.
  double least_drop = 0.40;
  double hold = 5.0;          ///< [s] under the level (1 - least_drop) peak, published
  double settle = 1.0;        ///< [s] after the fall until the plateau is measured
  double longest_fall = 2.0;  ///< [s] from the peak to that level; a leak is slower (assumed)
  double unsteady = 0.20;     ///< of the peak, largest 5-95 % range of the plateau (assumed)
  double least_peak = 0.50;   ///< of the largest pressure: flushing a needle is no insertion (assumed)
};

struct LossOfResistance {
  /// Undecided: the trace ends before `hold`, or a gap hides whether, or how fast, the pressure fell.
  enum class Status { found, not_found, undecided };
  Status status = Status::not_found;
  std::string reason{};          ///< why it was not found
  bool weak = false;             ///< found, but dropped by less than half
  std::size_t peak_index = 0;    ///< the largest pressure within `longest_fall` before the fall
  std::size_t fallen_index = 0;  ///< the first sample under (1 - least_drop) peak
  double peak = not_measured;
  double plateau = not_measured;        ///< median from `settle` to `hold` after the fall, or to the end
  std::size_t plateau_samples = 0;      ///< from which that is
  double relative_drop = not_measured;  ///< 1 - plateau / peak

  [[nodiscard]] bool found() const { return status == Status::found; }
  /// A fall that can be measured: found, or held as far as the trace tells.
  [[nodiscard]] bool fell() const { return status != Status::not_found && plateau_samples > 0; }
};
std::string_view name_of(LossOfResistance::Status status);

/// In a filtered trace. The first fall that holds decides.
LossOfResistance find_loss(const Samples& pressure, const LossRule& rule = {});

}  // namespace palpate::comparison

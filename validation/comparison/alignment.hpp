// SPDX-License-Identifier: MIT
#pragma once
/// How the clocks of a recording and a simulation are laid over each other.

#include <string>
#include <string_view>

#include "validation/comparison/prepared_trace.hpp"

namespace palpate::comparison {

enum class AlignmentRule {
  automatic,  ///< depth where both have it without a gap there, else the event in both, else the start
  depth,      ///< both reach the depth of the recorded event (else the middle of the common depths) at once
  event,      ///< loss of resistance where both show one, else the peak
  start,      ///< the first samples coincide
};
std::string_view name_of(AlignmentRule rule);

struct Alignment {
  AlignmentRule used = AlignmentRule::start;  ///< never automatic
  std::string how{};         ///< "by the loss of resistance", for people
  double lag = 0.0;          ///< [s] recorded time - simulated time of one instant; always reported
  double uncertainty = 0.0;  ///< [s] standard
  std::string not_by_depth{};  ///< why another rule was used though both have depth; part of `how` as well
  std::string refusal{};     ///< why the rule that was asked for cannot be followed
  /// Whether instants say anything: aligned by the event they are the same by themselves, and aligned by
  /// depth the depth of the event tells, as hands move at speeds of their own.
  [[nodiscard]] bool judges_times() const { return used == AlignmentRule::start; }
};

/// Both with features; a lag is never searched for a better fit.
Alignment align(const PreparedTrace& recorded, const PreparedTrace& simulated, AlignmentRule rule);

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// What the hand does over time, as straight pieces: its place [m] under a prescribed trajectory,
/// its force [N] otherwise (model/dynamics/tool.hpp, Drive). Written for the references alone.

#include <vector>

#include "model/dynamics/tool.hpp"

namespace palpate::reference {

struct HandPiece {
  double start = 0.0;  ///< [s]; the piece lasts until the next one starts
  double value = 0.0;  ///< at the start [m] or [N]
  double rate = 0.0;   ///< [m/s] or [N/s]

  [[nodiscard]] double at(double time) const { return value + rate * (time - start); }
};

/// Pieces from t = 0 to `end` at least, starts ascending, rates or values differing.
std::vector<HandPiece> hand_motion(const Drive& drive, double end);

}  // namespace palpate::reference

// SPDX-License-Identifier: MIT
#include "reference/hand_motion.hpp"

#include <algorithm>
#include <limits>

namespace palpate::reference {

namespace {

using Pieces = std::vector<HandPiece>;

/// A piece that begins where another one begins takes its place.
void add(Pieces& pieces, const HandPiece& piece) {
  if (!pieces.empty() && pieces.back().start >= piece.start) { pieces.pop_back(); }
  pieces.push_back(piece);
}

/// Adds the way in and returns when it ends.
double advance(const Drive& drive, double end, Pieces& pieces) {
  const double depth = drive.depth.value_or(std::numeric_limits<double>::infinity());
  const bool pauses = drive.technique == Drive::Technique::intermittent;
  double t = drive.start;
  double s = drive.from;
  for (int n = 1; t <= end; ++n) {
    const double goal = pauses ? drive.from + n * drive.advance : depth;
    const bool last = !(goal < depth - 1e-9 * drive.advance);
    add(pieces, {t, s, drive.speed});
    t += ((last ? depth : goal) - s) / drive.speed;
    if (last) { return t; }
    s = goal;
    add(pieces, {t, s, 0.0});
    t += drive.pause;
  }
  return std::numeric_limits<double>::infinity();
}

Pieces trajectory(const Drive& drive, double end) {
  Pieces pieces{{0.0, drive.from, 0.0}};
  const double there = advance(drive, end, pieces);
  if (there > end) { return pieces; }
  add(pieces, {there, *drive.depth, 0.0});
  if (drive.withdraw_speed <= 0.0) { return pieces; }
  const double turn = there + drive.hold;
  add(pieces, {turn, *drive.depth, -drive.withdraw_speed});
  add(pieces, {turn + (*drive.depth - drive.from) / drive.withdraw_speed, drive.from, 0.0});
  return pieces;
}

Pieces force(const Drive& drive, double end) {
  const double full = drive.start + drive.rise;
  const double turn = drive.withdraw_force > 0.0 ? full + drive.hold
                                                 : std::numeric_limits<double>::infinity();
  Pieces pieces{{0.0, 0.0, 0.0}};
  if (drive.rise > 0.0) { add(pieces, {drive.start, 0.0, drive.force / drive.rise}); }
  add(pieces, {full, drive.force, 0.0});
  if (drive.technique == Drive::Technique::intermittent) {
    const double last = std::min(end, turn);
    for (int n = 0; full + n * (drive.push + drive.pause) + drive.push < last; ++n) {
      const double off = full + n * (drive.push + drive.pause) + drive.push;
      add(pieces, {off, 0.0, 0.0});
      if (off + drive.pause < last) { add(pieces, {off + drive.pause, drive.force, 0.0}); }
    }
  }
  if (turn < std::numeric_limits<double>::infinity()) {
    add(pieces, {turn, -drive.withdraw_force, 0.0});
  }
  return pieces;
}

}  // namespace

std::vector<HandPiece> hand_motion(const Drive& drive, double end) {
  return drive.kind == Drive::Kind::trajectory ? trajectory(drive, end) : force(drive, end);
}

}  // namespace palpate::reference

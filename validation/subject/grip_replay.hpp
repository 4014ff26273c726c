// SPDX-License-Identifier: MIT
#pragma once
/// Hand's end of the coupling of a scene with `drive.kind = "recorded"`, tick by tick.

#include <cstddef>
#include <optional>

#include "model/problem/scene.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

class GripReplay {
 public:
  /// Does nothing for a scene without a recorded grip.
  explicit GripReplay(const Scene& scene)
      : step_(scene.simulation.step),
        grip_(scene.drive && scene.drive->kind == Drive::Kind::recorded ? scene.drive->grip
                                                                        : nullptr) {}

  /// Returns the input of the tick that ends at `time` [s]; times must not decrease. A row at that
  /// time is used as it is, so that a recording with a row for every tick is replayed to the bit.
  /// Between rows the input is interpolated; before the first and after the last row it rests.
  [[nodiscard]] std::optional<ToolInput> at(double time) noexcept {
    if (!grip_ || grip_->empty()) { return {}; }
    const std::vector<GripSample>& rows = *grip_;
    const double close = 1e-6 * step_;
    while (next_ < rows.size() && rows[next_].time <= time + close) { ++next_; }
    if (next_ == 0) { return ToolInput{rows.front().position, 0.0}; }
    const GripSample& a = rows[next_ - 1];
    if (a.time >= time - close) { return ToolInput{a.position, a.velocity}; }
    if (next_ == rows.size()) { return ToolInput{a.position, 0.0}; }
    const GripSample& b = rows[next_];
    const double share = (time - a.time) / (b.time - a.time);
    return ToolInput{a.position + share * (b.position - a.position),
                     a.velocity + share * (b.velocity - a.velocity)};
  }

 private:
  double step_;
  std::shared_ptr<const std::vector<GripSample>> grip_;
  std::size_t next_ = 0;  ///< first row after the last time
};

}  // namespace palpate

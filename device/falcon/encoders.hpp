// SPDX-License-Identifier: MIT
#pragma once
/// Encoders of the three motors: whole counts, 16 bits wide, at an arbitrary offset after power-on
/// until homing has found their index marks.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "device/falcon/geometry.hpp"

namespace palpate::device::falcon {

using Counts = std::array<std::int16_t, 3>;

enum class Rounding { nearest, floor };

/// The procedure is libnifalcon's users' (pull fully out, push in); that an index mark near count 0
/// is what ends it, and these two angles, are inferred from it.
struct EncoderOptions {
  Rounding rounding = Rounding::nearest;
  double arming_angle = 1.0471975511965976;  ///< theta1 beyond which a leg is armed [rad]; 60 deg
  int largest_offset = 2000;                 ///< of power-on [counts]
};

class Encoders {
 public:
  Encoders(const Geometry& geometry, const EncoderOptions& options, std::uint64_t seed);

  /// The arms are here now. Homing goes on only while `homing` holds at every call: a leg is armed
  /// beyond the arming angle, and homed when it then passes the index mark at count 0 on its way
  /// in. The mark itself becomes count 0, so the offset is gone at once and positions jump.
  void sample(const Eigen::Vector3d& theta1, bool homing) noexcept;
  /// As after homing.
  void home() noexcept;

  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  [[nodiscard]] const std::array<bool, 3>& homed() const noexcept { return homed_; }
  [[nodiscard]] bool all_homed() const noexcept { return homed_[0] && homed_[1] && homed_[2]; }

 private:
  Geometry geometry_;
  EncoderOptions options_;
  std::array<std::int64_t, 3> offset_{};
  std::array<bool, 3> armed_{};
  std::array<bool, 3> homed_{};
  Eigen::Vector3d before_{};
  bool sampled_ = false;
  Counts counts_{};
};

/// Whole counts from the index mark, before they wrap.
std::int64_t counts_of_angle(const Geometry& geometry, double theta1, Rounding rounding) noexcept;
/// The low 16 bits, as a signed number.
std::int16_t wrapped(std::int64_t value) noexcept;
/// Homed counts of three arm angles.
Counts counts_of_angles(const Geometry& geometry, const Eigen::Vector3d& theta1,
                        Rounding rounding = Rounding::nearest) noexcept;
/// theta1 [rad] that homed counts stand for.
Eigen::Vector3d angles_of_counts(const Geometry& geometry, const Counts& counts) noexcept;

}  // namespace palpate::device::falcon

// SPDX-License-Identifier: MIT
#pragma once
/// From the torque that is wanted at the arms to motor words, and from the words that arrived to
/// the torque that acts. A positive word pulls the leg in; torques are positive outward.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "device/falcon/kinematics.hpp"

namespace palpate::device::falcon {

using Words = std::array<std::int16_t, 3>;  ///< as on the wire

/// Martin & Hillier, ACRA 2009, as RReichert/Falcon passes them on: 1.9835e-5 N m per word at the
/// motor shaft and a reduction of 7.62; 6616 words per N m at the arm.
inline constexpr double martin_hillier_scale = 6616.0;
/// What libnifalcon multiplies by: no calibration.
inline constexpr double libnifalcon_scale = 10000.0;
/// Kd / Ks of the same source, at the arm [s/rad]; 7 % at 100 rad/s of the motor. Sign uncertain.
inline constexpr double martin_hillier_speed_share = 7.62 * 1.3779e-8 / 1.9835e-5;

struct MotorOptions {
  double words_per_newton_metre = martin_hillier_scale;
  int largest_word = 4096;        ///< the electronics clamp here (ros_falcon: "saturate at +-4096")
  double time_constant = 0.5e-3;  ///< of the current [s]; an estimate; 0: none
  double speed_share = 0.0;       ///< torque is multiplied by 1 + this x theta1' [s/rad]; off
};

struct Command {
  std::array<std::int64_t, 3> asked{};  ///< words before any clamp
  Words sent{};
  bool saturated = false;  ///< a word was clamped
};

/// word = -scale x torque, truncated toward zero, clamped. A torque that is no number sends 0.
Command words_of_torque(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept;

/// Torque at the arms [N m] of words as received: clamped by the electronics, no lag, no speed.
Eigen::Vector3d torque_of_words(const MotorOptions& options, const Words& words) noexcept;

/// Largest torque of one arm [N m].
double largest_torque(const MotorOptions& options) noexcept;

/// The currents, on their way to the last words.
class Motors {
 public:
  explicit Motors(const MotorOptions& options = {}) : options_(options) {}

  /// From now on these words; the torque follows with the time constant.
  void command(const Words& words) noexcept { target_ = torque_of_words(options_, words); }
  /// The torque itself [N m], not rounded to words and not clamped.
  void command_torque(const Eigen::Vector3d& torque) noexcept { target_ = torque; }
  void advance(double duration) noexcept { torque_ = torque_after(duration); }

  /// Torque [N m] of arms at rest, `duration` seconds from now.
  [[nodiscard]] Eigen::Vector3d torque_after(double duration) const noexcept;
  [[nodiscard]] const MotorOptions& options() const noexcept { return options_; }
  /// Of moving arms.
  [[nodiscard]] double speed_share() const noexcept { return options_.speed_share; }

 private:
  MotorOptions options_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();
};

// Encoders of the three motors: whole counts, 16 bits wide, at an arbitrary offset after power-on
// until homing has found their index marks.

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

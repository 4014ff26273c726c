// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of arm torques to motor words and of received words to torques. A positive word pulls
/// the leg inward; torques are positive outward.

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "device/falcon/kinematics.hpp"

namespace palpate::device::falcon {

using Words = std::array<std::int16_t, 3>;  ///< as transmitted

/// Words per N m at the arm, from Martin & Hillier, ACRA 2009, as published in RReichert/Falcon:
/// 1.9835e-5 N m per word at the motor shaft and a reduction of 7.62.
inline constexpr double martin_hillier_scale = 6616.0;
/// Words per N m in libnifalcon, which is not calibrated.
inline constexpr double libnifalcon_scale = 10000.0;

struct MotorOptions {
  double words_per_newton_metre = martin_hillier_scale;
  int largest_word = 4096;        ///< limit of the electronics (ros_falcon: "saturate at +-4096")
  double time_constant = 0.5e-3;  ///< of the current [s]; estimated; 0 disables the lag
  /// Power of the supply [W]: 30 V and 1 A of the data sheet. All currents shrink together when the
  /// motors would take more.
  double supply_power = 30.0;
  /// Power of one motor at its largest word [W]. Not published; assumed such that the supply can
  /// hold the data sheet's 8.9 N (2 lbf) in every direction at the centre of the workspace.
  double largest_power = 24.96;
  /// Time constant of a motor's heating [s]; 0: no thermal limit. Not published.
  double thermal_time = 0.0;
  /// Power that one motor can take for ever [W]; not published; assumed: a third of the supply.
  double continuous_power = 10.0;
};

struct Command {
  std::array<std::int64_t, 3> asked{};  ///< words before clamping
  Words sent{};
  bool saturated = false;  ///< a word was beyond the limit
};

/// Computes word = -scale x torque, truncated toward zero and clamped. A torque of NaN gives 0.
Command words_of_torque(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept;

/// Returns the torque at the arms [N m] for received words, clamped by the electronics, without
/// lag.
Eigen::Vector3d torque_of_words(const MotorOptions& options, const Words& words) noexcept;

/// Returns the torques that the supply can hold: all are reduced by one factor if they would take
/// more than its power.
Eigen::Vector3d supplied(const MotorOptions& options, const Eigen::Vector3d& torque) noexcept;

/// Returns the largest torque of one arm [N m].
double largest_torque(const MotorOptions& options) noexcept;

/// Returns the largest force [N] along a unit direction within the limits of words and supply.
double largest_force(const MotorOptions& options, const Eigen::Matrix3d& jacobian,
                     const Eigen::Vector3d& direction) noexcept;
/// Returns the force [N] that is available in every direction.
double weakest_force(const MotorOptions& options, const Eigen::Matrix3d& jacobian) noexcept;

/// Motor torques with a first-order lag to the last commanded words, within the limits of the
/// supply and of the motors' heat: a motor whose mean power over `thermal_time` exceeds 80 % of
/// `continuous_power` is folded back, to that power at 100 %.
class Motors {
 public:
  explicit Motors(const MotorOptions& options = {}) : options_(options) {}

  /// Commands new words; the torque follows with the time constant.
  void command(const Words& words) noexcept;
  /// Commands a torque [N m] that is neither rounded to words nor clamped.
  void command_torque(const Eigen::Vector3d& torque) noexcept { target_ = torque; }
  /// Returns true if supply or heat reduce the torques of the last words.
  [[nodiscard]] bool limited() const noexcept { return limited_; }
  void advance(double duration) noexcept;

  /// Returns the torque of arms at rest after `duration` [s] [N m].
  [[nodiscard]] Eigen::Vector3d torque_after(double duration) const noexcept;

 private:
  [[nodiscard]] Eigen::Vector3d cooled(const Eigen::Vector3d& torque) const noexcept;

  MotorOptions options_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d heat_ = Eigen::Vector3d::Zero();  ///< mean power over the thermal time [W]
  bool limited_ = false;
};

// Encoders of the three motors: 16-bit counts, with an arbitrary offset from power-on until homing
// has found the index marks.

using Counts = std::array<std::int16_t, 3>;

/// Parameters of the encoders. The homing procedure is that of libnifalcon's users (pull fully out,
/// push in). The index mark near count 0 and both angles are inferred from it.
struct EncoderOptions {
  double arming_angle = 1.0471975511965976;  ///< theta1 beyond which a leg is armed [rad]; 60 deg
  int largest_offset = 2000;                 ///< largest offset at power-on [counts]
};

class Encoders {
 public:
  Encoders(const Geometry& geometry, const EncoderOptions& options, std::uint64_t seed);

  /// Samples the arm angles [rad]. A leg is armed beyond the arming angle and homed when it then
  /// passes the index mark at count 0 inward, provided that `homing` is true at every call. The
  /// mark becomes count 0, so reported positions jump.
  void sample(const Eigen::Vector3d& theta1, bool homing) noexcept;
  /// Sets the state after homing.
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

/// Returns the counts from the index mark, rounded to the nearest, before wrapping to 16 bits.
std::int64_t counts_of_angle(const Geometry& geometry, double theta1) noexcept;
/// Returns the low 16 bits as a signed number.
std::int16_t wrapped(std::int64_t value) noexcept;
/// Returns the homed counts of three arm angles.
Counts counts_of_angles(const Geometry& geometry, const Eigen::Vector3d& theta1) noexcept;
/// Returns theta1 [rad] for homed counts.
Eigen::Vector3d angles_of_counts(const Geometry& geometry, const Counts& counts) noexcept;

}  // namespace palpate::device::falcon

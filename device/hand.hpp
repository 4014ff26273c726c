// SPDX-License-Identifier: MIT
#pragma once
/// Intended motion of the grip: a script along one axis, prepared once and evaluated at any time
/// without allocation. Positions [m] are in the device frame.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

namespace palpate::device {

struct Hold {
  double duration = 1.0;  ///< [s]
};
/// Action with constant speed and a smooth start and end of `ramp` seconds each.
struct Advance {
  double distance = 0.02;  ///< [m] along the axis
  double speed = 0.005;    ///< [m/s]
  double ramp = 0.2;       ///< [s]
};
/// Action of minimum-jerk moves with rests between them, each drawn from these ranges, until the
/// distance is reached.
struct Intermittent {
  double distance = 0.02;                  ///< total [m]
  std::array<double, 2> step{1e-3, 3e-3};  ///< range of one move [m]
  std::array<double, 2> rest{0.3, 1.0};    ///< range of the rest between two moves [s]
  double duration = 0.25;                  ///< of one move [s]
};
/// Action with a force that rises at a constant rate and is then held. Meanwhile the hand's spring
/// is inactive along the axis and its damper stays active. It must be the last action, because its
/// end position is unknown.
struct Push {
  double force = 5.0;     ///< [N] along the axis
  double rise = 1.0;      ///< [s]
  double duration = 5.0;  ///< including the rise [s]
};
/// Action that moves back along the axis.
struct Withdraw {
  double distance = 0.02;
  double speed = 0.01;
  double ramp = 0.2;
};
using Action = std::variant<Hold, Advance, Intermittent, Push, Withdraw>;

/// Script of the intended motion. Delay and tremor are usual values of the literature, recalled and
/// not measured here.
struct IntentScript {
  Eigen::Vector3d start{0.0, 0.0, 0.125};      ///< [m]
  Eigen::Vector3d direction{0.0, 0.0, -1.0};   ///< of insertion; normalised on construction
  std::vector<Action> actions{};               ///< the intent rests after the last one
  std::array<double, 2> reaction{0.15, 0.20};  ///< delay after a loss of resistance [s]
  double braking = 0.10;                       ///< time from the end of the delay to rest [s]
  double tremor = 0.0;  ///< amplitude on each axis, 8-12 Hz; sqrt(2) times the rms [m]; 5e-5 usual
  double speed_variation = 0.0;  ///< largest relative change of the speed of each action [1]
  std::uint64_t seed = 1;
};

struct IntentPoint {
  Eigen::Vector3d position{};
  Eigen::Vector3d velocity{};
  double push = 0.0;     ///< force along the axis [N]
  bool pushing = false;  ///< true if the spring is inactive along the axis
};

class Intent {
 public:
  /// Throws std::invalid_argument for an invalid script.
  explicit Intent(const IntentScript& script = {});

  [[nodiscard]] IntentPoint at(double time) const noexcept;
  [[nodiscard]] const Eigen::Vector3d& direction() const noexcept { return direction_; }
  [[nodiscard]] double reaction() const noexcept { return reaction_; }  ///< drawn delay [s]
  /// Returns the time at which the script ends [s].
  [[nodiscard]] double end() const noexcept;

  /// Delays the whole script by `seconds` [s].
  void delay(double seconds) noexcept {
    for (Segment& segment : segments_) { segment.begin += seconds; }
  }

  /// Signals a loss of resistance at `time` [s]. The intent continues for the reaction time, then
  /// comes to rest smoothly; a later withdrawal in the script follows at once. Only the first call
  /// has an effect, and only while the script advances or pushes.
  void loss_of_resistance(double time) noexcept;

 private:
  enum class Shape { rest, cruise, minimum_jerk, push };
  struct Segment {
    Shape shape = Shape::rest;
    double begin = 0.0;     ///< [s]
    double duration = 0.0;  ///< [s]
    double from = 0.0;      ///< [m] along the axis
    double distance = 0.0;  ///< [m] signed
    double ramp = 0.0;      ///< [s]
    double force = 0.0;     ///< [N]
    bool withdrawal = false;
  };
  struct Along {
    double position = 0.0, velocity = 0.0, push = 0.0;
    bool pushing = false;
  };
  struct Stop {
    double begin = 0.0;  ///< [s]
    Along from{};
    std::size_t resume = 0;  ///< segment; none when past the last
    double later = 0.0;      ///< shift of the rest of the script [s]
    double further = 0.0;    ///< [m]
  };

  void add(const Action& action, double pace, class Seeded& seeded);
  void add_steps(const Intermittent& steps, double pace, class Seeded& seeded);
  void append(Segment segment);
  [[nodiscard]] static Along evaluate(const Segment& segment, double time) noexcept;
  [[nodiscard]] Along script_at(double time, std::size_t first) const noexcept;
  [[nodiscard]] Along along(double time) const noexcept;
  [[nodiscard]] const Segment* segment_at(double time) const noexcept;

  Eigen::Vector3d start_;
  Eigen::Vector3d direction_;
  std::vector<Segment> segments_{};
  double reaction_ = 0.0;
  double braking_ = 0.0;
  std::optional<Stop> stop_{};
  static constexpr int tremor_sines = 5;
  double tremor_ = 0.0;                                          ///< amplitude of one sine [m]
  std::array<std::array<double, tremor_sines>, 3> pulsation_{};  ///< [rad/s]
  std::array<std::array<double, tremor_sines>, 3> phase_{};      ///< [rad]
};

// Hand at the grip: a rigidly attached mass, connected by a spring and a damper to the intended
// position. With an arm, they connect to the arm's mass, and a second pair connects the arm to the
// intended position. The person carries the weight of hand and arm.

/// Impedance of a hand, within the range of S. van Beek et al., Sci. Rep. 5:18004 (2015), for the
/// whole arm and of the grips listed in device/README.md. It is chosen, not fitted to a person.
struct HandImpedance {
  double mass = 0.15;        ///< [kg]
  double viscosity = 6.0;    ///< [N s/m]
  double stiffness = 400.0;  ///< [N/m]
};
inline constexpr HandImpedance light_hand{.mass = 0.10, .viscosity = 3.0, .stiffness = 150.0};
inline constexpr HandImpedance medium_hand{};
inline constexpr HandImpedance firm_hand{.mass = 0.25, .viscosity = 12.0, .stiffness = 1000.0};
/// Second stage of the hand; van Beek et al. fitted 0.554 kg, 6.45 N s/m, 135 N/m to a whole arm.
inline constexpr HandImpedance arm_stage{.mass = 0.55, .viscosity = 6.5, .stiffness = 135.0};
/// Impedance of a grip that is not held.
inline constexpr HandImpedance no_hand{.mass = 0.0, .viscosity = 0.0, .stiffness = 0.0};

struct Hand {
  HandImpedance impedance{};
  std::optional<HandImpedance> arm{};  ///< second stage, if any
  Intent intent{};
};

/// Motion of the arm; at rest at the intended position until the first step of the plant.
struct ArmMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// Forces of the hand at one instant [N].
struct HandForces {
  Eigen::Vector3d on_grip{};  ///< [N]
  Eigen::Vector3d on_arm{};   ///< [N]; zero without an arm
};
HandForces hand_forces(const Hand& hand, const IntentPoint& intent,
                       const Eigen::Vector3d& grip_position, const Eigen::Vector3d& grip_velocity,
                       const ArmMotion& arm) noexcept;

}  // namespace palpate::device

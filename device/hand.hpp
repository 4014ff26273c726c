// SPDX-License-Identifier: MIT
#pragma once
/// Where a person wants the grip: a script along one axis, made ready once and then evaluated at
/// any time without allocation. Positions [m] in the device frame.

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
/// Constant speed, with a smooth start and end of `ramp` seconds each.
struct Advance {
  double distance = 0.02;  ///< [m] along the axis
  double speed = 0.005;    ///< [m/s]
  double ramp = 0.2;       ///< [s]
};
/// Minimum-jerk moves with rests between them, each drawn from these ranges, until the distance is
/// reached.
struct Intermittent {
  double distance = 0.02;                  ///< [m] in all
  std::array<double, 2> step{1e-3, 3e-3};  ///< [m] of one move
  std::array<double, 2> rest{0.3, 1.0};    ///< [s] between two
  double duration = 0.25;                  ///< [s] of one move
};
/// A force that rises at a constant rate and is then held; the hand's spring lets go along the
/// axis meanwhile, its damper stays. The last action of its script: nobody knows where it ends.
struct Push {
  double force = 5.0;     ///< [N] along the axis
  double rise = 1.0;      ///< [s]
  double duration = 5.0;  ///< [s] with the rise
};
/// Back along the axis.
struct Withdraw {
  double distance = 0.02;
  double speed = 0.01;
  double ramp = 0.2;
};
using Action = std::variant<Hold, Advance, Intermittent, Push, Withdraw>;

/// Delay and tremor are the literature's usual figures, recalled and not measured here.
struct IntentScript {
  Eigen::Vector3d start{0.0, 0.0, 0.125};      ///< [m]
  Eigen::Vector3d direction{0.0, 0.0, -1.0};   ///< of insertion; made a unit vector
  std::vector<Action> actions{};               ///< after the last one the intent rests
  std::array<double, 2> reaction{0.15, 0.20};  ///< delay after a loss of resistance is drawn [s]
  double braking = 0.10;                       ///< [s] from there to rest
  double tremor = 0.0;  ///< amplitude on each axis, 8-12 Hz; sqrt(2) times the rms [m]; 5e-5 usual
  double speed_variation = 0.0;  ///< each action is up to this share faster or slower [1]
  std::uint64_t seed = 1;
};

struct IntentPoint {
  Eigen::Vector3d position{};
  Eigen::Vector3d velocity{};
  double push = 0.0;     ///< force along the axis [N]
  bool pushing = false;  ///< the spring lets go along the axis
};

class Intent {
 public:
  /// Throws std::invalid_argument for a script that makes no sense.
  explicit Intent(const IntentScript& script = {});

  [[nodiscard]] IntentPoint at(double time) const noexcept;
  [[nodiscard]] const Eigen::Vector3d& direction() const noexcept { return direction_; }
  [[nodiscard]] double reaction() const noexcept { return reaction_; }  ///< [s] as drawn
  /// When the script has nothing left to do [s].
  [[nodiscard]] double end() const noexcept;

  /// The whole script begins so much later [s].
  void delay(double seconds) noexcept {
    for (Segment& segment : segments_) { segment.begin += seconds; }
  }

  /// The person feels resistance vanish. The intent goes on for the reaction time, then comes to
  /// rest smoothly; a withdrawal that the script has later begins right after. Only the first
  /// loss counts, and only while the script advances or pushes.
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
  struct Stop {
    double begin = 0.0;  ///< [s]
    double from = 0.0;   ///< [m]
    double speed = 0.0;  ///< [m/s]
    double push = 0.0;   ///< [N]
    bool pushing = false;
    std::size_t resume = 0;  ///< segment; none when past the last
    double later = 0.0;      ///< that the rest of the script is shifted by [s]
    double further = 0.0;    ///< [m]
  };
  struct Along {
    double position = 0.0, velocity = 0.0, push = 0.0;
    bool pushing = false;
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

// The hand at the grip: a mass held rigidly by it, drawn by a spring and a damper to where the
// person wants it. With an arm, the spring ends at the arm's mass, and the arm's spring there.
// The person bears the weight of hand and arm.

/// Inside the range of S. van Beek et al., Sci. Rep. 5:18004 (2015), for the whole arm and of the
/// grips listed in device/README.md; chosen, not fitted to a person.
struct HandImpedance {
  double mass = 0.15;        ///< [kg]
  double viscosity = 6.0;    ///< [N s/m]
  double stiffness = 400.0;  ///< [N/m]
};
inline constexpr HandImpedance light_hand{.mass = 0.10, .viscosity = 3.0, .stiffness = 150.0};
inline constexpr HandImpedance medium_hand{};
inline constexpr HandImpedance firm_hand{.mass = 0.25, .viscosity = 12.0, .stiffness = 1000.0};
/// The second stage; van Beek et al. fitted 0.554 kg, 6.45 N s/m, 135 N/m to a whole arm.
inline constexpr HandImpedance arm_stage{.mass = 0.55, .viscosity = 6.5, .stiffness = 135.0};
/// Nobody holds the grip.
inline constexpr HandImpedance no_hand{.mass = 0.0, .viscosity = 0.0, .stiffness = 0.0};

struct Hand {
  HandImpedance impedance{};
  std::optional<HandImpedance> arm{};  ///< the two-stage hand
  Intent intent{};
};

/// What the arm does; rests at the intent until the plant has first moved it.
struct ArmMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// Forces of the hand at one instant.
struct HandForces {
  Eigen::Vector3d on_grip{};  ///< [N]
  Eigen::Vector3d on_arm{};   ///< [N]; zero without an arm
};
HandForces hand_forces(const Hand& hand, const IntentPoint& intent,
                       const Eigen::Vector3d& grip_position, const Eigen::Vector3d& grip_velocity,
                       const ArmMotion& arm) noexcept;

}  // namespace palpate::device

// SPDX-License-Identifier: MIT
#pragma once
/// Ends of a live run that meet in the loop: the grip that holds the tool, the snapshots that a
/// viewer gets, the commands of the operator, and the rows of the recording. Between the loop and
/// other threads there are only lock-free queues and triple buffers.

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/grip_thread.hpp"
#include "device/latest_value.hpp"
#include "validation/roll_out.hpp"

namespace palpate::live {

inline constexpr std::size_t most_materials = 64;  ///< materials whose stiffness can be changed

struct Command {
  enum class Kind : std::uint8_t {
    start,
    pause,
    reset,
    drive,      ///< value: target of the grip [m], reached at the set speed
    hold,       ///< value: target of a pointer [m], followed at once
    speed,      ///< value: of the drive [m/s]
    stiffness,  ///< value: factor of Young's modulus of a material
    stop,       ///< emergency stop: pause, and no force on the device until start
  } kind = Kind::pause;
  double value = 0.0;
  std::size_t index = 0;  ///< of the material
};

/// State of the loop at one instant; all members are numbers, so that one checksum covers it.
struct LiveState {
  double time = 0.0;      ///< [s]
  double applied = 0.0;   ///< force of the hand [N]
  double reaction = 0.0;  ///< of the tissue on the tool [N]
  double depth = 0.0;     ///< of the tip, in undeformed tissue [m]
  double cutting = 0.0;   ///< part of it at a tip that cuts [N]
  double friction = 0.0;  ///< along the shaft [N]
  double pressing = 0.0;  ///< on a tip or face that presses, and of bone [N]
  double pressure = 0.0;  ///< of the syringe [Pa]
  double place = 0.0;     ///< of the tool along its path [m]
  double grip = 0.0;      ///< of the hand's end of the coupling [m]
  double target = 0.0;    ///< of the grip [m]
  double speed = 0.0;     ///< of the drive [m/s]
  double ticks = 0.0;     ///< of this run
  double periods = 0.0;   ///< of the loop since it began, held ones included
  double missed = 0.0;    ///< periods whose work ended after the deadline
  double worst = 0.0;     ///< largest response time [s]
  double pace = 1.0;      ///< time of the periods over that of the clock, of the last second
  double left_out = 0.0;  ///< time that late periods did not make up [s]
  double too_slow = 0.0;  ///< 1: paused, because with a device the scene must keep its period
  double running = 0.0;   ///< 0: paused
  double ended = 0.0;     ///< 1: the scene is over, 2: diverged; until reset
  double run = 0.0;       ///< number of resets
  double lost_rows = 0.0;
  double changing = 0.0;      ///< 1: the sliders say other materials; 2: these need a reset
  double changed = -1.0;      ///< time of the last change of materials in this run [s]; -1: none
  double device = 0.0;        ///< device::falcon::GripState
  double device_force = 0.0;  ///< last force sent to the device, along the tool [N]
};

struct Snapshot {
  LiveState state{};
  NodeVectors position{};  ///< of all nodes [m]
  std::uint64_t checksum = 0;

  void seal() noexcept { checksum = sum(); }
  /// False if the snapshot is not what its producer sealed.
  [[nodiscard]] bool whole() const noexcept { return checksum == sum(); }

 private:
  [[nodiscard]] std::uint64_t sum() const noexcept;
};

using StiffnessFactors = std::array<double, most_materials>;

/// Simulation with other materials, on its way from its builder to the loop, and the one that it
/// replaced on its way back.
struct NextSimulation {
  Simulation simulation;
  StiffnessFactors factors{};
  long tick = 0;  ///< ticks completed when the loop took it
};

/// Event of the tool, with the number of its run.
struct LiveEvent {
  ToolHappening happening{};
  int run = 0;
};

/// Motion of a grip that no device holds: it goes to its target at a limited speed, and settles
/// there like a critically damped spring.
class Grip {
 public:
  void place_at(double position) noexcept;
  void drive_to(double target) noexcept { target_ = target, pointed_ = false; }
  void point_to(double target) noexcept { target_ = target, pointed_ = true; }
  void set_speed(double speed) noexcept { speed_ = speed; }
  ToolInput advance(double dt) noexcept;

  [[nodiscard]] double target() const noexcept { return target_; }
  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double speed() const noexcept { return speed_; }

 private:
  double target_ = 0.0;
  double intent_ = 0.0;  ///< goes to the target at the speed
  double position_ = 0.0;
  double velocity_ = 0.0;
  double speed_ = 0.005;
  bool pointed_ = false;  ///< the target is a pointer's
};

struct LiveOptions {
  bool drives = false;  ///< the grip goes to the depth of the drive when a run starts
  device::falcon::GripThread* device = nullptr;  ///< holds the grip instead; must outlive the loop
  bool records = true;
};

/// Hook of a live run. Constructed before the run; begin() prepares every run of the session.
class LiveLoop final : public TickHook {
 public:
  static constexpr double frames_per_second = 60.0;
  /// Lateness that is not made up: later periods are put off instead [s].
  static constexpr double most_late = 0.25;
  /// Pace below which a scene counts as too slow for real time.
  static constexpr double least_pace = 0.9;

  /// `scene` must have a coupled tool, or none.
  LiveLoop(const Scene& scene, Subject& subject, const LiveOptions& options);
  LiveLoop(const LiveLoop&) = delete;
  LiveLoop& operator=(const LiveLoop&) = delete;

  /// Prepares a run from t = 0 of a loaded subject. Not during a run. `clock`, that of the run, is
  /// put off while the loop cannot keep its period.
  void begin(Subject& subject, device::DeadlineClock* clock = nullptr);
  /// After the end of a run: publishes its last state again and again, until a reset is commanded
  /// or `stop` is set. Not real-time: it sleeps between.
  void wait_for_reset(Subject& subject, bool diverged, const std::atomic<bool>& stop);

  TickOrder before_tick(Subject& subject) noexcept override;
  void after_tick(Subject& subject, const certificate::TickTimes& times,
                  bool stepped) noexcept override;

  [[nodiscard]] bool wants_reset() const noexcept { return reset_; }
  [[nodiscard]] const StiffnessFactors& stiffness() const { return stiffness_; }
  /// True if materials can change while the scene runs, and not at a reset only.
  [[nodiscard]] bool changes_materials() const noexcept { return model_ != nullptr; }
  [[nodiscard]] const certificate::LoopRecord& record() const { return record_; }
  [[nodiscard]] const LiveState& state() const { return state_; }
  [[nodiscard]] std::vector<std::string> row_names() const;

  // Ends for other threads, one thread each.
  device::Queue<Command, 1024> commands{};
  device::LatestValue<Snapshot> snapshots;
  device::Queue<LiveEvent, 1024> events{};
  device::Queue<double, 1 << 18> rows{};           ///< some 16 s of a needle with syringe at 1 kHz
  device::LatestValue<StiffnessFactors> wanted{};  ///< of materials; the last command's
  std::atomic<NextSimulation*> offered{nullptr};   ///< taken at the next border of a tick
  std::atomic<NextSimulation*> returned{nullptr};  ///< taken, with the simulation before it
  std::atomic<bool> needs_reset{false};  ///< the state cannot be carried over to the materials

 private:
  void obey(const Command& command) noexcept;
  void compare_materials() noexcept;
  void take_materials(const Subject& subject) noexcept;
  [[nodiscard]] std::optional<ToolInput> input(Subject& subject) noexcept;
  void publish(Subject& subject) noexcept;
  void measure_pace(const certificate::TickTimes& times) noexcept;
  void write_row(Subject& subject) noexcept;

  LiveOptions options_;
  Drive drive_;
  FalconDrive coupling_;
  bool has_tool_;
  double step_;
  long publish_every_;
  std::vector<std::string> names_{};
  std::vector<double> row_{};  ///< time, columns of the subject, grip
  /// In row_ of depth, force, applied, pressure, cutting, friction, stiffness; -1: none.
  std::array<int, 7> column_{};
  device::DeadlineClock* clock_ = nullptr;
  double second_began_ = -1.0;  ///< [s]; below 0: none yet
  double second_periods_ = 0.0;
  int slow_seconds_ = 0;  ///< in a row
  certificate::LoopRecord record_;
  LiveState state_{};
  Grip grip_{};
  StiffnessFactors stiffness_{};  ///< that the sliders say
  StiffnessFactors present_{};    ///< of the simulation
  ModelSubject* model_;           ///< null: another simulator
  double device_start_ = 0.0;
  bool device_held_ = false;
  device::falcon::ForceOrder force_{};
  ToolInput held_{};
  bool reset_ = false;
};

/// Thread that writes the rows of a loop to a file. Rows are written whole, some times a second, so
/// that memory stays constant and a killed process leaves a file that can be read.
class RowWriter {
 public:
  RowWriter(LiveLoop& loop, const std::filesystem::path& file);
  ~RowWriter();
  RowWriter(const RowWriter&) = delete;
  RowWriter& operator=(const RowWriter&) = delete;
  /// Writes what is left and ends. Returns false if the disk took less than all.
  bool finish();
  [[nodiscard]] long rows() const { return rows_; }

 private:
  void write_waiting();

  LiveLoop& loop_;
  std::ofstream out_;
  std::vector<double> row_;
  std::string text_{};
  long rows_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_{};
};

/// Thread that builds simulations for the sliders of a run and offers them to its loop. It frees
/// what the loop gives back.
class MaterialBuilder {
 public:
  /// `scene` has the materials as given, and `names` those with sliders. The run begins with the
  /// factors `now`. The subject must be a ModelSubject.
  MaterialBuilder(LiveLoop& loop, const ModelSubject& subject, Scene scene,
                  std::vector<std::string> names, const StiffnessFactors& now);
  ~MaterialBuilder();
  MaterialBuilder(const MaterialBuilder&) = delete;
  MaterialBuilder& operator=(const MaterialBuilder&) = delete;
  /// Ends, after the loop. Returns the changes that the loop took; `material` counts
  /// those with sliders.
  const std::vector<MaterialChange>& finish();
  /// Returns why materials could not change while the scene ran; empty: they could. After finish().
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

 private:
  void build();
  [[nodiscard]] std::unique_ptr<NextSimulation> make(const StiffnessFactors& factors) const;
  void note(const NextSimulation& taken);

  LiveLoop& loop_;
  const ModelSubject& subject_;
  Scene scene_;
  std::vector<std::string> names_;
  StiffnessFactors now_;
  std::vector<MaterialChange> changes_{};
  std::string refusal_{};
  std::atomic<bool> stop_{false};
  std::thread thread_{};
};

/// Multiplies Young's moduli of the named materials of a scene by factors.
Scene with_stiffness(Scene scene, const std::vector<std::string>& names,
                     const StiffnessFactors& factors);

}  // namespace palpate::live

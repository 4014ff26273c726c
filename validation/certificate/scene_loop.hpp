// SPDX-License-Identifier: MIT
#pragma once
/// Scene stepped one period at a time, as in a training simulator. It contains tissue, tool and
/// hand, the emulated Falcon and its line if the scene has one, and the pressure link if it has a
/// syringe. Everything is allocated on construction.

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/subject/falcon_loop.hpp"
#include "validation/subject/grip_replay.hpp"

namespace palpate::certificate {

struct SceneLoopOptions {
  bool faults = false;  ///< inject faults on the Falcon's line and on the pressure link
  const SpringNetwork* network = nullptr;  ///< replaces the tissue of the scene; nullptr: keep it
  std::function<std::unique_ptr<Subject>()> subject{};  ///< empty: the model
};

/// Returns the loop rate of a scene [Hz]: the rate of its haptic loop, or one tick per step without
/// one.
double rate_of(const Scene& scene);
/// Returns the reason why a scene cannot run at this rate, with the allowed rates; empty if it can.
std::string why_not_at(const Scene& scene, double rate);

class SceneLoop {
 public:
  /// Prepares the loop. The scene must outlive it. Throws the exceptions of the subject and
  /// of FalconLoop.
  SceneLoop(const Scene& scene, double rate, const SceneLoopOptions& options = {});
  SceneLoop(const SceneLoop&) = delete;  // members hold references to each other
  SceneLoop& operator=(const SceneLoop&) = delete;

  /// Advances by one period. Between two steps of slower tissue only the device, if any, is
  /// stepped.
  StepStatus tick() noexcept;
  /// Returns true after the duration of the scene.
  [[nodiscard]] bool over() const noexcept;
  [[nodiscard]] long tick_count() const noexcept;  ///< ticks in the scene's duration
  [[nodiscard]] Moment moment() const noexcept;
  /// Returns the events of the tool in the last tick; in the first tick also those at the start.
  [[nodiscard]] std::span<const ToolHappening> happenings() const noexcept { return happened_; }
  [[nodiscard]] Subject& subject() { return *subject_; }
  [[nodiscard]] FalconLoop* falcon() { return falcon_ ? &*falcon_ : nullptr; }
  /// Returns the counts of the pressure link.
  [[nodiscard]] const device::pressure_link::ReaderCounts& frames() const {
    return reader_.counts();
  }

 private:
  void send_pressure() noexcept;
  void take_happenings() noexcept;

  std::unique_ptr<Subject> subject_;
  long periods_of_step_;
  long period_ = 0;  ///< of the present step
  std::optional<FalconLoop> falcon_{};
  double step_;  ///< of the scene [s]
  GripReplay replay_;
  bool has_pressure_;
  /// One byte of every other frame is changed, so that the reader must resynchronise.
  bool damages_frames_;
  long frames_ = 0;  ///< sent
  device::pressure_link::FrameReader reader_{};
  std::vector<ToolHappening> happened_{};
  bool begun_ = false;
  std::vector<double> row_{};
  std::size_t pressure_column_ = 0;
};

/// "puncture of ligamentum flavum" for every happening of a scene's tool.
class HappeningNames {
 public:
  explicit HappeningNames(const Scene& scene);
  [[nodiscard]] std::string of(const ToolHappening& happening) const;

 private:
  std::vector<std::string> labels_{};
};

}  // namespace palpate::certificate

// SPDX-License-Identifier: MIT
#pragma once
/// The pressure link as part of a tick: a frame when one is due, coded, sent and read again.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/subject/falcon_loop.hpp"

namespace palpate::certificate {

class PressureLine {
 public:
  /// With `damaged` a byte of every other frame is changed on its way, so that the reader has to
  /// look for the next one.
  explicit PressureLine(bool damaged = false) : damaged_(damaged) {}

  /// The pressure [Pa] at this time [s]; sends nothing while no frame is due.
  void send(double time, double pressure) noexcept;
  [[nodiscard]] const device::pressure_link::ReaderCounts& counts() const {
    return reader_.counts();
  }

 private:
  bool damaged_;
  long frames_ = 0;
  device::pressure_link::FrameReader reader_{};
};

// A scene as the loop of a trainer steps it, one period at a time: what `palpate run` steps, that
// is tissue, tool and hand, the emulated Falcon and its wire where the scene has one, and the
// pressure link where it has a syringe. Everything is allocated on construction.

struct SceneLoopOptions {
  bool skip = true;                        ///< false: compute what the scene does not need
  bool faults = false;                     ///< on the Falcon's wire and on the pressure link
  const SpringNetwork* network = nullptr;  ///< instead of the scene's own tissue
};

/// Loop rate of a scene [Hz]: that of its haptic loop, else a tick a step.
double rate_of(const Scene& scene);
/// Why a scene cannot run at this rate: what was found and what is allowed; empty where it can.
std::string why_not_at(const Scene& scene, double rate);

class SceneLoop {
 public:
  /// The scene outlives the loop. Throws what Simulation and FalconLoop throw.
  SceneLoop(const Scene& scene, double rate, const SceneLoopOptions& options = {});
  SceneLoop(const SceneLoop&) = delete;  // its parts know each other's places
  SceneLoop& operator=(const SceneLoop&) = delete;

  /// One period. Between two steps of slower tissue only the device is stepped, or nothing without
  /// one.
  StepStatus tick() noexcept;
  /// The scene's duration is over.
  [[nodiscard]] bool over() const noexcept;
  [[nodiscard]] long tick_count() const noexcept;  ///< in the scene's duration
  [[nodiscard]] Moment moment() const noexcept;
  /// What happened to the tool in the last tick; in the first one also what had happened at the
  /// start.
  [[nodiscard]] std::span<const ToolHappening> happenings() const noexcept { return happened_; }
  [[nodiscard]] Simulation& simulation() { return subject_.simulation(); }
  [[nodiscard]] FalconLoop* falcon() { return falcon_ ? &*falcon_ : nullptr; }
  [[nodiscard]] const PressureLine* pressure_line() const { return line_ ? &*line_ : nullptr; }

 private:
  void send_pressure() noexcept;
  void take_happenings() noexcept;

  ModelSubject subject_;
  long periods_of_step_;
  long period_ = 0;  ///< of the present step
  std::optional<FalconLoop> falcon_{};
  std::optional<PressureLine> line_{};
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

// SPDX-License-Identifier: MIT
#pragma once
/// Where all nodes were when something happened: at ticks with events, and when the tool felt most.

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/subject/falcon_loop.hpp"

namespace palpate {

/// Snapshots of all nodes in order of time.
struct Moments {
  std::vector<double> time{};            ///< [s]
  std::vector<NodeVectors> positions{};  ///< [m]
};

/// Keeps them while a run goes on. Everything is allocated on construction, take() allocates
/// nothing.
class MomentKeeper {
 public:
  /// The first `most` ticks with events, and one of largest force; a run without a tool has
  /// neither.
  MomentKeeper(const Simulation& simulation, int most);
  /// After each tick; `trace` holds its row and its events.
  void take(Simulation& simulation, const Trace& trace) noexcept;
  /// What was kept; once, when the run is over.
  [[nodiscard]] Moments moments();

 private:
  std::size_t force_column_ = 0;
  std::size_t kept_ = 0;
  std::size_t events_seen_ = 0;
  double largest_ = 0.0;       ///< force so far [N]
  double largest_time_ = 0.0;  ///< [s]
  Moments at_events_;
  NodeVectors at_largest_;
};

// The one way in which a case lets the model move, so that a mutation reaches every case.

struct CaseContext;
struct Insertion;

/// A sampled motion of the coordinates of a problem (free nodes, three each, in node order).
struct Motion {
  std::vector<double> time{};    ///< [s]
  Eigen::MatrixXd position{};    ///< dof x times [m]
  Eigen::MatrixXd velocity{};    ///< dof x times [m/s]; empty unless asked for
  std::vector<double> energy{};  ///< [J]; empty unless asked for
  bool diverged = false;
  double diverged_at = 0.0;  ///< [s]
  int substeps = 1;
  double h = 0.0;        ///< [s] of the integrator
  double seconds = 0.0;  ///< wall time of the ticks alone
  long steps = 0;
};

/// A fault planted in the candidate.
struct Mutation {
  std::string name{};
  std::function<void(Scene&, SpringNetwork&)> model{};  ///< before the run; network may be empty
  std::function<void(Motion&)> motion{};                ///< after it
  std::function<void(Insertion&)> insertion{};          ///< after that of a tool
  std::function<void(std::vector<double>&)>
      pressure{};           ///< of a simulated insertion, before it is compared [Pa]
  int loop_delay = 0;       ///< further ticks in every haptic loop
  bool step_twice = false;  ///< every step taken with twice its length
};

struct Wanted {
  bool velocity = false;
  bool energy = false;
  long every = 1;  ///< ticks between samples; the first and the last are always there
};

/// The scene in motion; `network` replaces the scene's tissue unless it is nullptr.
Motion simulate(const CaseContext& context, Scene scene, const SpringNetwork* network = nullptr,
                const Wanted& wanted = {});

/// A scene around a network made in memory.
Scene scene_of(const std::string& integrator, double step, double duration, int substeps = 1);

// The one way in which a case lets a tool move in tissue, so that a mutation reaches every case.

/// A tool in tissue, sampled at ticks; the first sample is t = 0.
struct Insertion {
  std::vector<double> time{};  ///< [s]
  std::vector<ToolReport> tool{};
  std::vector<std::string> layer{};
  std::vector<Event> events{};
  std::vector<double> pressure{};  ///< [Pa]; empty without a syringe
  std::vector<double> energy{};    ///< [J]
  Eigen::MatrixXd position{};      ///< dof x samples [m]; empty unless asked for
  Eigen::MatrixXd velocity{};      ///< likewise [m/s]
  bool diverged = false;
  std::string integrator{};
  int substeps = 1;
  double h = 0.0;        ///< [s]
  double seconds = 0.0;  ///< wall time of the ticks alone

  /// Time of the first such event in a layer [s]; NaN when there was none.
  [[nodiscard]] double time_of(std::string_view kind, std::string_view detail = {}) const;
  [[nodiscard]] long count(std::string_view kind) const;
};

struct InsertionWanted {
  long every = 1;       ///< ticks between samples
  bool motion = false;  ///< position and velocity of the free nodes
};

/// The scene's tool in the scene's tissue.
Insertion insert_tool(const CaseContext& context, Scene scene, const InsertionWanted& wanted = {});

// The one loop of a whole run: Simulation -> Trace, with what a person asks about it afterwards.

struct RunEnergy {
  double initial = 0.0;  ///< [J]
  double final = 0.0;    ///< [J]
  double maximum = 0.0;  ///< over the ticks [J]
};

struct Run {
  Trace trace{};
  Moments moments{};  ///< beside the frames of the trace
  bool diverged = false;
  double diverged_at = 0.0;  ///< [s]
  bool interrupted = false;
  long ticks = 0;
  long steps = 0;             ///< of the integrator
  double seconds = 0.0;       ///< wall time of the ticks alone
  double slowest_tick = 0.0;  ///< [s]
  RunEnergy energy{};
  int zero_length_springs = 0;                       ///< at the end
  std::optional<FalconFacts> falcon{};               ///< of a tool in a hand
  std::optional<device::DeadlineFacts> real_time{};  ///< where ticks waited for the wall clock

  [[nodiscard]] double ns_per_spring_step(std::size_t springs) const {
    return steps == 0 || springs == 0
               ? 0.0
               : 1e9 * seconds / (static_cast<double>(steps) * static_cast<double>(springs));
  }
};

struct RollOutOptions {
  int frames = 0;  ///< snapshots of all nodes, evenly over the ticks
  int events = 0;  ///< snapshots at the first so many ticks with events, and at the
                   ///< tool's largest force
  const std::atomic<bool>* stop = nullptr;       ///< looked at between ticks
  std::function<void(double share)> progress{};  ///< 0 to 1, a few times a second at most
  std::function<bool(const Trace&)>
      enough{};  ///< after every tick: true ends the run, as its duration would
  device::DeadlineClock* clock =
      nullptr;                   ///< that every tick waits for; as fast as it goes without
  FalconLoop* falcon = nullptr;  ///< of a scene whose tool a hand holds
};

/// Runs to the scene's duration, to divergence, or to a stop. The trace keeps every tick before
/// the first state that was not finite or out of bounds.
Run roll_out(Simulation& simulation, const RollOutOptions& options);

}  // namespace palpate

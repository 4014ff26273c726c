// SPDX-License-Identifier: MIT
#pragma once
/// A real-time certificate: what was claimed, what was measured, and whether that supports the claim.

#include <optional>
#include <string>
#include <vector>

#include "device/real_time.hpp"
#include "validation/certificate/loop_record.hpp"
#include "validation/certificate/missed_tick.hpp"
#include "validation/certificate/provocation.hpp"
#include "validation/certificate/tail.hpp"

namespace palpate::certificate {

struct Claim {
  double rate = 1000.0;    ///< of releases [Hz]
  double deadline = 1e-3;  ///< from a release until the tick is done [s]
  double duration = 10.0;  ///< asked for, of each phase [s]

  [[nodiscard]] double period() const { return 1.0 / rate; }
  [[nodiscard]] long ticks() const;  ///< of each phase
};

/// What the system did on the loop's processor during a phase.
struct ProcessorTimes {
  double stolen = 0.0;      ///< by the hypervisor [s]
  double others = 0.0;      ///< busy on all other processors [s]
  double interrupts = 0.0;  ///< hardware and software interrupts [s]
};

/// One loop under one load.
struct Phase {
  explicit Phase(double deadline) : record(deadline) {}
  LoopRecord record;
  device::ThreadCounts counts{};  ///< in its ticks alone
  ProcessorTimes times{};
  double seconds = 0.0;   ///< wall time, with pauses
  long restarts = 0;      ///< of the scene from its beginning
  double paused = 0.0;    ///< for them, between ticks [s]
  bool hopeless = false;  ///< given up, far too late
};

/// The empty loop and the scene, one after the other under the same load.
struct LoadResult {
  LoadResult(std::string name, double deadline) : load(std::move(name)), control(deadline), scene(deadline) {}
  std::string load;
  Phase control;
  Phase scene;
  Tail tail{};  ///< of the scene's responses

  [[nodiscard]] double miss_probability_upper() const;
};

/// What the system granted; empty texts: granted.
struct Rights {
  std::string fifo{};
  std::string memory{};
  std::string processor{};
  int on = 0;         ///< processor of the loop
  bool alone = true;  ///< loads had other processors

  [[nodiscard]] bool all() const { return fifo.empty() && memory.empty(); }
};

struct Certificate {
  Claim claim{};
  Rights rights{};
  ComputeBudget budget{};
  std::vector<LoadResult> loads{};
  std::optional<MissedTick> missed_tick{};
  bool interrupted = false;
  std::vector<std::string> notes{};

  /// The load under which least can be said for the scene: largest limit of the miss probability. None:
  /// nothing ran.
  [[nodiscard]] const LoadResult* worst() const;
};

}  // namespace palpate::certificate

// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "device/real_time.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/certificate/tail.hpp"
#include "validation/certificate/worst_case_probe.hpp"
#include "validation/outcome.hpp"

namespace palpate::certificate {

/// Upper limit of the probability that a tick misses, after `misses` of `ticks`, one-sided (Clopper
/// & Pearson, Biometrika 26, 1934): the p for which so few misses or fewer have the chance 1 -
/// confidence. After none it is 1 - (1 - confidence)^(1/n), some 3/n at 95 %. 1 where every tick
/// missed, or none was counted. The inverse is Boost's: gsl_cdf_beta_Pinv of GSL 2.7 ends the
/// program for one miss of 1000, where its steps do not converge.
double miss_probability_upper(long misses, long ticks, double confidence = 0.95);

// A real-time certificate: the claim, the measurements and the verdict.

struct Claim {
  double rate = 1000.0;    ///< of releases [Hz]
  double deadline = 1e-3;  ///< from a release until the tick is done [s]
  double duration = 10.0;  ///< asked for, of each phase [s]

  [[nodiscard]] double period() const { return 1.0 / rate; }
  [[nodiscard]] long ticks() const;  ///< of each phase
};

/// Time that other work took from the loop's processor during a phase.
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
  LoadResult(std::string name, double deadline)
      : load(std::move(name)), control(deadline), scene(deadline) {}
  std::string load;
  Phase control;
  Phase scene;
  Tail tail{};  ///< of the scene's responses

  [[nodiscard]] double miss_probability_upper() const;
};

/// Rights that the system granted: an empty text, or why it refused.
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

  /// The load with the largest upper limit of the miss probability; nullptr if nothing ran.
  [[nodiscard]] const LoadResult* worst() const;
};

// The verdict.

/// pass: "certified"; fail: "not certified"; inconclusive: "environment not qualified".
std::string_view verdict_word(Status status);

/// The verdict on a certificate; its one reason is a sentence. A scene that diverges fails in any
/// environment. Otherwise the environment is judged first: without real-time scheduling and locked
/// memory, or if the empty loop alone missed a deadline, the verdict is inconclusive. It is a pass
/// if no tick missed under any load and no provoked tick computes for longer than the deadline.
Outcome outcome_of(const Certificate& certificate);

/// Possible causes of missed deadlines according to the counters of the system; empty without any.
std::string suspects(const Phase& phase);

/// A sentence that compares the computation time of the costliest tick with the deadline. It does
/// not depend on the environment.
std::string budget_text(const Certificate& certificate);

// The procedure: worst-case probes, then for each load the empty loop and the scene for equal
// times.

/// Progress of the procedure; written by one thread and read by another.
struct Progress {
  std::atomic<const char*> stage{"beginning"};
  std::atomic<long> done{0};
  std::atomic<long> ticks{0};  ///< of this stage; 0: not known
};

struct CertifyPlan {
  Claim claim{};
  std::vector<std::string> loads{"idle"};
  std::size_t cache_bytes = 32U << 20U;  ///< of the largest cache
  std::vector<int> isolated{};  ///< processors that the system keeps free; the loop takes one
  std::optional<double>
      tissue_stiffness{};      ///< at the tool, at rest [N/m]; for a tool without a device
  int priority = 80;           ///< of SCHED_FIFO
  bool ask_for_rights = true;  ///< false: as if the system had refused them
  const std::atomic<bool>* stop = nullptr;
  Progress* progress = nullptr;
  /// Times of the loop's processor and of all others since the start of the machine; empty: not
  /// known.
  std::function<ProcessorTimes(int processor)> processor_times{};
  device::Clock* clock = &device::monotonic_clock();  ///< of the loops
  /// A load that is not one of background_load.hpp, until what is returned is gone.
  std::function<std::shared_ptr<void>(const std::string& load, const std::vector<int>& processors)>
      outside_load{};
};

/// Changes affinity and scheduling of the calling thread: call it on one of its own. The scene must
/// be able to run at the claim's rate (why_not_at()).
Certificate certify(const Scene& scene, const CertifyPlan& plan);

}  // namespace palpate::certificate

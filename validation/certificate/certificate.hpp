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

namespace palpate::certificate {

/// Upper limit of the probability that a tick misses, after `misses` of `ticks`, one-sided (Clopper
/// & Pearson, Biometrika 26, 1934): the p for which so few misses or fewer have the chance 1 -
/// confidence. After none it is 1 - (1 - confidence)^(1/n), some 3/n at 95 %. 1 where every tick
/// missed, or none was counted. The inverse is Boost's: gsl_cdf_beta_Pinv of GSL 2.7 ends the
/// program for one miss of 1000, where its steps do not converge.
double miss_probability_upper(long misses, long ticks, double confidence = 0.95);

// A real-time certificate: what was claimed, what was measured, and whether that supports the
// claim.

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
  LoadResult(std::string name, double deadline)
      : load(std::move(name)), control(deadline), scene(deadline) {}
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

  /// The load under which least can be said for the scene: largest limit of the miss probability.
  /// None: nothing ran.
  [[nodiscard]] const LoadResult* worst() const;
};

// From what was measured to a word and a sentence.

enum class Verdict { certified, not_certified, not_qualified };

/// "certified", "not certified", "environment not qualified".
std::string_view name_of(Verdict verdict);

struct Judgement {
  Verdict verdict = Verdict::not_qualified;
  std::string reason{};  ///< one sentence
};

/// A scene that diverges is not certified anywhere. Otherwise the environment comes first: without
/// the right scheduling and locked memory, or where the empty loop alone missed, nothing is said
/// against the scene. It is certified where no tick missed under any load and no provoked tick
/// takes longer than the deadline.
Judgement judge(const Certificate& certificate);

/// Who may have stolen the time of a loop that missed, as the counters tell; empty where they tell
/// nothing.
std::string suspects(const Phase& phase);

/// What the computation alone says, whatever the environment: the costliest tick against the
/// deadline.
std::string budget_words(const Certificate& certificate);

// The whole procedure: provoke, then for every load the empty loop and the scene, both for the same
// time.

/// What whoever waits may show; written by one thread, read by another.
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

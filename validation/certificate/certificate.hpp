// SPDX-License-Identifier: MIT
#pragma once
/// Real-time certificate of a scene: its claim, the measurements under background load, the
/// verdict.

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "device/real_time.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/certificate/tail.hpp"
#include "validation/certificate/worst_case_probe.hpp"
#include "validation/outcome.hpp"

namespace palpate::certificate {

/// "idle", "cpu", "cache", "memory".
bool is_own_load(std::string_view name);
inline constexpr std::string_view own_loads = "idle, cpu, cache, memory";

/// Threads of ordinary priority that run one kind of work continuously in memory of fixed size.
class BackgroundLoad {
 public:
  /// Starts one thread pinned to each of these processors. `cache_bytes` is the size of the largest
  /// cache.
  BackgroundLoad(std::string_view name, const std::vector<int>& processors,
                 std::size_t cache_bytes);
  ~BackgroundLoad();
  BackgroundLoad(const BackgroundLoad&) = delete;
  BackgroundLoad& operator=(const BackgroundLoad&) = delete;

  [[nodiscard]] std::size_t threads() const { return threads_.size(); }
  /// Returns the number of rounds that all threads have completed.
  [[nodiscard]] long rounds() const { return rounds_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<long> rounds_{0};
  std::vector<std::thread> threads_{};
};

/// Returns the one-sided upper confidence limit of the probability that a tick misses its deadline,
/// after `misses` of `ticks` (Clopper & Pearson, Biometrika 26, 1934). Without misses it is 1 - (1
/// - confidence)^(1/n), about 3/n at 95 %. It is 1 if every tick missed or none was counted. Boost
/// computes the inverse: gsl_cdf_beta_Pinv of GSL 2.7 aborts for one miss of 1000 because its
/// iteration does not converge.
double miss_probability_upper(long misses, long ticks, double confidence = 0.95);

/// Returns the least number of ticks without a miss after which the upper limit of the miss
/// probability is at most `probability`: about 3 / probability at 95 %.
long ticks_needed(double probability, double confidence = 0.95);

// A real-time certificate: the claim, the measurements and the verdict.

struct Claim {
  double rate = 1000.0;         ///< release rate [Hz]
  double deadline = 1e-3;       ///< time from the release to the end of the tick [s]
  double duration = 10.0;       ///< requested duration of each phase [s]
  double max_miss_rate = 1e-3;  ///< largest allowed upper limit of the miss probability [1]
  long ticks_per_step = 1;      ///< the tissue is stepped in every n-th tick; the others are cheap

  [[nodiscard]] double period() const { return 1.0 / rate; }
  [[nodiscard]] long ticks() const;  ///< number of ticks in each phase
  /// Returns the least number of ticks without a miss that show the claim. Only the ticks that step
  /// the tissue are evidence.
  [[nodiscard]] long ticks_needed() const;
};

/// Processor time used by other work during a phase.
struct ProcessorTimes {
  double stolen = 0.0;      ///< by the hypervisor [s]
  double others = 0.0;      ///< busy on all other processors [s]
  double interrupts = 0.0;  ///< hardware and software interrupts [s]
};

/// Measurements of one loop under one load.
struct Phase {
  explicit Phase(double deadline) : record(deadline) {}
  LoopRecord record;
  device::ThreadCounts counts{};  ///< counts during ticks only
  ProcessorTimes times{};
  double seconds = 0.0;     ///< wall time including pauses [s]
  long restarts = 0;        ///< number of restarts of the scene
  double paused = 0.0;      ///< total pause for restarts, between ticks [s]
  bool hopeless = false;    ///< aborted because the loop was too late
  long ticks_per_step = 1;  ///< as in Claim; 1 for the empty loop

  /// Returns the upper limit of the miss probability of a tick that steps the tissue.
  [[nodiscard]] double miss_probability_upper() const;
  [[nodiscard]] long steps() const { return record.ticks() / ticks_per_step; }
};

/// Results of the empty loop and of the scene, measured one after the other under the same load.
struct LoadResult {
  LoadResult(std::string name, double deadline)
      : load(std::move(name)), control(deadline), scene(deadline) {}
  std::string load;
  Phase control;
  Phase scene;
  Tail tail{};  ///< tail of the scene's response times

  [[nodiscard]] double miss_probability_upper() const { return scene.miss_probability_upper(); }
};

/// Rights granted by the system. Each text is empty, or the reason why the right was refused.
struct Rights {
  std::string fifo{};
  std::string memory{};
  std::string idle{};  ///< processors without idle states that take time to leave
  std::string processor{};
  int on = 0;         ///< processor of the loop
  bool alone = true;  ///< the loads ran on other processors

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

/// Returns the verdict on a certificate with one sentence as its reason. A scene that diverges
/// fails in any environment. Otherwise the environment is judged first: the verdict is inconclusive
/// without real-time scheduling and locked memory, or if the empty loop missed a deadline. The
/// verdict is pass if no tick missed under any load, no worst-case probe computes for longer than
/// the deadline, the ticks under each load suffice for the claimed miss rate, and the scene reaches
/// every event that it declares.
Outcome outcome_of(const Certificate& certificate);

/// Returns the reason of a pass: this number of ticks under the worst load, of `loads` loads,
/// missed nothing; `upper` is the upper limit of the miss probability.
std::string certified_text(const Claim& claim, long ticks, double upper, std::size_t loads,
                           const std::string& load);

/// Returns possible causes of missed deadlines from the system counters; empty without any.
std::string suspects(const Phase& phase);

/// Returns a sentence that compares the computation time of the slowest tick with the deadline. It
/// does not depend on the environment.
std::string budget_text(const Certificate& certificate);

// The procedure: worst-case probes, then for each load the empty loop and the scene for equal
// times.

/// Progress of the procedure; written by one thread and read by another.
struct Progress {
  std::atomic<const char*> stage{"beginning"};
  std::atomic<long> done{0};
  std::atomic<long> ticks{0};  ///< ticks of this stage; 0: unknown
};

struct CertifyPlan {
  Claim claim{};
  std::vector<std::string> loads{"idle"};
  std::size_t cache_bytes = 32U << 20U;      ///< size of the largest cache [bytes]
  std::vector<int> isolated{};               ///< isolated processors; the loop uses one of them
  std::optional<double> tissue_stiffness{};  ///< at the tool [N/m], for a tool without a device
  int priority = 80;                         ///< SCHED_FIFO priority
  bool ask_for_rights = true;  ///< false: behave as if the system had refused the rights
  const std::atomic<bool>* stop = nullptr;
  Progress* progress = nullptr;
  /// Returns the times of the given processor and of all others since boot; empty: unknown.
  std::function<ProcessorTimes(int processor)> processor_times{};
  device::Clock* clock = &device::monotonic_clock();  ///< clock of the loops
  /// Starts a load that background_load.hpp does not provide; it runs until the returned object is
  /// destroyed.
  std::function<std::shared_ptr<void>(const std::string& load, const std::vector<int>& processors)>
      outside_load{};
  /// Creates the simulator under test in this process; empty: the model.
  std::function<std::unique_ptr<Subject>()> subject{};
};

/// Runs the certification. It changes affinity and scheduling of the calling thread, so call it on
/// a separate thread. The scene must be able to run at the claimed rate (why_not_at()).
Certificate certify(const Scene& scene, const CertifyPlan& plan);

}  // namespace palpate::certificate

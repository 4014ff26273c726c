// SPDX-License-Identifier: MIT

#include "validation/certificate/certificate.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "validation/certificate/scene_loop.hpp"
#include "validation/number_text.hpp"
#include "validation/statistics.hpp"

namespace palpate::certificate {

namespace {

constexpr std::size_t line = 8;  // doubles per cache line

void compute() noexcept {
  volatile double result = 2.0;
  for (int n = 0; n < 100000; ++n) { result = std::sqrt(result + 1.0); }
}

/// Accesses one number per cache line in an order that hardware prefetchers cannot predict.
void walk(std::vector<double>& buffer) noexcept {
  std::uint64_t place = 1;
  for (int n = 0; n < 100000; ++n) {
    place = place * 6364136223846793005U + 1442695040888963407U;
    buffer[((place >> 33U) * line) % buffer.size()] += 1.0;
  }
}

void stream(std::vector<double>& buffer, const std::atomic<bool>& stop) noexcept {
  const std::size_t half = buffer.size() / 2;
  for (std::size_t n = 0; n < half && !stop.load(std::memory_order_relaxed); ++n) {
    buffer[n] = 0.5 * buffer[n] + buffer[half + n];
  }
}

}  // namespace

bool is_own_load(std::string_view name) {
  return name == "idle" || name == "cpu" || name == "cache" || name == "memory";
}

BackgroundLoad::BackgroundLoad(std::string_view name, const std::vector<int>& processors,
                               std::size_t cache_bytes) {
  if (name == "idle") { return; }
  const std::size_t bytes = name == "memory" ? 4 * cache_bytes : cache_bytes;
  for (std::size_t n = 0; n < processors.size(); ++n) {
    threads_.emplace_back([this, name = std::string(name), processors, bytes] {
      device::pin_to(processors);
      std::vector<double> buffer(name == "cpu" ? 0 : bytes / sizeof(double), 1.0);
      while (!stop_.load(std::memory_order_relaxed)) {
        name == "cpu" ? compute() : name == "cache" ? walk(buffer) : stream(buffer, stop_);
        rounds_.fetch_add(1, std::memory_order_relaxed);
      }
    });
  }
}

BackgroundLoad::~BackgroundLoad() {
  stop_ = true;
  for (std::thread& thread : threads_) { thread.join(); }
}

double miss_probability_upper(long misses, long ticks, double confidence) {
  if (ticks <= 0 || misses >= ticks) { return 1.0; }
  if (misses == 0) { return -std::expm1(std::log1p(-confidence) / static_cast<double>(ticks)); }
  const double two_sided = 2.0 * confidence - 1.0;
  return comparison::share_interval(static_cast<std::size_t>(misses),
                                    static_cast<std::size_t>(ticks), two_sided)
      .upper;
}

long ticks_needed(double probability, double confidence) {
  return static_cast<long>(std::ceil(std::log1p(-confidence) / std::log1p(-probability)));
}

long Claim::ticks() const { return std::max(1L, std::lround(duration * rate)); }

long Claim::ticks_needed() const {
  return ticks_per_step * certificate::ticks_needed(max_miss_rate);
}

double Phase::miss_probability_upper() const {
  return certificate::miss_probability_upper(record.misses.count(), steps());
}

const LoadResult* Certificate::worst() const {
  const auto found = std::ranges::max_element(loads, {}, &LoadResult::miss_probability_upper);
  return found == loads.end() ? nullptr : &*found;
}

namespace {

constexpr double us = 1e6;

/// Formats without digit grouping, because programs read these sentences.
std::string with_unit(double value, const char* unit) {
  return plain_number(value, 6) + " " + unit;
}
std::string microseconds(double seconds) { return with_unit(us * seconds, "us"); }

std::string of_ticks(const Phase& phase) {
  return std::to_string(phase.record.misses.count()) + " of " +
         std::to_string(phase.record.ticks()) + " deadlines";
}

std::string refused_rights(const Rights& rights) {
  std::vector<std::string> refused;
  if (!rights.fifo.empty()) { refused.push_back("no SCHED_FIFO (" + rights.fifo + ")"); }
  if (!rights.memory.empty()) { refused.push_back("no locked memory (" + rights.memory + ")"); }
  return join(refused);
}

/// Returns the reason why the environment does not qualify; empty if it does.
std::string why_not_qualified(const Certificate& all) {
  if (!all.rights.all()) { return "The system grants " + refused_rights(all.rights) + "."; }
  for (const LoadResult& load : all.loads) {
    if (load.control.record.misses.count() == 0 && !load.control.hopeless) { continue; }
    const std::string who = suspects(load.control);
    return "Under load \"" + load.load + "\" the empty loop alone missed " +
           of_ticks(load.control) + ", the worst by waking " +
           microseconds(load.control.record.worst_wakeup.seconds) + " late" +
           (who.empty() ? "." : ": " + who + ".");
  }
  const LoadResult* worst = all.worst();
  if (worst == nullptr || worst->scene.record.ticks() == 0) {
    return "Interrupted before the scene ran: nothing is known of it.";
  }
  return {};
}

/// Returns what the number of ticks that step the tissue is; empty if all do.
std::string steps_in(const Claim& claim) {
  return claim.ticks_per_step == 1
             ? ""
             : ", of the one tick in " + std::to_string(claim.ticks_per_step) +
                   " that steps the tissue";
}

/// Returns the reason why the scene fails in a qualified environment; empty if it passes.
std::string why_not_certified(const Certificate& all) {
  for (const LoadResult& load : all.loads) {
    if (load.scene.record.misses.count() == 0 && !load.scene.hopeless) { continue; }
    return "Under load \"" + load.load + "\" the scene missed " + of_ticks(load.scene) +
           " while the empty loop missed none; the worst tick answered after " +
           microseconds(load.scene.record.worst_response.seconds) + ".";
  }
  if (all.budget.probes.empty()) { return "Not enough evidence: no tick was provoked."; }
  if (!(all.budget.worst() <= all.claim.deadline)) {
    const WorstCaseProbe& worst = all.budget.probes.front();
    return "Provoked, a tick (" + worst.name + ") takes " + microseconds(worst.processor) +
           " of computing alone, more than the deadline of " + microseconds(all.claim.deadline) +
           ".";
  }
  if (!all.budget.absent.empty()) {
    return "Not enough evidence: the scene ends before events that it declares: " +
           join(all.budget.absent) + ".";
  }
  const long needed = all.claim.ticks_needed();
  for (const LoadResult& load : all.loads) {
    if (load.scene.record.ticks() >= needed) { continue; }
    return "Not enough evidence: " + std::to_string(load.scene.record.ticks()) + " of the " +
           std::to_string(needed) + " ticks without a miss under load \"" + load.load +
           "\" that show fewer than one miss in " + plain_number(1.0 / all.claim.max_miss_rate, 6) +
           " with 95 % confidence" + steps_in(all.claim) + "; a duration of at least " +
           with_unit(static_cast<double>(needed) * all.claim.period(), "s") + ".";
  }
  return {};
}

Reason reason_of(const Certificate& all) {
  if (all.budget.diverged_at) {
    return {Status::fail,
            "The scene diverges at t = " + with_unit(*all.budget.diverged_at, "s") + "."};
  }
  if (std::string why = why_not_qualified(all); !why.empty()) {
    return {Status::inconclusive, std::move(why)};
  }
  if (std::string why = why_not_certified(all); !why.empty()) {
    return {Status::fail, std::move(why)};
  }
  const LoadResult& worst = *all.worst();
  return {Status::pass,
          certified_text(all.claim, worst.scene.record.ticks(), worst.miss_probability_upper(),
                         all.loads.size(), worst.load)};
}

}  // namespace

std::string certified_text(const Claim& claim, long ticks, double upper, std::size_t loads,
                           const std::string& load) {
  return "No tick of " + std::to_string(ticks) + " missed " + microseconds(claim.deadline) +
         " at " + with_unit(claim.rate, "Hz") +
         (loads > 1 ? " under any load" : " under load \"" + load + "\"") +
         ": with 95 % confidence fewer than one in " + plain_number(std::floor(1.0 / upper), 9) +
         " does" + steps_in(claim) + ".";
}

std::string_view verdict_word(Status status) {
  if (status == Status::pass) { return "certified"; }
  return status == Status::fail ? "not certified" : "environment not qualified";
}

Outcome outcome_of(const Certificate& all) {
  Outcome outcome{.name = "certificate",
                  .suite = "certificate",
                  .claim = "Every tick of the scene ends before its deadline."};
  for (const LoadResult& load : all.loads) {
    outcome.judge_at_most("missed deadlines, load " + load.load, load.scene.record.misses.count(),
                          0.0, "the claim");
  }
  if (!all.budget.probes.empty()) {
    outcome.judge_at_most("computation of the costliest provoked tick", all.budget.worst(),
                          all.claim.deadline, "the deadline", "s");
  }
  conclude(outcome, {reason_of(all)});
  return outcome;
}

std::string suspects(const Phase& phase) {
  std::vector<std::string> who;
  if (phase.times.stolen > 0.0) {
    who.push_back("the hypervisor took " + with_unit(1e3 * phase.times.stolen, "ms") +
                  " of its processor");
  }
  if (phase.counts.involuntary_switches > 0) {
    who.push_back("other threads were let in " + std::to_string(phase.counts.involuntary_switches) +
                  " times");
  }
  if (phase.counts.major_faults + phase.counts.minor_faults > 0) {
    who.push_back(std::to_string(phase.counts.major_faults + phase.counts.minor_faults) +
                  " page faults");
  }
  if (phase.times.interrupts > 0.0) {
    who.push_back("interrupts took " + with_unit(1e3 * phase.times.interrupts, "ms"));
  }
  if (phase.times.others > 0.0) {
    who.push_back("other processors were busy for " + with_unit(phase.times.others, "s") + " of " +
                  with_unit(phase.seconds, "s"));
  }
  return join(who);
}

std::string budget_text(const Certificate& all) {
  if (all.budget.probes.empty()) {
    return "No tick was provoked, so nothing is known of what one costs.";
  }
  const WorstCaseProbe& worst = all.budget.probes.front();
  const double share = worst.processor / all.claim.deadline;
  return "Whatever the environment: the costliest tick (" + worst.name + ", at " +
         with_unit(worst.scene_time, "s") + ") computes for " + microseconds(worst.processor) +
         ", " + plain_number(100.0 * share, 3) + " % of the deadline" +
         (share <= 1.0 ? "." : ": too much for any machine like this one.");
}

namespace {

/// Selects an isolated processor if there is one, else the last: the first often handles
/// interrupts.
int processor_of_loop(const std::vector<int>& allowed, const std::vector<int>& isolated) {
  for (const int n : isolated) {
    if (std::ranges::find(allowed, n) != allowed.end()) { return n; }
  }
  return allowed.empty() ? 0 : allowed.back();
}

class Certifier {
 public:
  Certifier(const Scene& scene, const CertifyPlan& plan) : scene_(scene), plan_(plan) {
    scene_.simulation.threads = 1;
    result_.claim = plan.claim;
    result_.claim.ticks_per_step = std::lround(scene.simulation.step * plan.claim.rate);
  }

  Certificate run() {
    choose_processor();
    probe_ticks();
    if (!result_.budget.diverged_at && !is_stopped()) {
      const std::unique_ptr<device::LockedMemory> locked = lock_memory();
      std::optional<device::AwakeProcessors> awake;
      if (plan_.ask_for_rights) { result_.rights.idle = awake.emplace().refusal(); }
      for (const std::string& load : plan_.loads) {
        if (!is_stopped()) { measure_under(load); }
      }
    }
    result_.interrupted = is_stopped();
    note_what_was_left_out();
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool is_stopped() const { return plan_.stop != nullptr && plan_.stop->load(); }

  void tell(const char* stage, long ticks) {
    if (plan_.progress == nullptr) { return; }
    plan_.progress->done = 0;
    plan_.progress->ticks = ticks;
    plan_.progress->stage = stage;
  }

  void choose_processor() {
    const std::vector<int> allowed = device::allowed_processors();
    result_.rights.on = processor_of_loop(allowed, plan_.isolated);
    others_ = allowed;
    std::erase(others_, result_.rights.on);
    result_.rights.alone = !others_.empty();
    if (others_.empty()) { others_ = {result_.rights.on}; }
    if (!device::pin_to({result_.rights.on})) { result_.rights.processor = std::strerror(errno); }
  }

  void probe_ticks() {
    tell("provoking worst ticks", 0);
    result_.budget = run_probes(scene_, {.rate = plan_.claim.rate,
                                         .cache_bytes = plan_.cache_bytes,
                                         .stop = plan_.stop,
                                         .subject = plan_.subject});
    if (result_.budget.diverged_at || is_stopped()) { return; }
    tell("missing one tick", 0);
    if (scene_.drive && scene_.drive->kind == Drive::Kind::falcon) {
      result_.missed_tick = measure_missed_tick(scene_, plan_.stop);
    } else if (plan_.tissue_stiffness) {
      result_.missed_tick = bounded_missed_tick(*plan_.tissue_stiffness,
                                                result_.budget.largest_speed, plan_.claim.period());
    }
  }

  std::unique_ptr<device::LockedMemory> lock_memory() {
    if (!plan_.ask_for_rights) {
      result_.rights.memory = result_.rights.fifo = result_.rights.idle = "not asked for";
      return nullptr;
    }
    auto locked = std::make_unique<device::LockedMemory>();
    result_.rights.memory = locked->refusal();
    return locked;
  }

  void measure_under(const std::string& load) {
    LoadResult& result = result_.loads.emplace_back(load, plan_.claim.deadline);
    result.scene.ticks_per_step = result_.claim.ticks_per_step;
    const std::shared_ptr<void> work = begin_load(load);
    device::touch_stack();
    measure(result.control, "the empty loop", [this](Phase& phase) { run_empty(phase); });
    if (!is_stopped()) {
      measure(result.scene, "the scene", [this](Phase& phase) { run_scene(phase); });
    }
    result.tail = judge_tail(result.scene.record.largest.sorted(), result.scene.record.ticks(),
                             plan_.claim.deadline);
  }

  std::shared_ptr<void> begin_load(const std::string& load) {
    if (is_own_load(load)) {
      return std::make_shared<BackgroundLoad>(load, others_, plan_.cache_bytes);
    }
    return plan_.outside_load ? plan_.outside_load(load, others_) : nullptr;
  }

  template <class Run> void measure(Phase& phase, const char* stage, Run&& run_phase) {
    tell(stage, plan_.claim.ticks());
    const ProcessorTimes before = processor_times();
    const double begin = plan_.clock->now();
    run_phase(phase);
    phase.seconds = plan_.clock->now() - begin;
    const ProcessorTimes after = processor_times();
    phase.times = {.stolen = after.stolen - before.stolen,
                   .others = after.others - before.others,
                   .interrupts = after.interrupts - before.interrupts};
  }

  [[nodiscard]] ProcessorTimes processor_times() const {
    return plan_.processor_times ? plan_.processor_times(result_.rights.on) : ProcessorTimes{};
  }

  /// Runs a phase at real-time priority.
  template <class Work> LoopEnd run_paced(Phase& phase, long ticks, Work&& work) {
    std::optional<device::FifoScheduling> fifo;
    if (plan_.ask_for_rights) {
      fifo.emplace(plan_.priority);
      if (fifo->refusal() != 0) { result_.rights.fifo = std::strerror(fifo->refusal()); }
    }
    PacedLoop loop{.period = plan_.claim.period(),
                   .stop = plan_.stop,
                   .done = plan_.progress != nullptr ? &plan_.progress->done : nullptr,
                   .clock = plan_.clock};
    const LoopEnd end = loop.run(ticks, phase.record, work);
    phase.counts += loop.counts;
    phase.hopeless = phase.hopeless || end == LoopEnd::hopeless;
    return end;
  }

  void run_empty(Phase& phase) {
    run_paced(phase, plan_.claim.ticks(), [](Moment&) { return true; });
  }

  /// Runs the scene repeatedly. It is rebuilt in a pause between two ticks on the same processor,
  /// so that nothing is allocated during ticks.
  void run_scene(Phase& phase) {
    LoopEnd end = LoopEnd::over;
    while (end == LoopEnd::over && phase.record.ticks() < plan_.claim.ticks()) {
      const double begin = plan_.clock->now();
      SceneLoop scene(scene_, plan_.claim.rate, {.subject = plan_.subject});
      if (phase.record.ticks() > 0) {
        ++phase.restarts;
        phase.paused += plan_.clock->now() - begin;
      }
      end = run_paced(phase, plan_.claim.ticks() - phase.record.ticks(), [&scene](Moment& moment) {
        (void)scene.tick();  // the probes report divergence
        moment = scene.moment();
        return !scene.over();
      });
    }
  }

  void note_what_was_left_out() {
    const long whole = std::lround(scene_.simulation.duration * plan_.claim.rate);
    if (plan_.claim.ticks() < whole && !result_.loads.empty()) {
      result_.notes.push_back("The loop saw the first " + std::to_string(plan_.claim.ticks()) +
                              " of the scene's " + std::to_string(whole) +
                              " ticks; the provoked ones are of all.");
    }
    if (!result_.rights.processor.empty()) {
      result_.notes.push_back(
          "The loop was not kept to one processor: " + result_.rights.processor + ".");
    }
    if (!result_.rights.alone && plan_.loads != std::vector<std::string>{"idle"}) {
      result_.notes.emplace_back("There is one processor: loads shared it with the loop.");
    }
  }

  Scene scene_;
  const CertifyPlan& plan_;
  std::vector<int> others_{};
  Certificate result_{};
};

}  // namespace

Certificate certify(const Scene& scene, const CertifyPlan& plan) {
  return Certifier(scene, plan).run();
}

}  // namespace palpate::certificate

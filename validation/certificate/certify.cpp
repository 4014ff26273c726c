// SPDX-License-Identifier: MIT
#include "validation/certificate/certify.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "validation/certificate/background_load.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace palpate::certificate {

namespace {

/// An isolated processor if there is one, else the last: the first often has the interrupts.
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
  }

  Certificate run() {
    choose_processor();
    provoke_ticks();
    if (!result_.budget.diverged_at && !is_stopped()) {
      const std::unique_ptr<device::LockedMemory> locked = lock_memory();
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
    if (!device::pin_to(result_.rights.on)) { result_.rights.processor = std::strerror(errno); }
  }

  void provoke_ticks() {
    tell("provoking worst ticks", 0);
    result_.budget =
        provoke(scene_, {.rate = plan_.claim.rate, .cache_bytes = plan_.cache_bytes, .stop = plan_.stop});
    if (result_.budget.diverged_at || is_stopped()) { return; }
    tell("missing one tick", 0);
    if (scene_.drive && scene_.drive->kind == Drive::Kind::falcon) {
      result_.missed_tick = measure_missed_tick(scene_, plan_.stop);
    } else if (plan_.tissue_stiffness) {
      result_.missed_tick =
          bounded_missed_tick(*plan_.tissue_stiffness, result_.budget.largest_speed, plan_.claim.period());
    }
  }

  std::unique_ptr<device::LockedMemory> lock_memory() {
    if (!plan_.ask_for_rights) {
      result_.rights.memory = result_.rights.fifo = "not asked for";
      return nullptr;
    }
    auto locked = std::make_unique<device::LockedMemory>();
    result_.rights.memory = locked->refusal();
    return locked;
  }

  void measure_under(const std::string& load) {
    LoadResult& result = result_.loads.emplace_back(load, plan_.claim.deadline);
    const std::shared_ptr<void> work = begin_load(load);
    device::touch_stack();
    measure(result.control, "the empty loop", [this](Phase& phase) { run_empty(phase); });
    if (!is_stopped()) {
      measure(result.scene, "the scene", [this](Phase& phase) { run_scene(phase); });
    }
    result.tail =
        judge_tail(result.scene.record.largest.sorted(), result.scene.record.ticks(), plan_.claim.deadline);
  }

  std::shared_ptr<void> begin_load(const std::string& load) {
    if (is_own_load(load)) { return std::make_shared<BackgroundLoad>(load, others_, plan_.cache_bytes); }
    return plan_.outside_load ? plan_.outside_load(load, others_) : nullptr;
  }

  template <class Run>
  void measure(Phase& phase, const char* stage, Run&& run_phase) {
    tell(stage, plan_.claim.ticks());
    const ProcessorTimes before = processor_times();
    const double begin = device::monotonic_now();
    run_phase(phase);
    phase.seconds = device::monotonic_now() - begin;
    const ProcessorTimes after = processor_times();
    phase.times = {.stolen = after.stolen - before.stolen,
                   .others = after.others - before.others,
                   .interrupts = after.interrupts - before.interrupts};
  }

  [[nodiscard]] ProcessorTimes processor_times() const {
    return plan_.processor_times ? plan_.processor_times(result_.rights.on) : ProcessorTimes{};
  }

  /// At real-time priority while it lasts.
  template <class Work>
  LoopEnd run_paced(Phase& phase, long ticks, Work&& work) {
    std::optional<device::FifoScheduling> fifo;
    if (plan_.ask_for_rights) {
      fifo.emplace(plan_.priority);
      if (fifo->refusal() != 0) { result_.rights.fifo = std::strerror(fifo->refusal()); }
    }
    PacedLoop loop{.period = plan_.claim.period(),
                   .stop = plan_.stop,
                   .done = plan_.progress != nullptr ? &plan_.progress->done : nullptr};
    const LoopEnd end = loop.run(ticks, phase.record, work);
    phase.counts += loop.counts;
    phase.hopeless = phase.hopeless || end == LoopEnd::hopeless;
    return end;
  }

  void run_empty(Phase& phase) {
    run_paced(phase, plan_.claim.ticks(), [](Moment&) { return true; });
  }

  /// Again and again from the start; it is built anew in a pause between two ticks, on the same processor, so
  /// that nothing is allocated while releases come.
  void run_scene(Phase& phase) {
    LoopEnd end = LoopEnd::over;
    while (end == LoopEnd::over && phase.record.ticks() < plan_.claim.ticks()) {
      const double begin = device::monotonic_now();
      SceneLoop scene(scene_, plan_.claim.rate);
      if (phase.record.ticks() > 0) {
        ++phase.restarts;
        phase.paused += device::monotonic_now() - begin;
      }
      end = run_paced(phase, plan_.claim.ticks() - phase.record.ticks(), [&scene](Moment& moment) {
        (void)scene.tick();  // one that diverges was told by the provocations
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
      result_.notes.push_back("The loop was not kept to one processor: " + result_.rights.processor + ".");
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

Certificate certify(const Scene& scene, const CertifyPlan& plan) { return Certifier(scene, plan).run(); }

}  // namespace palpate::certificate

// SPDX-License-Identifier: MIT
#include "validation/certificate/verdict.hpp"

#include <algorithm>

#include "validation/number_words.hpp"

namespace palpate::certificate {

namespace {

constexpr double us = 1e6;

/// Without the spaces of people's numbers: these sentences are in files that programs read.
std::string with_unit(double value, const char* unit) { return plain_number(value, 6) + " " + unit; }
std::string microseconds(double seconds) { return with_unit(us * seconds, "us"); }

std::string of_ticks(const Phase& phase) {
  return std::to_string(phase.record.misses.count()) + " of " + std::to_string(phase.record.ticks()) +
         " deadlines";
}

std::string refused_rights(const Rights& rights) {
  std::string text;
  if (!rights.fifo.empty()) { text += "no SCHED_FIFO (" + rights.fifo + ")"; }
  if (!rights.memory.empty()) {
    text += std::string(text.empty() ? "" : ", ") + "no locked memory (" + rights.memory + ")";
  }
  return text;
}

/// Why the environment cannot carry a certificate; empty where it can.
std::string why_not_qualified(const Certificate& all) {
  if (!all.rights.all()) { return "The system grants " + refused_rights(all.rights) + "."; }
  for (const LoadResult& load : all.loads) {
    if (load.control.record.misses.count() == 0 && !load.control.hopeless) { continue; }
    const std::string who = suspects(load.control);
    return "Under load \"" + load.load + "\" the empty loop alone missed " + of_ticks(load.control) +
           ", the worst by waking " + microseconds(load.control.record.worst_wakeup.seconds) + " late" +
           (who.empty() ? "." : ": " + who + ".");
  }
  const LoadResult* worst = all.worst();
  if (worst == nullptr || worst->scene.record.ticks() == 0) {
    return "Interrupted before the scene ran: nothing is known of it.";
  }
  return {};
}

/// Why the scene is not certified in an environment that could do it; empty where it is.
std::string why_not_certified(const Certificate& all) {
  for (const LoadResult& load : all.loads) {
    if (load.scene.record.misses.count() == 0 && !load.scene.hopeless) { continue; }
    return "Under load \"" + load.load + "\" the scene missed " + of_ticks(load.scene) +
           " while the empty loop missed none; the worst tick answered after " +
           microseconds(load.scene.record.worst_response.seconds) + ".";
  }
  if (!(all.budget.worst() <= all.claim.deadline)) {
    const Provocation& worst = all.budget.provocations.front();
    return "Provoked, a tick (" + worst.name + ") takes " + microseconds(worst.processor) +
           " of computing alone, more than the deadline of " + microseconds(all.claim.deadline) + ".";
  }
  return {};
}

std::string praise(const Certificate& all) {
  const LoadResult& worst = *all.worst();
  return "No tick of " + std::to_string(worst.scene.record.ticks()) + " missed " +
         microseconds(all.claim.deadline) + " at " + with_unit(all.claim.rate, "Hz") +
         (all.loads.size() > 1 ? " under any load" : " under load \"" + worst.load + "\"") +
         ": with 95 % confidence fewer than one in " + plain_number(1.0 / worst.miss_probability_upper(), 3) +
         " does.";
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::certified:
      return "certified";
    case Verdict::not_certified:
      return "not certified";
    case Verdict::not_qualified:
      break;
  }
  return "environment not qualified";
}

Judgement judge(const Certificate& all) {
  if (all.budget.diverged_at) {
    return {Verdict::not_certified,
            "The scene diverges at t = " + with_unit(*all.budget.diverged_at, "s") + "."};
  }
  if (std::string why = why_not_qualified(all); !why.empty()) { return {Verdict::not_qualified, why}; }
  if (std::string why = why_not_certified(all); !why.empty()) { return {Verdict::not_certified, why}; }
  return {Verdict::certified, praise(all)};
}

std::string suspects(const Phase& phase) {
  std::vector<std::string> who;
  if (phase.times.stolen > 0.0) {
    who.push_back("the hypervisor took " + with_unit(1e3 * phase.times.stolen, "ms") + " of its processor");
  }
  if (phase.counts.involuntary_switches > 0) {
    who.push_back("other threads were let in " + std::to_string(phase.counts.involuntary_switches) +
                  " times");
  }
  if (phase.counts.major_faults + phase.counts.minor_faults > 0) {
    who.push_back(std::to_string(phase.counts.major_faults + phase.counts.minor_faults) + " page faults");
  }
  if (phase.times.interrupts > 0.0) {
    who.push_back("interrupts took " + with_unit(1e3 * phase.times.interrupts, "ms"));
  }
  if (phase.times.others > 0.0) {
    who.push_back("other processors were busy for " + with_unit(phase.times.others, "s") + " of " +
                  with_unit(phase.seconds, "s"));
  }
  std::string text;
  for (const std::string& each : who) { text += (text.empty() ? "" : ", ") + each; }
  return text;
}

std::string budget_words(const Certificate& all) {
  if (all.budget.provocations.empty()) {
    return "No tick was provoked, so nothing is known of what one costs.";
  }
  const Provocation& worst = all.budget.provocations.front();
  const double share = worst.processor / all.claim.deadline;
  return "Whatever the environment: the costliest tick (" + worst.name + ", at " +
         with_unit(worst.scene_time, "s") + ") computes for " + microseconds(worst.processor) + ", " +
         plain_number(100.0 * share, 3) + " % of the deadline" +
         (share <= 1.0 ? "." : ": too much for any machine like this one.");
}

}  // namespace palpate::certificate

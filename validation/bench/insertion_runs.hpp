// SPDX-License-Identifier: MIT
#pragma once
/// Insertions of a needle, tick by tick: what force each had and what it cost.

#include <string>
#include <vector>

#include "model/dynamics/scene.hpp"
#include "validation/case.hpp"

namespace palpate::bench {

struct Insertion {
  std::vector<double> force{};    ///< on the hand at every tick [N]
  std::vector<double> seconds{};  ///< of the processor, for every tick
  double loading = 0.0;           ///< [s] of the processor
  bool diverged = false;
};

Insertion insert(const Scene& scene);
/// A run is the same work at the same tick every time: the least of several is what it costs.
Insertion insert_repeatedly(const Scene& scene, int repeats);

/// Over the peak of `truth`, at every tick; NaN where a run ended early.
std::vector<double> errors(const Insertion& run, const Insertion& truth);
/// How far each force lies from what `truth` goes through within a tick before or after, over its peak.
std::vector<double> errors_within_a_tick(const Insertion& run, const Insertion& truth);
/// NaN if one is.
double largest(const std::vector<double>& values);
/// What this share of the ticks takes at most [us].
double ticks_within(const Insertion& run, double share);
/// Median, hundredth and worst tick [us].
void tell_times(const Insertion& run, const std::string& of, Outcome& outcome);

}  // namespace palpate::bench

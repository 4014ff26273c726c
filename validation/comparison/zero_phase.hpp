// SPDX-License-Identifier: MIT
#pragma once
/// The one low-pass of the comparison, the same for recorded and simulated traces.

#include "validation/comparison/samples.hpp"

namespace palpate::comparison {

/// Butterworth low-pass of second order run forward and backward: no phase, gain 1 / (1 + w^4) with
/// w = tan(pi f / rate) / tan(pi cutoff / rate), so 1/2 at the cut-off, and fourth order in all. Each stretch
/// between gaps is filtered alone. Its ends are extended by their own odd reflection over three periods of
/// the cut-off (less in shorter stretches), and both runs start in the steady state of their first sample,
/// so a straight line passes unchanged to its ends. Stretches of one or two samples stay as they are.
Samples zero_phase(const Samples& samples, double cutoff);

/// True when a rate [Hz] leaves such a filter something to take away: cut-off below 0.4 of it.
bool can_filter(double cutoff, double rate);

/// Shares of the variance of white noise that pass the filter, and that stay in what it takes away.
struct NoiseShares {
  double passed = 1.0;
  double removed = 0.0;
};
NoiseShares noise_shares(double cutoff, double rate);

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// Reconstruction of an insertion from a few published numbers, if the recording itself is not
/// published: straight lines from the plateau in the interspinous ligament over the peak in the
/// ligamentum flavum to the epidural space.

#include <cstdint>
#include <vector>

#include "model/problem/recording.hpp"

namespace palpate {

struct InsertionOutline {
  double plateau = 0.0;  ///< in the interspinous ligament [Pa]
  double peak = 0.0;     ///< at the far side of the ligamentum flavum [Pa]
  double floor = 0.0;    ///< in the epidural space [Pa]

  double start = 0.0;         ///< depth of the tip when the syringe is attached [m]
  double flavum_begin = 0.0;  ///< [m]
  double flavum_end = 0.0;    ///< [m]

  enum class Technique { continuous, intermittent } technique = Technique::continuous;
  double speed = 2e-3;              ///< before the ligamentum flavum [m/s]
  double flavum_speed = 1e-3;       ///< [m/s]
  double largest_advance = 1.5e-3;  ///< intermittent: between two tests [m]
  double pressure_left = 0.3;       ///< intermittent: while advancing, of that under the thumb [1]
  double fall = 0.1;                ///< duration of the loss of resistance [s]
  double hold = 7.0;                ///< time at the floor [s]

  double tremor = 0.0;  ///< amplitude relative to the pressure [1]; decreases to 0 towards the peak
  double noise = 0.0;   ///< SD [Pa]
  double sample_rate = 120.0;  ///< [Hz]
  std::uint64_t seed = 1;      ///< seed of tremor and noise
};

/// Returns a recording with time, pressure, depth, technique and sample rate. Pressure is rounded
/// to the 0.1 mmHg of the raw link and depth to 0.01 mm.
Recording draw_insertion(const InsertionOutline& outline);

/// Returns evenly spaced numbers with mean 0 and sample standard deviation 1 in a seeded random
/// order. A group that is scaled with them has exactly the required mean and SD.
std::vector<double> even_scores(std::size_t count, std::uint64_t seed);

}  // namespace palpate

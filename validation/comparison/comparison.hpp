// SPDX-License-Identifier: MIT
#pragma once
/// One recording against one simulated insertion. The verdict comes from features alone (and, with several
/// recordings, from the corridor: group_comparison.hpp); ratings and distances explain it.

#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/recording.hpp"
#include "model/dynamics/trace.hpp"
#include "validation/comparison/alignment.hpp"
#include "validation/comparison/iso_rating.hpp"
#include "validation/comparison/tolerance.hpp"
#include "validation/comparison/trace_errors.hpp"
#include "validation/comparison/verdict.hpp"

namespace palpate::comparison {

/// What is known of the numbers apart from their noise; all standard uncertainties.
struct Uncertainties {
  double zero = 57.0;              ///< u_D [Pa]: the transducer within 1 cm of the needle's height, uniform
  double zero_force = 0.0;         ///< u_D [N]: of the force sensor's zero (not stated by recordings)
  double gain = 0.01;              ///< u_D [1]: assumed, no recording states it
  double numerical = 0.0;          ///< u_num [1] of simulated values, beside sampling
  double input = 0.0;              ///< u_input [1] of simulated values; 0 when nobody propagated inputs
  double coverage_factor = 2.0;    ///< U = k u_val, about 95 %
};

struct ComparisonOptions {
  QuantityKind quantity = QuantityKind::pressure;
  std::string column{};        ///< of the simulated trace; empty: "syringe.pressure_pa" or "tool.force_n"
  std::string depth_column = "tool.depth_m";
  Recording::Regime simulated_regime = Recording::Regime::thumb;
  AlignmentRule alignment = AlignmentRule::automatic;
  double cutoff = 20.0;        ///< [Hz] of the low-pass, at most a quarter of the lower rate; 0: none
  double grid_rate = 200.0;    ///< [Hz] most of the common grid; the recording's own if that is lower
  std::size_t most_samples = 12000;  ///< of the common grid, which is made coarser for longer traces
  double least_overlap = 1.0;  ///< [s]
  FeatureRule features{};
  std::vector<Tolerance> tolerances{};  ///< those given replace the defaults of their features
  Uncertainties uncertainties{};
};

/// Of the simulated trace that is compared.
std::string column_of(const ComparisonOptions& options);

struct FeatureVerdict {
  Feature feature{};
  std::string unit{};
  Measured recorded{};
  Measured simulated{};
  double error = not_measured;        ///< E = S - D
  Tolerance tolerance{};
  double lower = not_measured;        ///< what S may be
  double upper = not_measured;
  ValidationUncertainty uncertainty{};
  double expanded = 0.0;              ///< k u_val
  bool below_uncertainty = false;     ///< |E| < u_val: E says nothing about the model
  Verdict verdict = Verdict::not_judged;
  std::string reason{};               ///< of a verdict that no numbers explain
};

struct Comparison {
  std::string recording{};
  std::string group{};
  std::string subject{};                ///< a code; empty: of whom there is no other recording
  Recording::Kind kind = Recording::Kind::measured;
  Verdict verdict = Verdict::not_comparable;
  std::vector<std::string> reasons{};   ///< why; for people
  std::string unit{};
  Alignment alignment{};
  double cutoff = 0.0;                  ///< [Hz] that was used; 0: none
  double overlap = 0.0;                 ///< [s] of both on the common grid
  std::vector<FeatureVerdict> features{};
  Features recorded_features{};         ///< on the recording's own clock
  Features simulated_features{};        ///< on the simulation's
  TraceErrors errors{};                 ///< of the filtered traces
  std::optional<IsoRating> rating{};    ///< of the filtered traces
  std::optional<IsoRating> unfiltered_rating{};
  double rated = 0.0;  ///< share of the overlap that was rated: its longest stretch without a gap
  /// On the common grid and the simulation's clock; filtered, and as sampled.
  Samples recorded{}, simulated{}, recorded_raw{}, simulated_raw{};
};

Comparison compare(const Recording& recording, const Trace& simulated, const ComparisonOptions& options = {});

}  // namespace palpate::comparison

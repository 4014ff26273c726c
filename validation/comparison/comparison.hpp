// SPDX-License-Identifier: MIT
#pragma once
/// Comparison of one recording with one simulated insertion: tolerances, alignment of clocks,
/// features and verdicts.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"
#include "validation/comparison/features.hpp"
#include "validation/comparison/iso_rating.hpp"
#include "validation/outcome.hpp"
#include "validation/signal.hpp"
#include "validation/statistics.hpp"

namespace palpate::comparison {

struct FieldUnit {
  double factor = 1.0;  ///< value in this unit over value in SI
  std::string name{};
};

/// Returns the clinical unit for "Pa", "Pa/s" and "m"; other units are unchanged.
inline FieldUnit field_unit(std::string_view unit) {
  if (unit == "Pa") { return {1.0 / pascals_per_mmhg, "mmHg"}; }
  if (unit == "Pa/s") { return {1.0 / pascals_per_mmhg, "mmHg/s"}; }
  if (unit == "m") { return {1e3, "mm"}; }
  return {1.0, std::string(unit)};
}

// Tolerances of features and their sources.

/// Kind of quantity that is compared: saline pressure [Pa]; force along the needle [N] with the
/// features of a loss of resistance; or the same force with those of an insertion: puncture,
/// relaxation and withdrawal.
enum class QuantityKind { pressure, force, insertion };
std::string_view unit_of(QuantityKind kind);  ///< "Pa", "N", "N"
std::string_view name_of(QuantityKind kind);  ///< "pressure", "force", "insertion"
/// Returns the features that are compared.
std::span<const Feature> features_of(QuantityKind kind);

/// Tolerance of a feature. The allowed interval is D - a to D + a with a = absolute + relative |D|
/// for the recorded value D; with a factor f > 1 it is D / f to D f.
struct Tolerance {
  Feature feature{};
  double absolute = 0.0;  ///< in the feature's unit
  double relative = 0.0;
  double factor = 0.0;
  std::string origin{};  ///< publication, or "assumption: ..."

  [[nodiscard]] double lower(double recorded) const;
  [[nodiscard]] double upper(double recorded) const;
};

/// Returns the default tolerance of every feature of the kind, in the order of Feature.
std::vector<Tolerance> default_tolerances(QuantityKind kind);

/// Returns the name of the status of a comparison: "agrees" within the tolerance at both ends of
/// the expanded uncertainty; "differs" outside at both ends; "not distinguishable" if it contains a
/// limit; "not comparable" for an error; "not judged" if the feature is absent or determined by the
/// alignment.
std::string_view verdict_word(Status status);

/// Standard uncertainties of ASME V&V 20. The error E = S - D has the uncertainty u_val =
/// sqrt(num^2 + input^2 + data^2); a smaller error is no evidence about the model.
struct ValidationUncertainty {
  double numerical = 0.0;  ///< u_num, of the simulated value: step, sampling
  double input = 0.0;      ///< u_input, of the inputs of the simulation
  double data = 0.0;       ///< u_D, of the recorded value: noise, sampling, transducer
  [[nodiscard]] double total() const;
};

// Alignment of the clocks of a recording and a simulation.

enum class AlignmentRule {
  automatic,  ///< depth if both have it without a gap there, else the event in both, else the start
  depth,      ///< same depth at the recorded event, else at the middle of the common depths
  event,      ///< loss of resistance if both show one, else the peak
  start,      ///< the first samples coincide
  contact,    ///< the needle touches the tissue; the automatic rule of an insertion
  clock,      ///< the clocks coincide as recorded, without a shift
};
std::string_view name_of(AlignmentRule rule);

struct Alignment {
  AlignmentRule used = AlignmentRule::start;  ///< never automatic
  std::string how{};                          ///< text for readers, "by the loss of resistance"
  double lag = 0.0;            ///< recorded minus simulated time of the same instant [s]
  double uncertainty = 0.0;    ///< [s] standard
  std::string not_by_depth{};  ///< why depth was not used although both have it; part of `how`
  std::string refusal{};       ///< why the requested rule cannot be applied
  /// Returns true if instants can be judged. Alignment by the event makes them equal. After
  /// alignment by depth, the depth of the event is judged instead because hands move at different
  /// speeds.
  [[nodiscard]] bool judges_times() const {
    return used == AlignmentRule::start || used == AlignmentRule::clock;
  }
};

/// Aligns two traces with features. The lag is not optimised for a better fit.
Alignment align(const PreparedTrace& recorded, const PreparedTrace& simulated, AlignmentRule rule);

// Comparison of one recording with one simulated insertion. Only features decide the verdict (and,
// with several recordings, the corridor: group_comparison.hpp); ratings and distances explain it.

/// Standard uncertainties of the values, apart from their noise.
struct Uncertainties {
  TransducerUncertainty transducer{};  ///< u_D
  double zero_force = 0.0;  ///< u_D [N]: zero of the force sensor (not stated by recordings)
  double numerical = 0.0;   ///< u_num [1] of simulated values, in addition to sampling
  double input = 0.0;       ///< u_input [1] of simulated values; 0 if inputs were not propagated
  double coverage_factor = 2.0;  ///< U = k u_val, about 95 %
};

struct ComparisonOptions {
  QuantityKind quantity = QuantityKind::pressure;
  std::string column{};        ///< of the simulated trace; empty: that of `quantity`
  std::string depth_column{};  ///< of the simulated trace; empty: depth_column_of()
  Recording::Regime simulated_regime = Recording::Regime::thumb;
  AlignmentRule alignment = AlignmentRule::automatic;
  double cutoff = 20.0;      ///< [Hz] of the low-pass, at most a quarter of the lower rate; 0: none
  double grid_rate = 200.0;  ///< [Hz] of the common grid, at most that of the recording
  std::size_t most_samples = 12000;  ///< of the common grid, which is coarser for longer traces
  double least_overlap = 1.0;        ///< [s]
  FeatureRule features{};
  std::vector<Tolerance> tolerances{};  ///< replace the defaults of their features
  Uncertainties uncertainties{};
};

/// Returns the column of the simulated trace that is compared: "syringe.pressure_pa" or
/// "tool.force_n" by default.
std::string column_of(const ComparisonOptions& options);

/// Returns the column of the simulated depth: "tool.depth_m" by default. Of an insertion, which is
/// recorded along the needle, "tool.insertion_m" if the trace has it; both are the same without a
/// tilt.
std::string depth_column_of(const ComparisonOptions& options, const Trace& simulated);

/// Comparison of one feature of both traces.
struct FeatureComparison {
  Feature feature{};
  Measured recorded{};
  Measured simulated{};
  double error = not_measured;  ///< E = S - D
  Tolerance tolerance{};
  /// The simulated value, its allowed interval, and the expanded uncertainty k u_val.
  Quantity quantity{.value = not_measured, .lower = not_measured, .upper = not_measured};
  ValidationUncertainty uncertainty{};
  bool below_uncertainty = false;  ///< |E| < u_val: E says nothing about the model
  Status status = Status::skip;
  std::string reason{};  ///< reason for a status that the numbers do not explain
};

struct Comparison {
  std::string recording{};
  std::string group{};
  std::string subject{};  ///< a code; empty: a subject without other recordings
  Recording::Kind kind = Recording::Kind::measured;
  Outcome outcome{.status = Status::error};  ///< quantities are the features judged numerically
  std::string unit{};
  Alignment alignment{};
  double cutoff = 0.0;                        ///< [Hz] cut-off that was used; 0: none
  double overlap = 0.0;                       ///< [s] overlap of both traces on the common grid
  std::vector<FeatureComparison> features{};  ///< in the order of features_of()
  /// Returns the comparison of a feature of the compared kind.
  [[nodiscard]] const FeatureComparison& of(Feature feature) const;
  Features recorded_features{};       ///< features on the clock of the recording
  Features simulated_features{};      ///< features on the clock of the simulation
  TraceErrors errors{};               ///< for the filtered traces
  std::optional<IsoRating> rating{};  ///< for the filtered traces
  std::optional<IsoRating> unfiltered_rating{};
  double rated = 0.0;  ///< share of the overlap rated: its longest stretch without a gap [1]
  /// True if every judged feature agrees and the curve does not; the outcome is then a failure.
  bool only_curve_differs = false;
  /// Traces on the common grid and the clock of the simulation: filtered, and as sampled.
  Samples recorded{}, simulated{}, recorded_raw{}, simulated_raw{};
  /// Filtered force of the advance of an insertion over the depth below the contact: start and step
  /// are depths [m].
  Samples recorded_advance{}, simulated_advance{};
};

/// Verdict on a comparison whose features agree and whose curve does not.
inline constexpr std::string_view only_curve_text = "features agree, curve does not";

Comparison compare(const Recording& recording, const Trace& simulated,
                   const ComparisonOptions& options = {});

/// Compares the features again and replaces the verdict of a comparison that is not an error.
void judge_again(Comparison& comparison, const ComparisonOptions& options);

/// Compares the features of a comparison after alignment.
std::vector<FeatureComparison> compare_features(const Comparison& comparison,
                                                const ComparisonOptions& options);

/// Compares two values of the feature using its tolerance and u_val; the status is error if one of
/// these is not finite.
void judge_difference(FeatureComparison& one, double recorded, double simulated,
                      double coverage_factor);

/// Returns the status of the feature, with a sentence unless it agrees or is not judged.
Reason reason_of(const FeatureComparison& one);

/// Returns the given tolerance of the feature, or else its default.
Tolerance tolerance_of(Feature feature, const ComparisonOptions& options);

/// Returns u_D of one recorded feature: noise and sampling, and zero and gain of the transducer.
double data_uncertainty(Feature feature, const Features& recorded,
                        const ComparisonOptions& options);

/// Returns the name for readers, "loss of resistance" for "loss_of_resistance".
std::string in_words(Feature feature);

/// Returns the text of a feature value [SI] in its clinical unit, rounded to a ten-thousandth of
/// that unit; "found" or "not found" for an event, "-" for NaN.
std::string shown(Feature feature, double value, std::string_view unit);
/// Returns the text of an interval, "300 to 367 mmHg".
std::string shown_interval(Feature feature, const Interval& interval, std::string_view unit);
/// Returns the text of the expanded uncertainty with sign and unit; empty if it is 0.
std::string shown_uncertainty(const FeatureComparison& one);
/// Returns the text of a tolerance, "10.2 %", "7 mmHg", "a factor of 2".
std::string shown(const Tolerance& tolerance, std::string_view unit);

/// Returns the sentence of a feature, "peak: 398 mmHg simulated, 461 mmHg recorded; 414 to 508 mmHg
/// allowed, known to ±9.3 mmHg: differs"
std::string sentence_of(const FeatureComparison& one);

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#pragma once
/// What a pressure transducer left behind: a measured insertion, or one rebuilt from published values.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace palpate {

/// What was found wrong with the samples when they were read; nothing of it is mended.
struct RecordingDefects {
  std::size_t missing = 0;         ///< samples that never arrived; time goes on, no row stands for them
  std::size_t gaps = 0;            ///< places where they are missing
  std::size_t bad_frames = 0;      ///< of the raw link, that failed their check or were cut short
  std::size_t not_finite = 0;      ///< samples without a number; they stay in as NaN
  std::size_t out_of_range = 0;    ///< told so by the transducer, or beyond what one can measure
  std::size_t clipped = 0;         ///< samples of a flat top at the largest or smallest value
  std::size_t not_increasing = 0;  ///< rows whose time does not come after the row before; left out
  std::size_t battery_low = 0;     ///< samples whose transducer said that its battery is low
  bool operator==(const RecordingDefects&) const = default;
};

struct Recording {
  enum class Kind { measured, reconstructed };
  /// Never compared with each other: the pressure of a thumb on the plunger, of a pump that injects.
  enum class Regime { thumb, pump };

  std::string name{};    ///< for people, as "bmi-18-continuous-03"
  Kind kind = Kind::measured;
  Regime regime = Regime::thumb;
  std::string source{};  ///< publication, hospital, device
  std::string note{};    ///< what else a reader must know; of a reconstructed one, from what it was rebuilt
  std::string group{};   ///< of subjects that belong together, as "BMI 18-24.9"
  /// Who was recorded, as a code that names nobody, so that several recordings of one count once; empty:
  /// somebody of whom there is no other recording.
  std::string subject{};
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::string technique{};                  ///< "continuous", "intermittent" or empty
  double plunger_area = 1.767e-4;           ///< [m^2]
  double sample_rate = 0.0;                 ///< nominal [Hz]

  std::vector<double> time{};      ///< [s], strictly increasing
  std::vector<double> pressure{};  ///< gauge [Pa], one per time; NaN where none was measured
  std::vector<double> depth{};     ///< of the tip below the skin [m]; empty: not recorded
  std::vector<double> force{};     ///< along the needle [N]; empty: not recorded
  RecordingDefects defects{};
};

}  // namespace palpate

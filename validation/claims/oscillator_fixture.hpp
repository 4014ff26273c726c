// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the oscillator cases: the settings of the paper, runs and figures.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "reference/oscillator.hpp"
#include "validation/case.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

namespace palpate::oscillator {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Damping c [N s/m] of the paper with m = 1 kg, k = 1 N/m, over 25 s (Figs. 6-10).
inline constexpr std::array paper_viscosities{0.1, 0.3, 0.7, 1.0, 1.4, 1.8};
inline constexpr std::array paper_steps{0.25, 0.1};  ///< h [s]
inline constexpr double paper_duration = 25.0;       ///< [s]

/// Damping values of the paper and 0, 2 (critical) and 3 (overdamped).
inline constexpr std::array swept_viscosities{0.0, 0.1, 0.3, 0.7, 1.0, 1.4, 1.8, 2.0, 3.0};

/// Returns the oscillator with x0 = 1 m, v0 = 0.
Oscillator paper_oscillator(double viscosity);
/// Returns the oscillator driven by cos(0.8 t) N, c = 0.7 N s/m.
Oscillator driven_oscillator();

struct Samples {
  std::vector<double> time{};      ///< [s]
  std::vector<double> position{};  ///< [m]
  std::vector<double> velocity{};  ///< [m/s]
  bool diverged = false;
};
/// Runs `steps` steps of h [s] with the model.
Samples run(const CaseContext& context, const Oscillator& oscillator, std::string_view scheme,
            double h, long steps);
Samples exact_samples(const Oscillator& oscillator, const std::vector<double>& time);
std::vector<double> equation_6_samples(const Oscillator& oscillator,
                                       const std::vector<double>& time);
/// Returns the positions of the closed form of a scheme (reference/discrete.hpp).
std::vector<double> closed_positions(std::string_view scheme, const Oscillator& oscillator,
                                     double h, long steps);

/// Returns the root mean square of a - b; NaN if the lengths differ or a value is not finite.
double rms_distance(const std::vector<double>& a, const std::vector<double>& b);
/// Returns the largest |a - b| over the largest |b|; NaN likewise.
double peak_distance(const std::vector<double>& a, const std::vector<double>& b);

/// State weighted so that k = m = 1: (x, v / omega0).
double natural_frequency(const Oscillator& oscillator);

/// Invariants of the matrix of one step, x(n+1) = trace x(n) - determinant x(n-1), from a
/// least-squares fit to a curve. `condition` is the amplification of rounding by the fit.
struct Recurrence {
  double trace = 0.0;
  double determinant = 0.0;
  double condition = 0.0;
};
Recurrence identify_recurrence(const std::vector<double>& x);

inline std::string text(double value) { return plain_number(value, 6); }
std::string id_of(std::string_view words);  ///< an id from words

}  // namespace palpate::oscillator

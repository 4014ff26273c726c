// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the oscillator cases: the settings of the paper, runs and figures.

#include <Eigen/Core>
#include <Eigen/SVD>
#include <array>
#include <cmath>
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
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Damping c [N s/m] of the paper with m = 1 kg, k = 1 N/m, over 25 s (Figs. 6-10).
inline constexpr std::array paper_viscosities{0.1, 0.3, 0.7, 1.0, 1.4, 1.8};
inline constexpr std::array paper_steps{0.25, 0.1};  ///< h [s]
inline constexpr double paper_duration = 25.0;       ///< [s]

/// Damping values of the paper and 0, 2 (critical) and 3 (overdamped).
inline constexpr std::array swept_viscosities{0.0, 0.1, 0.3, 0.7, 1.0, 1.4, 1.8, 2.0, 3.0};

/// Returns the oscillator with x0 = 1 m, v0 = 0.
inline Oscillator paper_oscillator(double viscosity) {
  return {.mass = 1.0, .stiffness = 1.0, .viscosity = viscosity, .displacement = 1.0};
}

/// Returns the oscillator driven by cos(0.8 t) N, c = 0.7 N s/m.
inline Oscillator driven_oscillator() {
  Oscillator driven = paper_oscillator(0.7);
  driven.drive_amplitude = 1.0;
  driven.drive_frequency = 0.8;
  return driven;
}

struct Samples {
  std::vector<double> time{};      ///< [s]
  std::vector<double> position{};  ///< [m]
  std::vector<double> velocity{};  ///< [m/s]
  bool diverged = false;
};
/// Runs `steps` steps of h [s] with the model.
inline Samples run(const CaseContext& context, const Oscillator& oscillator,
                   std::string_view scheme, double h, long steps) {
  Scene scene = scene_of(std::string(scheme), h, static_cast<double>(steps) * h);
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = oscillator;
  const Trace motion = roll_out(context, scene, {.position = true, .velocity = true});
  return {.time = motion.time,
          .position = {motion.position.data(), motion.position.data() + motion.position.size()},
          .velocity = {motion.velocity.data(), motion.velocity.data() + motion.velocity.size()},
          .diverged = motion.diverged};
}

inline Samples exact_samples(const Oscillator& oscillator, const std::vector<double>& time) {
  Samples samples{.time = time};
  for (const double t : time) {
    const reference::OscillatorState state = reference::exact_motion(oscillator, t);
    samples.position.push_back(state.position);
    samples.velocity.push_back(state.velocity);
  }
  return samples;
}

inline std::vector<double> equation_6_samples(const Oscillator& oscillator,
                                              const std::vector<double>& time) {
  std::vector<double> x;
  for (const double t : time) {
    x.push_back(reference::equation_6_plotted(oscillator, oscillator.displacement, 0.0, t));
  }
  return x;
}

/// Returns the positions of the closed form of a scheme (reference/discrete.hpp).
inline std::vector<double> closed_positions(std::string_view scheme, const Oscillator& oscillator,
                                            double h, long steps) {
  std::vector<double> x;
  for (long n = 0; n <= steps; ++n) {
    x.push_back(static_cast<double>(reference::discrete_state(scheme, oscillator, h, n)(0)));
  }
  return x;
}

/// Returns the root mean square of a - b; NaN if the lengths differ or a value is not finite.
inline double rms_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) { return nan; }
  double sum = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) { sum += (a[n] - b[n]) * (a[n] - b[n]); }
  return std::isfinite(sum) ? std::sqrt(sum / static_cast<double>(a.size())) : nan;
}

/// Returns the largest |a - b| over the largest |b|; NaN likewise.
inline double peak_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) { return nan; }
  Largest distance;
  Largest peak;
  for (std::size_t n = 0; n < a.size(); ++n) {
    distance.add(std::abs(a[n] - b[n]));
    peak.add(std::abs(b[n]));
  }
  return distance.value() / peak.value();
}

/// State weighted so that k = m = 1: (x, v / omega0).
inline double natural_frequency(const Oscillator& oscillator) {
  return std::sqrt(oscillator.stiffness / oscillator.mass);
}

/// Invariants of the matrix of one step, x(n+1) = trace x(n) - determinant x(n-1), from a
/// least-squares fit to a curve. `condition` is the amplification of rounding by the fit.
struct Recurrence {
  double trace = 0.0;
  double determinant = 0.0;
  double condition = 0.0;
};
inline Recurrence identify_recurrence(const std::vector<double>& x) {
  if (x.size() < 6) { return {nan, nan, nan}; }
  // Rows (x(n), x(n-1)) differ little at small steps; sums and differences are better scaled.
  const auto rows = static_cast<Eigen::Index>(x.size()) - 2;
  Eigen::MatrixXd a(rows, 2);
  Eigen::VectorXd b(rows);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const auto i = static_cast<std::size_t>(n);
    a.row(n) << 0.5 * (x[i + 1] + x[i]), x[i + 1] - x[i];
    b(n) = x[i + 2];
  }
  if (!a.allFinite() || !b.allFinite()) { return {nan, nan, nan}; }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::Vector2d c = svd.solve(b);  // c0/2 + c1 = trace, c0/2 - c1 = -determinant
  return {0.5 * c(0) + c(1), c(1) - 0.5 * c(0), svd.singularValues()(0) / svd.singularValues()(1)};
}

inline std::string text(double value) { return plain_number(value, 6); }
inline std::string id_of(std::string_view words) {
  std::string id;
  for (const char c : words) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (plain) {
      id += c;
    } else if (!id.empty() && id.back() != '-') {
      id += '-';
    }
  }
  return id;
}
///< an id from words

}  // namespace palpate::oscillator

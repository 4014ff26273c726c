// SPDX-License-Identifier: MIT

#include "validation/claims/oscillator_fixture.hpp"

#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "reference/oscillator.hpp"

namespace palpate::oscillator {

namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
}

Oscillator paper_oscillator(double viscosity) {
  return {.mass = 1.0, .stiffness = 1.0, .viscosity = viscosity, .displacement = 1.0};
}

Oscillator driven_oscillator() {
  Oscillator driven = paper_oscillator(0.7);
  driven.drive_amplitude = 1.0;
  driven.drive_frequency = 0.8;
  return driven;
}

Samples run(const CaseContext& context, const Oscillator& oscillator, std::string_view scheme,
            double h, long steps) {
  Scene scene = scene_of(std::string(scheme), h, static_cast<double>(steps) * h);
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = oscillator;
  const Trace motion = roll_out(context, scene, {.position = true, .velocity = true});
  return {.time = motion.time,
          .position = {motion.position.data(), motion.position.data() + motion.position.size()},
          .velocity = {motion.velocity.data(), motion.velocity.data() + motion.velocity.size()},
          .diverged = motion.diverged};
}

Samples exact_samples(const Oscillator& oscillator, const std::vector<double>& time) {
  Samples samples{.time = time};
  for (const double t : time) {
    const reference::OscillatorState state = reference::exact_motion(oscillator, t);
    samples.position.push_back(state.position);
    samples.velocity.push_back(state.velocity);
  }
  return samples;
}

std::vector<double> equation_6_samples(const Oscillator& oscillator,
                                       const std::vector<double>& time) {
  std::vector<double> x;
  for (const double t : time) {
    x.push_back(reference::equation_6_plotted(oscillator, oscillator.displacement, 0.0, t));
  }
  return x;
}

std::vector<double> closed_positions(std::string_view scheme, const Oscillator& oscillator,
                                     double h, long steps) {
  std::vector<double> x;
  for (long n = 0; n <= steps; ++n) {
    x.push_back(static_cast<double>(reference::discrete_state(scheme, oscillator, h, n)(0)));
  }
  return x;
}

double rms_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) { return nan; }
  double sum = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) { sum += (a[n] - b[n]) * (a[n] - b[n]); }
  return std::isfinite(sum) ? std::sqrt(sum / static_cast<double>(a.size())) : nan;
}

double peak_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size() || a.empty()) { return nan; }
  Largest distance;
  Largest peak;
  for (std::size_t n = 0; n < a.size(); ++n) {
    distance.add(std::abs(a[n] - b[n]));
    peak.add(std::abs(b[n]));
  }
  return distance.value() / peak.value();
}

double natural_frequency(const Oscillator& oscillator) {
  return std::sqrt(oscillator.stiffness / oscillator.mass);
}

Recurrence identify_recurrence(const std::vector<double>& x) {
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

std::string id_of(std::string_view words) {
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

}  // namespace palpate::oscillator

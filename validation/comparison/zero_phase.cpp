// SPDX-License-Identifier: MIT
#include "validation/comparison/zero_phase.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::comparison {

namespace {

/// Second-order Butterworth by the bilinear transform, its cut-off prewarped.
struct Biquad {
  double b0 = 1.0;
  double a1 = 0.0;
  double a2 = 0.0;

  /// In place; starts as if the first value had always been there.
  void run(std::span<double> value) const {
    double late = (b0 - a2) * value.front();
    double later = (1.0 - b0) * value.front();
    for (double& v : value) {
      const double in = v;
      v = b0 * in + later;
      later = 2.0 * b0 * in - a1 * v + late;
      late = b0 * in - a2 * v;
    }
  }
};

Biquad butterworth(double cutoff, double rate) {
  const double k = std::tan(std::numbers::pi * cutoff / rate);
  const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * k + k * k);
  return {k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - std::numbers::sqrt2 * k + k * k) * norm};
}

void filter_stretch(std::span<double> value, const Biquad& filter, std::size_t wanted) {
  if (value.size() < 3) { return; }
  const std::size_t pad = std::min(wanted, value.size() - 1);
  std::vector<double> work(value.size() + 2 * pad);
  const std::size_t last = value.size() - 1;
  for (std::size_t n = 1; n <= pad; ++n) {
    work[pad - n] = 2.0 * value[0] - value[n];
    work[pad + last + n] = 2.0 * value[last] - value[last - n];
  }
  std::ranges::copy(value, work.begin() + static_cast<std::ptrdiff_t>(pad));
  filter.run(work);
  std::ranges::reverse(work);
  filter.run(work);
  std::ranges::reverse(work);
  std::copy_n(work.begin() + static_cast<std::ptrdiff_t>(pad), value.size(), value.begin());
}

}  // namespace

bool can_filter(double cutoff, double rate) { return cutoff > 0.0 && cutoff < 0.4 * rate; }

Samples zero_phase(const Samples& samples, double cutoff) {
  const double rate = 1.0 / samples.step;
  if (!can_filter(cutoff, rate)) { return samples; }
  const Biquad filter = butterworth(cutoff, rate);
  const auto pad = static_cast<std::size_t>(std::ceil(3.0 * rate / cutoff));
  Samples filtered = samples;
  for (const Stretch& stretch : finite_stretches(samples.value)) {
    filter_stretch(std::span(filtered.value).subspan(stretch.begin, stretch.size()), filter, pad);
  }
  return filtered;
}

NoiseShares noise_shares(double cutoff, double rate) {
  if (!can_filter(cutoff, rate)) { return {}; }
  const double k = std::tan(std::numbers::pi * cutoff / rate);
  constexpr int count = 2000;
  NoiseShares shares{.passed = 0.0, .removed = 0.0};
  for (int n = 0; n < count; ++n) {
    const double w = std::tan(0.5 * std::numbers::pi * (n + 0.5) / count) / k;
    const double gain = 1.0 / (1.0 + std::pow(w, 4));
    shares.passed += gain * gain / count;
    shares.removed += (1.0 - gain) * (1.0 - gain) / count;
  }
  return shares;
}

}  // namespace palpate::comparison

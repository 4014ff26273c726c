// SPDX-License-Identifier: MIT
#pragma once
/// Force of a needle insertion with known features.

#include <cmath>
#include <string>
#include <vector>

#include "model/problem/recording.hpp"
#include "model/problem/trace.hpp"

namespace palpate {

/// The needle advances from `start` above the tissue to `end`, rests and is withdrawn to the start.
/// From the contact on the force is preload or k d^exponent, whichever is larger; the preload is
/// above the threshold of contact, so that the contact is found at d = 0, through a filter as well.
/// k d^exponent exceeds it before a tenth of the dent, from which the exponent is measured.
struct InsertionLaw {
  double rate = 100.0;    ///< [Hz]
  double speed = 2e-3;    ///< [m/s]
  double start = 5e-3;    ///< [m] above the tissue
  double end = 20e-3;     ///< [m]
  double hold = 5.5;      ///< [s]
  double preload = 0.12;  ///< [N]
  double exponent = 1.4;
  double dent = 12e-3;           ///< [m]
  double puncture = 5.0;         ///< [N]
  double left = 2.0;             ///< [N]
  double fall = 0.4e-3;          ///< [m] over which the force falls
  double rise = 150.0;           ///< [N/m] after the fall
  double relaxed = 0.4;          ///< share of the force that is lost in an endless hold
  double relaxation_time = 1.2;  ///< [s]
  double pulled = -1.5;          ///< [N] least force of the withdrawal
  double pulled_at = 15e-3;      ///< [m]
  double factor = 1.0;           ///< on all forces but the preload

  [[nodiscard]] double advance(double depth) const {
    if (depth < 0.0) { return 0.0; }
    if (depth <= dent) {
      return std::fmax(preload, factor * puncture * std::pow(depth / dent, exponent));
    }
    const double share = (depth - dent) / fall;
    if (share < 1.0) { return factor * std::lerp(puncture, left, share); }
    return factor * (left + rise * (depth - dent - fall));
  }
  [[nodiscard]] double rest(double since) const {
    return advance(end) * (1.0 - relaxed * (1.0 - std::exp(-since / relaxation_time)));
  }
  [[nodiscard]] double withdrawal(double depth) const {
    if (depth < 0.0) { return 0.0; }
    if (depth < pulled_at) { return factor * pulled * depth / pulled_at; }
    return std::lerp(factor * pulled, rest(hold), (depth - pulled_at) / (end - pulled_at));
  }

  [[nodiscard]] double advance_time() const { return (start + end) / speed; }
  [[nodiscard]] double duration() const { return 2.0 * advance_time() + hold; }
  [[nodiscard]] double depth_at(double time) const {
    const double rising = speed * time - start;
    const double falling = end - speed * (time - advance_time() - hold);
    return std::fmin(std::fmin(rising, end), falling);
  }
  [[nodiscard]] double force_at(double time) const {
    if (time <= advance_time()) { return advance(depth_at(time)); }
    if (time <= advance_time() + hold) { return rest(time - advance_time()); }
    return withdrawal(depth_at(time));
  }

  [[nodiscard]] std::vector<double> times() const {
    std::vector<double> time;
    for (std::size_t n = 0; double(n) / rate <= duration(); ++n) {
      time.push_back(double(n) / rate);
    }
    return time;
  }
};

inline Recording recording_of(const InsertionLaw& law, const std::string& name) {
  Recording recording{.name = name,
                      .kind = Recording::Kind::measured_phantom,
                      .sample_rate = law.rate,
                      .time = law.times()};
  for (const double t : recording.time) {
    recording.depth.push_back(law.depth_at(t));
    recording.force.push_back(law.force_at(t));
  }
  return recording;
}

inline Trace trace_of(const InsertionLaw& law) {
  Trace trace{.time = law.times(),
              .columns = {{"tool.force_n", "N", {}}, {"tool.depth_m", "m", {}}}};
  for (const double t : trace.time) {
    trace.columns[0].values.push_back(law.force_at(t));
    trace.columns[1].values.push_back(law.depth_at(t));
  }
  return trace;
}

}  // namespace palpate

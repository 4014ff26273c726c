// SPDX-License-Identifier: MIT
#include "model/stepping/divergence.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

namespace {

/// Motion further than this many times the body's own size is divergence.
constexpr double out_of_bounds = 1e6;

double extent_of(const NodeVectors& place) {
  return place.cols() == 0 ? 0.0 : (place.rowwise().maxCoeff() - place.rowwise().minCoeff()).norm();
}

/// How far it goes without damping.
double reach_of(const Oscillator& o) {
  const double omega = std::sqrt(o.stiffness / o.mass);
  if (omega > 0.0) {
    return std::abs(o.displacement) + std::abs(o.velocity) / omega + std::abs(o.drive_amplitude) / o.stiffness;
  }
  return std::abs(o.displacement) + std::abs(o.velocity) + std::abs(o.drive_amplitude) / o.mass;
}

}  // namespace

double bound_of_motion(const Problem& problem) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  const double size = network != nullptr ? extent_of(network->held_position())
                                         : reach_of(dynamic_cast<const OscillatorProblem&>(problem).oscillator());
  return out_of_bounds * std::max(size, 1e-3);
}

}  // namespace palpate

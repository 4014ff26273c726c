// SPDX-License-Identifier: MIT
#include "reference/extended_equations.hpp"

#include <cmath>
#include <numbers>

namespace palpate::reference {

namespace {

/// m x'' = F0 cos(W t) - k x - c x'
class OscillatorEquations final : public ExtendedEquations {
 public:
  explicit OscillatorEquations(const Oscillator& oscillator) : o_(oscillator) {}
  std::size_t dof() const override { return 1; }
  ExtendedState initial_state() const override { return {0, o_.velocity}; }
  Extended initial_position(std::size_t) const override { return o_.displacement; }
  void derivative(Extended t, double, const ExtendedState& y, ExtendedState& dy) const override {
    const Extended x = Extended(o_.displacement) + y[0];
    const Extended drive =
        Extended(o_.drive_amplitude) * std::cos(Extended(o_.drive_frequency) * t);
    dy[0] = y[1];
    dy[1] =
        (drive - Extended(o_.stiffness) * x - Extended(o_.viscosity) * y[1]) / Extended(o_.mass);
  }

 private:
  Oscillator o_;
};

using Triple = std::array<Extended, 3>;

/// Springs pull their ends together when stretched and dampers oppose the rate of stretching; loads
/// act from start to end; weight acts always; fixed nodes stay.
class NetworkEquations final : public ExtendedEquations {
 public:
  explicit NetworkEquations(const NetworkProblem& problem);
  std::size_t dof() const override { return 3 * moving_.size(); }
  ExtendedState initial_state() const override;
  Extended initial_position(std::size_t coordinate) const override {
    return place_[moving_[coordinate / 3]][coordinate % 3];
  }
  void derivative(Extended t, double gate, const ExtendedState& y,
                  ExtendedState& dy) const override;

 private:
  void add_spring(const Spring& spring, const ExtendedState& y, ExtendedState& dy) const;
  void add_loads(Extended t, double gate, ExtendedState& dy) const;

  const NetworkProblem& problem_;
  std::vector<Triple> place_{};           ///< initial positions of all nodes [m]
  std::vector<std::size_t> moving_{};     ///< nodes that are not fixed, ascending
  std::vector<std::ptrdiff_t> offset_{};  ///< of a node in u; -1 when fixed
};

NetworkEquations::NetworkEquations(const NetworkProblem& problem) : problem_(problem) {
  const SpringNetwork& network = problem.network();
  const bool displaced = network.initial_displacement.cols() > 0;
  for (Eigen::Index i = 0; i < network.rest_position.cols(); ++i) {
    const auto node = static_cast<std::size_t>(i);
    Triple place{};
    for (int axis = 0; axis < 3; ++axis) {
      place[static_cast<std::size_t>(axis)] =
          Extended(network.rest_position(axis, i)) +
          (displaced ? Extended(network.initial_displacement(axis, i)) : Extended(0));
    }
    place_.push_back(place);
    const bool moves = network.fixed[node] == 0;
    offset_.push_back(moves ? static_cast<std::ptrdiff_t>(3 * moving_.size()) : -1);
    if (moves) { moving_.push_back(node); }
  }
}

ExtendedState NetworkEquations::initial_state() const {
  ExtendedState y(2 * dof(), 0);
  const NodeVectors& velocity = problem_.network().initial_velocity;
  if (velocity.cols() == 0) { return y; }
  for (std::size_t c = 0; c < dof(); ++c) {
    const auto node = static_cast<Eigen::Index>(moving_[c / 3]);
    y[dof() + c] = velocity(static_cast<Eigen::Index>(c % 3), node);
  }
  return y;
}

void NetworkEquations::add_spring(const Spring& spring, const ExtendedState& y,
                                  ExtendedState& dy) const {
  const auto a = static_cast<std::size_t>(spring.a);
  const auto b = static_cast<std::size_t>(spring.b);
  const std::ptrdiff_t offset[2] = {offset_[a], offset_[b]};
  Triple apart{}, closing{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    apart[axis] = place_[b][axis] - place_[a][axis];
    for (int end = 0; end < 2; ++end) {
      if (offset[end] < 0) { continue; }
      const auto c = static_cast<std::size_t>(offset[end]) + axis;
      apart[axis] += end == 1 ? y[c] : -y[c];
      closing[axis] += end == 1 ? -y[dof() + c] : y[dof() + c];
    }
  }
  const Extended length =
      std::sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
  if (length < 1e-12L) { return; }
  const Extended shortening =
      (apart[0] * closing[0] + apart[1] * closing[1] + apart[2] * closing[2]) / length;
  const Extended pull = Extended(spring.stiffness) * (length - Extended(spring.rest_length)) -
                        Extended(spring.viscosity) * shortening;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Extended component = pull * apart[axis] / length;
    if (offset[0] >= 0) { dy[dof() + static_cast<std::size_t>(offset[0]) + axis] += component; }
    if (offset[1] >= 0) { dy[dof() + static_cast<std::size_t>(offset[1]) + axis] -= component; }
  }
}

void NetworkEquations::add_loads(Extended t, double gate, ExtendedState& dy) const {
  for (const Load& load : problem_.loads()) {
    if (!(load.start <= gate && gate < load.end)) { continue; }
    Extended strength = 1;
    if (load.profile != Profile::constant) {
      strength = (t - Extended(load.start)) / (Extended(load.end) - Extended(load.start));
    }
    if (load.profile == Profile::half_sine) {
      strength = std::sin(std::numbers::pi_v<Extended> * strength);
    }
    for (const int node : load.nodes) {
      const std::ptrdiff_t offset = offset_[static_cast<std::size_t>(node)];
      for (std::size_t axis = 0; offset >= 0 && axis < 3; ++axis) {
        dy[dof() + static_cast<std::size_t>(offset) + axis] +=
            strength * Extended(load.force(static_cast<Eigen::Index>(axis)));
      }
    }
  }
}

void NetworkEquations::derivative(Extended t, double gate, const ExtendedState& y,
                                  ExtendedState& dy) const {
  for (std::size_t c = 0; c < dof(); ++c) {
    dy[c] = y[dof() + c];
    dy[dof() + c] = 0;
  }
  for (const Spring& spring : problem_.network().springs) { add_spring(spring, y, dy); }
  add_loads(t, gate, dy);
  for (std::size_t c = 0; c < dof(); ++c) {
    const Extended mass = problem_.network().mass(static_cast<Eigen::Index>(moving_[c / 3]));
    dy[dof() + c] =
        dy[dof() + c] / mass + Extended(problem_.gravity()(static_cast<Eigen::Index>(c % 3)));
  }
}

}  // namespace

std::unique_ptr<ExtendedEquations> extended_equations(const Problem& problem) {
  if (const auto* oscillator = dynamic_cast<const OscillatorProblem*>(&problem)) {
    return std::make_unique<OscillatorEquations>(oscillator->oscillator());
  }
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    return std::make_unique<NetworkEquations>(*network);
  }
  return nullptr;
}

}  // namespace palpate::reference

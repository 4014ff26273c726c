// SPDX-License-Identifier: MIT

#include "model/problem/problem.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "model/problem/cell_law.hpp"

namespace palpate {

bool SpringLaw::is_printed(const PrintedForm& printed) {
  return printed.sign || printed.reversed || printed.direction || printed.half_force ||
         printed.lagged_velocity;
}

SpringLaw SpringLaw::from(const PrintedForm& printed) {
  SpringLaw law;
  if (printed.half_force) { law.scale = 0.5; }
  if (printed.reversed) {
    law.viscous = -1.0;
  } else if (printed.sign) {
    law.elastic = -1.0;
  }
  law.along_displacement = printed.direction;
  return law;
}

double load_factor(const Load& load, double t, double gate) noexcept {
  if (gate < load.start || gate >= load.end) { return 0.0; }
  if (load.profile == Profile::constant) { return 1.0; }
  const double phase = (t - load.start) / (load.end - load.start);
  return load.profile == Profile::ramp ? phase : std::sin(std::numbers::pi * phase);
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d at_node(const Coordinates& q, Eigen::Index first, const NodeVectors& fallback, int node) {
  return first < 0 ? Vector3d(fallback.col(node)) : Vector3d(q.segment<3>(first));
}

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Adds a 3x3 block; negative coordinates denote fixed nodes.
void add_block(Triplets& triplets, Eigen::Index row, Eigen::Index column, const Matrix3d& block) {
  if (row < 0 || column < 0) { return; }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      triplets.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), block(r, c));
    }
  }
}
/// Adds the 3x3 blocks of one spring.
void add_blocks(Triplets& triplets, Eigen::Index a, Eigen::Index b, const Matrix3d& block) {
  add_block(triplets, a, a, block);
  add_block(triplets, b, b, block);
  add_block(triplets, a, b, -block);
  add_block(triplets, b, a, -block);
}

}  // namespace

NetworkProblem::NetworkProblem(SpringNetwork network, std::vector<Load> loads,
                               const Eigen::Vector3d& gravity, const PrintedForm& printed)
    : network_(std::move(network)), loads_(std::move(loads)), gravity_(gravity), printed_(printed) {
  if (network_.initial_displacement.cols() > 0) { displaced_ = network_.initial_position(); }
  const int nodes = static_cast<int>(network_.node_count());
  coordinate_.assign(static_cast<std::size_t>(nodes), -1);
  free_.reserve(static_cast<std::size_t>(std::ranges::count(network_.fixed, 0)));
  for (int i = 0; i < nodes; ++i) {
    if (network_.is_fixed(i)) { continue; }
    coordinate_[static_cast<std::size_t>(i)] = static_cast<int>(dof());
    free_.push_back(i);
  }
  mass_.resize(dof());
  for (const int i : free_) { mass_.segment<3>(coordinate(i)).setConstant(network_.mass(i)); }
}

std::size_t NetworkProblem::memory_bytes() const {
  const SpringNetwork& n = network_;
  const Eigen::Index numbers = n.rest_position.size() + n.initial_displacement.size() +
                               n.initial_velocity.size() + n.mass.size() + displaced_.size() +
                               mass_.size();
  return static_cast<std::size_t>(numbers) * sizeof(double) + n.fixed.capacity() +
         n.springs.memory_bytes() + n.cells.capacity() * sizeof(VolumeCell) +
         (free_.capacity() + coordinate_.capacity()) * sizeof(int);
}

Eigen::VectorXd NetworkProblem::initial_position() const {
  Eigen::VectorXd q(dof());
  for (const int i : free_) { q.segment<3>(coordinate(i)) = held_position().col(i); }
  return q;
}

Eigen::VectorXd NetworkProblem::initial_velocity() const {
  Eigen::VectorXd v = Eigen::VectorXd::Zero(dof());
  if (network_.initial_velocity.cols() == 0) { return v; }
  for (const int i : free_) { v.segment<3>(coordinate(i)) = network_.initial_velocity.col(i); }
  return v;
}

template <class Visit>
void NetworkProblem::for_each_spring(const Coordinates& q, const Coordinates& v,
                                     Visit visit) const {
  const auto velocity = [&](Eigen::Index first) {
    return first < 0 ? Vector3d(Vector3d::Zero()) : Vector3d(v.segment<3>(first));
  };
  for (const Spring& spring : network_.springs) {
    const Eigen::Index a = coordinate(spring.a);
    const Eigen::Index b = coordinate(spring.b);
    visit(spring, a, b,
          Vector3d(at_node(q, b, held_position(), spring.b) -
                   at_node(q, a, held_position(), spring.a)),
          Vector3d(velocity(b) - velocity(a)));
  }
}

template <class Visit>
void NetworkProblem::for_each_cell(const Coordinates& q, const Coordinates& v, Visit visit) const {
  for (const VolumeCell& cell : network_.cells) {
    if (cell.stiffness == 0.0) { continue; }
    Corners<double> x{};
    Corners<double> rate{};
    for (std::size_t n = 0; n < 8; ++n) {
      const Eigen::Index at = coordinate(cell.nodes[n]);
      const Vector3d place = at_node(q, at, held_position(), cell.nodes[n]);
      x[n] = {place.x(), place.y(), place.z()};
      if (at >= 0) { rate[n] = {v(at), v(at + 1), v(at + 2)}; }
    }
    visit(cell, x, rate);
  }
}

void NetworkProblem::force(double t, double gate, const Coordinates& q, const Coordinates& v,
                           Eigen::Ref<Eigen::VectorXd> f) const {
  const SpringLaw law = SpringLaw::from(printed_);
  f.setZero();
  for_each_spring(
      q, v,
      [&](const Spring& spring, Eigen::Index a, Eigen::Index b, const Vector3d& d,
          const Vector3d& w) {
        const double length = d.norm();
        if (length < zero_length) { return; }
        Vector3d on_a = spring_force(law, numbers_of<double>(spring), d, length, w.dot(d) / length);
        if (spring.law > 0) {
          const double elastic = elastic_pull(network_.law_of(spring), spring, length).tension;
          on_a = (elastic + spring.viscosity * w.dot(d) / length) / length * d;
        }
        if (a >= 0) { f.segment<3>(a) += on_a; }
        if (b >= 0) { f.segment<3>(b) -= on_a; }
      });
  for_each_cell(q, v,
                [&](const VolumeCell& cell, const Corners<double>& x, const Corners<double>& rate) {
                  Corners<double> on{};
                  add_cell_forces<true>(cell, x, rate, on);
                  for (std::size_t n = 0; n < 8; ++n) {
                    const Eigen::Index at = coordinate(cell.nodes[n]);
                    if (at >= 0) { f.segment<3>(at) += Vector3d(on[n].x, on[n].y, on[n].z); }
                  }
                });
  for (const Load& load : loads_) {
    const double factor = load_factor(load, t, gate);
    if (factor == 0.0) { continue; }
    for (const int node : load.nodes) {
      if (const Eigen::Index c = coordinate(node); c >= 0) {
        f.segment<3>(c) += factor * load.force;
      }
    }
  }
  if (!gravity_.isZero()) {
    for (const int i : free_) { f.segment<3>(coordinate(i)) += network_.mass(i) * gravity_; }
  }
}

void NetworkProblem::jacobian(const Coordinates& q, const Coordinates& v, JacobianMatrix& stiffness,
                              JacobianMatrix& damping) const {
  const SpringLaw law = SpringLaw::from(printed_);
  Triplets position_triplets;
  Triplets velocity_triplets;
  position_triplets.reserve(36 * network_.springs.size());
  velocity_triplets.reserve(36 * network_.springs.size());
  for_each_spring(q, v,
                  [&](const Spring& spring, Eigen::Index a, Eigen::Index b, const Vector3d& d,
                      const Vector3d& w) {
                    ElasticPull pull;
                    if (spring.law > 0) {
                      pull = elastic_pull(network_.law_of(spring), spring, d.norm());
                    }
                    const auto gradient = spring_gradient<double>(
                        law, numbers_of<double>(spring), d, w, spring.law > 0 ? &pull : nullptr);
                    add_blocks(position_triplets, a, b, gradient.position);
                    add_blocks(velocity_triplets, a, b, gradient.velocity);
                  });
  for_each_cell(
      q, v, [&](const VolumeCell& cell, const Corners<double>& x, const Corners<double>& rate) {
        const auto gradient = cell_gradient<double>(cell, x, rate);
        for (std::size_t r = 0; r < 8; ++r) {
          for (std::size_t c = 0; c < 8; ++c) {
            const Eigen::Index row = coordinate(cell.nodes[r]);
            const Eigen::Index column = coordinate(cell.nodes[c]);
            const auto at_r = static_cast<Eigen::Index>(3 * r);
            const auto at_c = static_cast<Eigen::Index>(3 * c);
            add_block(position_triplets, row, column, gradient.position.block<3, 3>(at_r, at_c));
            add_block(velocity_triplets, row, column, gradient.velocity.block<3, 3>(at_r, at_c));
          }
        }
      });
  for (Eigen::Index i = 0; i < dof(); i += 3) {  // free nodes without springs need a block as well
    add_blocks(position_triplets, i, -1, Matrix3d::Zero());
    add_blocks(velocity_triplets, i, -1, Matrix3d::Zero());
  }
  stiffness.resize(dof(), dof());
  damping.resize(dof(), dof());
  stiffness.setFromTriplets(position_triplets.begin(), position_triplets.end());
  damping.setFromTriplets(velocity_triplets.begin(), velocity_triplets.end());
}

std::vector<double> NetworkProblem::breaks() const {
  std::vector<double> instants;
  for (const Load& load : loads_) {
    for (const double t : {load.start, load.end}) {
      if (t > 0.0 && std::isfinite(t)) { instants.push_back(t); }
    }
  }
  std::sort(instants.begin(), instants.end());
  instants.erase(std::unique(instants.begin(), instants.end()), instants.end());
  return instants;
}

double NetworkProblem::shortest_feature() const {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Load& load : loads_) { shortest = std::min(shortest, load.end - load.start); }
  return shortest;
}

double NetworkProblem::energy(const Coordinates& q, const Coordinates& v) const {
  double energy = 0.5 * v.cwiseAbs2().dot(mass_);
  for_each_spring(
      q, v,
      [&](const Spring& spring, Eigen::Index, Eigen::Index, const Vector3d& d, const Vector3d&) {
        energy += spring.law > 0
                      ? elastic_pull(network_.law_of(spring), spring, d.norm()).energy
                      : 0.5 * add_twice_energy(numbers_of<double>(spring), d.norm(), 0.0);
      });
  for_each_cell(q, v,
                [&](const VolumeCell& cell, const Corners<double>& x, const Corners<double>&) {
                  energy += cell_energy(cell, x);
                });
  for (const int i : free_) {
    energy -= network_.mass(i) * gravity_.dot(q.segment<3>(coordinate(i)));
  }
  return energy;
}

namespace {

/// Calls visit(corner nodes, volume at rest) for each cell.
template <class Visit> void visit_cells(const SpringNetwork& network, Visit visit) {
  const std::optional<LatticeShape>& lattice = network.springs.lattice();
  if (!lattice) {
    for (const VolumeCell& cell : network.cells) { visit(cell.nodes, cell.volume); }
    return;
  }
  const std::array<int, 3>& count = lattice->nodes;
  std::array<int, 8> nodes{};
  const auto corners = [&](int i, int j, int l) {
    for (std::size_t n = 0; n < 8; ++n) {
      const auto bits = static_cast<int>(n);
      nodes[n] = lattice->index(i + (bits & 1), j + (bits >> 1 & 1), l + (bits >> 2));
    }
  };
  // The axes of a lattice from a file may have either sign.
  corners(0, 0, 0);
  Corners<double> rest;
  for (std::size_t n = 0; n < 8; ++n) {
    const auto place = network.rest_position.col(nodes[n]);
    rest[n] = {place.x(), place.y(), place.z()};
  }
  const double volume = edges_at(rest, 0).volume;
  for (int l = 0; l + 1 < count[2]; ++l) {
    for (int j = 0; j + 1 < count[1]; ++j) {
      for (int i = 0; i + 1 < count[0]; ++i) {
        corners(i, j, l);
        visit(nodes, volume);
      }
    }
  }
}

}  // namespace

CellCheck check_cells(const SpringNetwork& network, const Eigen::Ref<const NodeVectors>& position) {
  CellCheck check;
  visit_cells(network, [&](const std::array<int, 8>& nodes, double volume) {
    Corners<double> x;
    for (std::size_t n = 0; n < 8; ++n) {
      const auto place = position.col(nodes[n]);
      x[n] = {place.x(), place.y(), place.z()};
    }
    const double least = smallest_corner(x, volume);
    if (!(least > 0.0)) { ++check.inverted; }
    check.smallest = std::min(check.smallest, least);
  });
  return check;
}

std::vector<std::array<int, 8>> cell_corners(const SpringNetwork& network) {
  std::vector<std::array<int, 8>> cells;
  visit_cells(network, [&](const std::array<int, 8>& nodes, double) { cells.push_back(nodes); });
  return cells;
}

OscillatorProblem::OscillatorProblem(const Oscillator& oscillator)
    : oscillator_(oscillator), mass_(Eigen::VectorXd::Constant(1, oscillator.mass)) {}

Eigen::VectorXd OscillatorProblem::initial_position() const {
  return Eigen::VectorXd::Constant(1, oscillator_.displacement);
}

Eigen::VectorXd OscillatorProblem::initial_velocity() const {
  return Eigen::VectorXd::Constant(1, oscillator_.velocity);
}

void OscillatorProblem::force(double t, double /*gate*/, const Coordinates& q, const Coordinates& v,
                              Eigen::Ref<Eigen::VectorXd> f) const {
  f(0) = oscillator_.drive_amplitude * std::cos(oscillator_.drive_frequency * t) -
         oscillator_.stiffness * q(0) - oscillator_.viscosity * v(0);
}

void OscillatorProblem::jacobian(const Coordinates& /*q*/, const Coordinates& /*v*/,
                                 JacobianMatrix& stiffness, JacobianMatrix& damping) const {
  for (auto* matrix : {&stiffness, &damping}) {
    matrix->resize(1, 1);
    matrix->insert(0, 0) = matrix == &stiffness ? oscillator_.stiffness : oscillator_.viscosity;
    matrix->makeCompressed();
  }
}

double OscillatorProblem::shortest_feature() const {
  if (oscillator_.drive_amplitude == 0.0 || oscillator_.drive_frequency == 0.0) {
    return std::numeric_limits<double>::infinity();
  }
  return 2.0 * std::numbers::pi / std::abs(oscillator_.drive_frequency);
}

double OscillatorProblem::energy(const Coordinates& q, const Coordinates& v) const {
  return 0.5 * oscillator_.mass * v(0) * v(0) + 0.5 * oscillator_.stiffness * q(0) * q(0);
}

}  // namespace palpate

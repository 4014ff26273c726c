// SPDX-License-Identifier: MIT
#include "model/dynamics/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/dynamics/network_builder.hpp"

namespace palpate {

namespace {

constexpr std::array<std::array<int, 3>, 13> directions{{{1, 0, 0},  {0, 1, 0},  {0, 0, 1},
                                                         {1, 1, 0},  {-1, 1, 0}, {1, 0, 1},
                                                         {-1, 0, 1}, {0, 1, 1},  {0, -1, 1},
                                                         {1, 1, 1},  {-1, 1, 1}, {1, -1, 1},
                                                         {-1, -1, 1}}};

int axes_spanned(const std::array<int, 3>& direction) {
  return std::abs(direction[0]) + std::abs(direction[1]) + std::abs(direction[2]);
}

/// What the cells around a bond add up to.
struct Bond {
  double stiffness = 0.0;
  double damping_ratio_sum = 0.0;  ///< weighted by stiffness
  double viscosity_sum = 0.0;      ///< weighted by stiffness
  double ratio_weight = 0.0;       ///< stiffness of the cells that give a damping ratio
  double viscosity_weight = 0.0;   ///< stiffness of the cells that give a viscosity
};

void add(Bond& bond, double stiffness, const CellMaterial& material) {
  bond.stiffness += stiffness;
  if (material.viscosity) {
    bond.viscosity_sum += stiffness * *material.viscosity;
    bond.viscosity_weight += stiffness;
  } else {
    bond.damping_ratio_sum += stiffness * material.damping_ratio;
    bond.ratio_weight += stiffness;
  }
}

double viscosity_of(const Bond& bond, double mass_a, double mass_b) {
  const double reduced_mass = mass_a * mass_b / (mass_a + mass_b);
  const double critical = 2.0 * std::sqrt(bond.stiffness * reduced_mass);
  return (bond.damping_ratio_sum * critical + bond.viscosity_sum) / bond.stiffness;
}

NodeVectors lattice_positions(const LatticeShape& shape) {
  NodeVectors position(3, shape.node_count());
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for (int j = 0; j < shape.nodes[1]; ++j) {
      for (int i = 0; i < shape.nodes[0]; ++i) {
        position.col(shape.index(i, j, l)) = shape.position(i, j, l);
      }
    }
  }
  return position;
}

/// Calls visit(node, direction index, neighbour) for every bond, by node, then by direction.
template <class Visit>
void for_each_bond(const LatticeShape& shape, Visit visit) {
  const auto bonds = bond_directions(shape.connectivity);
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for (int j = 0; j < shape.nodes[1]; ++j) {
      for (int i = 0; i < shape.nodes[0]; ++i) {
        for (std::size_t d = 0; d < bonds.size(); ++d) {
          const int ni = i + bonds[d][0];
          const int nj = j + bonds[d][1];
          const int nl = l + bonds[d][2];
          if (ni < 0 || nj < 0 || ni >= shape.nodes[0] || nj >= shape.nodes[1] ||
              nl >= shape.nodes[2]) {
            continue;
          }
          visit(shape.index(i, j, l), d, shape.index(ni, nj, nl));
        }
      }
    }
  }
}

std::size_t bond_count(const LatticeShape& shape) {
  std::size_t count = 0;
  for (const auto& direction : bond_directions(shape.connectivity)) {
    std::size_t along = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      along *= static_cast<std::size_t>(shape.nodes[axis] - std::abs(direction[axis]));
    }
    count += along;
  }
  return count;
}

/// Adds one cell's members to the bonds around it; a bond is found at node * directions + d.
void add_cell(const LatticeShape& shape, int i, int j, int l, const CellMaterial& material,
              std::vector<Bond>& bonds) {
  const auto offsets = bond_directions(shape.connectivity);
  const BondStiffness k =
      bond_stiffness(material.youngs_modulus, shape.spacing, shape.connectivity);
  const std::array<double, 3> share{k.edge / 4.0, k.face_diagonal / 2.0, k.body_diagonal};
  for (std::size_t d = 0; d < offsets.size(); ++d) {
    const auto& offset = offsets[d];
    const double stiffness = share[static_cast<std::size_t>(axes_spanned(offset) - 1)];
    // Corners of this cell from which the direction stays inside it.
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> at{corner & 1, (corner >> 1) & 1, corner >> 2};
      const bool inside = std::ranges::all_of(std::array{0, 1, 2}, [&](int axis) {
        const auto n = static_cast<std::size_t>(axis);
        return at[n] + offset[n] >= 0 && at[n] + offset[n] <= 1;
      });
      if (!inside) { continue; }
      const auto node = static_cast<std::size_t>(shape.index(i + at[0], j + at[1], l + at[2]));
      add(bonds[node * offsets.size() + d], stiffness, material);
    }
  }
}

/// What rounding may make of a place or length in a regular lattice, as a share of the spacing.
constexpr double regular = 1e-12;

/// Nodes along an axis: how many of the first `of` nodes, `every` apart, differ from node 0 in nothing but
/// that coordinate and those before it.
int count_along(const NodeVectors& places, int axis, int every, double near) {
  const int of = static_cast<int>(places.cols());
  int count = 1;
  const auto apart = [&](int other, int node) {
    return std::abs(places(other, node) - places(other, 0)) > near;
  };
  while (count * every < of) {
    bool same = true;
    for (int other = axis + 1; other < 3; ++other) { same = same && !apart(other, count * every); }
    if (!same) { break; }
    ++count;
  }
  return count;
}

/// The grid of nodes in the order of index(), whichever way its axes point.
std::optional<LatticeShape> grid_of(const NodeVectors& places) {
  const int count = static_cast<int>(places.cols());
  if (count < 8) { return {}; }
  const double near = regular * (places.col(count - 1) - places.col(0)).norm();
  LatticeShape shape{.nodes = {1, 1, 1}, .connectivity = 26};
  Eigen::Vector3d step;
  int every = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const int along = count_along(places, axis, every, near);
    if (along < 2) { return {}; }
    shape.nodes[static_cast<std::size_t>(axis)] = along;
    step(axis) = places(axis, every) - places(axis, 0);
    every *= along;
  }
  shape.spacing = std::abs(step.x());
  const bool cubic = ((step.cwiseAbs().array() - shape.spacing).abs() <= near).all();
  if (!cubic || !(shape.spacing > near) || shape.node_count() != count) { return {}; }
  for (int node = 0; node < count; ++node) {
    const auto [i, j, l] = shape.place(node);
    const Eigen::Vector3d expected = places.col(0) + step.cwiseProduct(Eigen::Vector3d(i, j, l));
    if (!((places.col(node) - expected).cwiseAbs().maxCoeff() <= near)) { return {}; }
  }
  return shape;
}

}  // namespace

Eigen::Vector3d LatticeShape::position(int i, int j, int l) const {
  return {spacing * (i - 0.5 * (nodes[0] - 1)), spacing * (j - 0.5 * (nodes[1] - 1)), spacing * l};
}

std::span<const std::array<int, 3>> bond_directions(int connectivity) {
  return std::span(directions).first(static_cast<std::size_t>(connectivity / 2));
}

SpringNetwork cell_lattice(const LatticeShape& shape,
                           const std::function<CellMaterial(int, int, int)>& cell) {
  SpringNetwork network;
  network.rest_position = lattice_positions(shape);
  network.mass = Eigen::VectorXd::Zero(shape.node_count());
  network.fixed.assign(static_cast<std::size_t>(shape.node_count()), 0);
  const std::size_t direction_count = bond_directions(shape.connectivity).size();
  std::vector<Bond> bonds(static_cast<std::size_t>(shape.node_count()) * direction_count);
  const double volume = shape.spacing * shape.spacing * shape.spacing;
  for (int l = 0; l + 1 < shape.nodes[2]; ++l) {
    for (int j = 0; j + 1 < shape.nodes[1]; ++j) {
      for (int i = 0; i + 1 < shape.nodes[0]; ++i) {
        const CellMaterial material = cell(i, j, l);
        add_cell(shape, i, j, l, material, bonds);
        for (int corner = 0; corner < 8; ++corner) {
          network.mass(shape.index(i + (corner & 1), j + ((corner >> 1) & 1), l + (corner >> 2))) +=
              material.density * volume / 8.0;
        }
      }
    }
  }
  network.springs.reserve(bond_count(shape));
  for_each_bond(shape, [&](int node, std::size_t d, int neighbour) {
    const Bond& bond = bonds[static_cast<std::size_t>(node) * direction_count + d];
    if (bond.stiffness <= 0.0) { return; }
    const double rest =
        (network.rest_position.col(neighbour) - network.rest_position.col(node)).norm();
    network.springs.push_back({node, neighbour, bond.stiffness,
                               viscosity_of(bond, network.mass(node), network.mass(neighbour)),
                               rest});
  });
  return network;
}

std::optional<LatticeShape> lattice_of(const SpringNetwork& network) {
  const std::optional<LatticeShape> shape = grid_of(network.rest_position);
  if (!shape) { return {}; }
  const std::array<double, 4> lengths{0.0, shape->spacing, shape->spacing * std::numbers::sqrt2,
                                      shape->spacing * std::numbers::sqrt3};
  int node = -1;  // most springs begin where the one before did
  std::array<int, 3> a{};
  for (const Spring& spring : network.springs) {
    if (spring.a != node) {
      node = spring.a;
      a = shape->place(node);
    }
    const std::array<int, 3> b = shape->place(spring.b);
    std::array<int, 3> step{};
    for (std::size_t n = 0; n < 3; ++n) { step[n] = b[n] - a[n]; }
    const bool bond = std::ranges::all_of(step, [](int s) { return std::abs(s) <= 1; });
    if (!bond) { return {}; }
    const double natural = lengths[static_cast<std::size_t>(axes_spanned(step))];
    const bool fits = std::abs(spring.rest_length - natural) <= regular * natural;  // no NaN does
    if (!fits) { return {}; }
  }
  return shape;
}

SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass) {
  SpringNetwork network;
  network.rest_position = lattice_positions(shape);
  network.mass = Eigen::VectorXd::Constant(shape.node_count(), node_mass);
  network.fixed.assign(static_cast<std::size_t>(shape.node_count()), 0);
  network.springs.reserve(bond_count(shape));
  for_each_bond(shape, [&](int node, std::size_t /*direction*/, int neighbour) {
    const double rest =
        (network.rest_position.col(neighbour) - network.rest_position.col(node)).norm();
    network.springs.push_back({node, neighbour, stiffness, viscosity, rest});
  });
  return network;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/tissue/lattice.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "model/tissue/network_builder.hpp"

namespace palpate {

namespace {

constexpr std::array<std::array<int, 3>, 13> directions{{{1, 0, 0},
                                                         {0, 1, 0},
                                                         {0, 0, 1},
                                                         {1, 1, 0},
                                                         {-1, 1, 0},
                                                         {1, 0, 1},
                                                         {-1, 0, 1},
                                                         {0, 1, 1},
                                                         {0, -1, 1},
                                                         {1, 1, 1},
                                                         {-1, 1, 1},
                                                         {1, -1, 1},
                                                         {-1, -1, 1}}};

int axes_spanned(const std::array<int, 3>& direction) {
  return std::abs(direction[0]) + std::abs(direction[1]) + std::abs(direction[2]);
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

/// Calls visit(place, direction index, neighbour) for the bonds of a layer's nodes, ordered by
/// node, then by direction.
template <class Visit> void for_each_bond(const LatticeShape& shape, int l, Visit visit) {
  const auto bonds = bond_directions(shape.connectivity);
  for (int j = 0; j < shape.nodes[1]; ++j) {
    for (int i = 0; i < shape.nodes[0]; ++i) {
      for (std::size_t d = 0; d < bonds.size(); ++d) {
        const int ni = i + bonds[d][0];
        const int nj = j + bonds[d][1];
        const int nl = l + bonds[d][2];
        const bool there =
            ni >= 0 && nj >= 0 && ni < shape.nodes[0] && nj < shape.nodes[1] && nl < shape.nodes[2];
        if (there) { visit(std::array{i, j, l}, d, shape.index(ni, nj, nl)); }
      }
    }
  }
}

/// Materials of the cells of three layers: those around a layer of nodes, and those below, which
/// are needed for the mass of the next layer's nodes.
class CellLayers {
 public:
  struct Cell {
    CellMaterial material{};
    std::array<double, 3>
        share{};  ///< share of a cell in an edge, a face diagonal and a body diagonal [N/m]
  };
  using Ask = std::function<CellMaterial(int, int, int)>;
  CellLayers(const LatticeShape& shape, const Ask& cell) : shape_(shape), cell_(cell) {
    for (auto& layer : layers_) {
      layer.resize(static_cast<std::size_t>(shape.nodes[0] - 1) *
                   static_cast<std::size_t>(shape.nodes[1] - 1));
    }
  }
  void ask(int l) {
    for (int j = 0; j + 1 < shape_.nodes[1]; ++j) {
      for (int i = 0; i + 1 < shape_.nodes[0]; ++i) {
        const CellMaterial material = cell_(i, j, l);
        const BondStiffness k =
            bond_stiffness(material.youngs_modulus, shape_.spacing, shape_.connectivity);
        at(i, j, l) = {material, {k.edge / 4.0, k.face_diagonal / 2.0, k.body_diagonal}};
      }
    }
  }
  Cell& at(int i, int j, int l) {
    return layers_[static_cast<std::size_t>(l % 3)]
                  [static_cast<std::size_t>(j * (shape_.nodes[0] - 1) + i)];
  }
  /// Calls visit(cell); see for_each_cell_around().
  template <class Visit>
  void around(const std::array<int, 3>& node, const std::array<int, 3>& step, Visit visit) {
    for_each_cell_around(shape_.nodes, node, step,
                         [&](int i, int j, int l) { visit(at(i, j, l)); });
  }

 private:
  const LatticeShape& shape_;
  const Ask& cell_;
  std::array<std::vector<Cell>, 3> layers_{};
};

/// Adds an eighth of each cell's mass to each of its nodes.
void add_masses(const LatticeShape& shape, int l, CellLayers& cells, Eigen::VectorXd& mass) {
  const double volume = shape.spacing * shape.spacing * shape.spacing;
  for (int j = 0; j < shape.nodes[1]; ++j) {
    for (int i = 0; i < shape.nodes[0]; ++i) {
      double& own = mass(shape.index(i, j, l));
      cells.around({i, j, l}, {0, 0, 0}, [&](const CellLayers::Cell& one) {
        own += one.material.density * volume / 8.0;
      });
    }
  }
}

/// Tolerance on positions in a regular lattice, relative to its extent.
constexpr double regular = 1e-12;

/// Returns the number of nodes along an axis: the count of nodes 0, `every`, 2 `every` and so on
/// that have the same later coordinates as node 0.
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

/// Returns the lattice with nodes at these positions in the order of LatticeShape::index(). Its
/// axes may have either sign.
std::optional<LatticeShape> lattice_at(const NodeVectors& places) {
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

/// Returns the springs of a lattice. The spacing is the distance of the first two nodes, which
/// differs from that of `shape` by rounding, because rest lengths are those of the positions.
SpringList springs_of_lattice(const LatticeShape& shape, const NodeVectors& position) {
  if (*std::ranges::min_element(shape.nodes) < 2) { return {}; }
  return SpringList(
      LatticeShape{shape.nodes, std::abs(position(0, 1) - position(0, 0)), shape.connectivity});
}

void recognise_lattice(SpringNetwork& network) {
  if (network.springs.lattice()) { return; }
  const std::optional<LatticeShape> shape = lattice_at(network.rest_position);
  if (!shape) { return; }
  SpringList springs(*shape);
  for (const Spring& spring : network.springs) {
    springs.push_back(spring);
    if (!springs.lattice()) { return; }
  }
  network.springs = std::move(springs);
}

std::span<const std::array<int, 3>> bond_directions(int connectivity) {
  return std::span(directions).first(static_cast<std::size_t>(connectivity / 2));
}

SpringNetwork cell_lattice(const LatticeShape& shape,
                           const std::function<CellMaterial(int, int, int)>& cell) {
  SpringNetwork network;
  network.rest_position = lattice_positions(shape);
  network.springs = springs_of_lattice(shape, network.rest_position);
  network.mass = Eigen::VectorXd::Zero(shape.node_count());
  network.fixed.assign(static_cast<std::size_t>(shape.node_count()), 0);
  CellLayers cells(shape, cell);
  cells.ask(0);
  add_masses(shape, 0, cells, network.mass);
  const auto directions = bond_directions(shape.connectivity);
  for (int l = 0; l < shape.nodes[2]; ++l) {
    if (l + 2 < shape.nodes[2]) { cells.ask(l + 1); }
    if (l + 1 < shape.nodes[2]) { add_masses(shape, l + 1, cells, network.mass); }
    for_each_bond(shape, l, [&](const std::array<int, 3>& place, std::size_t d, int neighbour) {
      BondSum bond;
      const auto kind = static_cast<std::size_t>(axes_spanned(directions[d]) - 1);
      cells.around(place, directions[d],
                   [&](const CellLayers::Cell& one) { bond.add(one.share[kind], one.material); });
      if (bond.stiffness <= 0.0) { return; }
      const int node = shape.index(place[0], place[1], place[2]);
      network.springs.push_back({node, neighbour, bond.stiffness,
                                 bond.viscosity(network.mass(node), network.mass(neighbour)),
                                 shape.bond_length(directions[d])});
    });
  }
  return network;
}

SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass) {
  SpringNetwork network;
  network.rest_position = lattice_positions(shape);
  network.springs = springs_of_lattice(shape, network.rest_position);
  network.mass = Eigen::VectorXd::Constant(shape.node_count(), node_mass);
  network.fixed.assign(static_cast<std::size_t>(shape.node_count()), 0);
  const auto directions = bond_directions(shape.connectivity);
  std::array<double, 13> rest{};
  for (std::size_t d = 0; d < directions.size(); ++d) {
    rest[d] = shape.bond_length(directions[d]);
  }
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for_each_bond(shape, l, [&](const std::array<int, 3>& place, std::size_t d, int neighbour) {
      network.springs.push_back(
          {shape.index(place[0], place[1], place[2]), neighbour, stiffness, viscosity, rest[d]});
    });
  }
  return network;
}

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Number of spring constants: edges along x, y, z; diagonals of the faces xy, xz, yz; body
/// diagonals.
constexpr int kinds = 7;
using Constants = Eigen::Matrix<double, kinds, 1>;
using Elasticity = Eigen::Matrix<double, 6, kinds>;  ///< rows xx, yy, zz, xy, xz, yz, per constant

int kind_of(const std::array<int, 3>& direction) {
  const bool x = direction[0] != 0;
  const bool y = direction[1] != 0;
  const bool z = direction[2] != 0;
  if (x && y && z) { return 6; }
  if (x && y) { return 3; }
  if (x && z) { return 4; }
  if (y && z) { return 5; }
  return x ? 0 : y ? 1 : 2;
}

/// Returns C = sum of k L^2 n n n n over the bonds of a node, divided by its volume; every node has
/// each direction once.
Elasticity elasticity_of(const Vector3d& size) {
  Elasticity c = Elasticity::Zero();
  for (const auto& direction : bond_directions(26)) {
    const Vector3d bond = size.cwiseProduct(Vector3d(direction[0], direction[1], direction[2]));
    const double scale = 1.0 / (bond.squaredNorm() * size.prod());
    const Vector3d s = bond.cwiseAbs2();
    const Eigen::Matrix<double, 6, 1> products(s.x() * s.x(), s.y() * s.y(), s.z() * s.z(),
                                               s.x() * s.y(), s.x() * s.z(), s.y() * s.z());
    c.col(kind_of(direction)) += scale * products;
  }
  return c;
}

/// Returns C of a material with E = 1 and nu = 1/4.
Eigen::Matrix<double, 6, 1> isotropic() {
  Eigen::Matrix<double, 6, 1> c;
  c << 1.2, 1.2, 1.2, 0.4, 0.4, 0.4;
  return c;
}

/// Returns the non-negative constants nearest to `target`. Tries every subset of non-zero
/// constants; among equal errors the smallest subset is taken.
Constants nearest(const Elasticity& c, const Eigen::Matrix<double, 6, 1>& target, int usable) {
  Constants best = Constants::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int choice = 1; choice < 1 << usable; ++choice) {
    std::vector<int> chosen;
    for (int n = 0; n < usable; ++n) {
      if ((choice >> n & 1) != 0) { chosen.push_back(n); }
    }
    const Eigen::MatrixXd part = c(Eigen::all, chosen);
    const Eigen::VectorXd k = part.completeOrthogonalDecomposition().solve(target);
    const double miss = (part * k - target).norm();
    if (k.minCoeff() < 0.0 || miss >= least - 1e-9) { continue; }
    least = miss;
    best.setZero();
    for (std::size_t n = 0; n < chosen.size(); ++n) {
      best(chosen[n]) = k(static_cast<Eigen::Index>(n));
    }
  }
  return best;
}

/// Returns the isotropic constants whose body diagonals contribute a third of the shear stiffness,
/// as in a cube, or the smallest larger share for which no edge is negative. If there is none, some
/// constants are negative.
Constants isotropic_constants(const Elasticity& c) {
  const auto with = [&](double body) {
    Constants k;
    k(6) = body;
    for (int face = 0; face < 3; ++face) {
      k(3 + face) = (0.4 - c(3 + face, 6) * body) / c(3 + face, 3 + face);
    }
    for (int axis = 0; axis < 3; ++axis) {
      k(axis) = (1.2 - c.row(axis).tail<4>().dot(k.tail<4>())) / c(axis, axis);
    }
    return k;
  };
  const double most = (0.4 / c.col(6).tail<3>().array()).minCoeff();
  const Constants none = with(0.0);
  const Constants all = with(most);
  double share = 1.0 / 3.0;
  for (int axis = 0; axis < 3; ++axis) {  // each edge's constant is linear in the share
    if (none(axis) < 0.0) { share = std::max(share, none(axis) / (none(axis) - all(axis))); }
  }
  return with(share * most);
}

}  // namespace

Vector3d BoxBonds::youngs_moduli() const {
  const bool shear = elasticity(0, 1) + elasticity(0, 2) + elasticity(1, 2) > 0.0;
  if (!shear) { return elasticity.diagonal(); }
  return elasticity.inverse().diagonal().cwiseInverse();
}

BoxBonds box_bonds(const Vector3d& size, int connectivity) {
  const Elasticity c = elasticity_of(size);
  Constants k = Constants::Zero();
  const double longest = size.maxCoeff();
  if (longest - size.minCoeff() <= 1e-12 * longest) {
    const BondStiffness cube = bond_stiffness(1.0, size.x(), connectivity);
    k << Vector3d::Constant(cube.edge), Vector3d::Constant(cube.face_diagonal), cube.body_diagonal;
  } else if (connectivity == 6) {
    k.head<3>() = c.topLeftCorner<3, 3>().diagonal().cwiseInverse();
  } else {
    if (connectivity == 26) { k = isotropic_constants(c); }
    const bool exact = connectivity == 26 && k.minCoeff() >= 0.0;
    if (!exact) { k = nearest(c, isotropic(), connectivity == 26 ? kinds : kinds - 1); }
  }
  BoxBonds bonds;
  const auto directions = bond_directions(26);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    bonds.stiffness[d] = k(kind_of(directions[d]));
  }
  const Eigen::Matrix<double, 6, 1> made = c * k;
  bonds.elasticity << made(0), made(3), made(4), made(3), made(1), made(5), made(4), made(5),
      made(2);
  return bonds;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/tissue/lattice.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "model/tissue/network_builder.hpp"
#include "model/tissue/tissue_grid.hpp"

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

/// Returns a network with the positions of a lattice, its nodes free and without mass or springs.
SpringNetwork lattice_nodes(const LatticeShape& shape) {
  SpringNetwork network;
  network.rest_position.resize(3, shape.node_count());
  for_each_place(shape.nodes, [&](int i, int j, int l) {
    network.rest_position.col(shape.index(i, j, l)) = shape.position(i, j, l);
  });
  network.springs = springs_of_lattice(shape, network.rest_position);
  network.mass = Eigen::VectorXd::Zero(shape.node_count());
  network.fixed.assign(static_cast<std::size_t>(shape.node_count()), 0);
  return network;
}

/// Calls visit(place, node) for the nodes of layer l. node_at(i, j, l) returns the node at a place,
/// or -1.
template <class NodeAt, class Visit>
void for_each_node(const GridCount& count, int l, NodeAt node_at, Visit visit) {
  for_each_column(count, [&](int i, int j) {
    const int node = node_at(i, j, l);
    if (node >= 0) { visit(std::array{i, j, l}, node); }
  });
}

/// Calls visit(place, node, direction index, neighbour) for the bonds of the nodes of layer l,
/// ordered by node, then by direction.
template <class NodeAt, class Visit>
void for_each_bond(const GridCount& count, int l, int connectivity, NodeAt node_at, Visit visit) {
  const auto bonds = bond_directions(connectivity);
  for_each_node(count, l, node_at, [&](const std::array<int, 3>& at, int node) {
    for (std::size_t d = 0; d < bonds.size(); ++d) {
      const std::array<int, 3> to{at[0] + bonds[d][0], at[1] + bonds[d][1], at[2] + bonds[d][2]};
      const bool there =
          to[0] >= 0 && to[1] >= 0 && to[0] < count[0] && to[1] < count[1] && to[2] < count[2];
      const int neighbour = there ? node_at(to[0], to[1], to[2]) : -1;
      if (neighbour >= 0) { visit(at, node, d, neighbour); }
    }
  });
}

/// Sums over the cells of a bond, one for each law: materials with different laws make springs
/// beside each other.
class BondSums {
 public:
  BondSum& of(int law) {
    const auto index = static_cast<std::size_t>(law);
    if (index >= sums_.size()) { sums_.resize(index + 1); }
    return sums_[index];
  }
  /// Adds the springs to the network and clears the sums.
  void add_springs(int node, int neighbour, double rest, SpringNetwork& network) {
    int law = 0;
    for (BondSum& bond : sums_) {
      if (bond.stiffness > 0.0) {
        network.springs.push_back({node, neighbour, bond.stiffness,
                                   bond.viscosity(network.mass(node), network.mass(neighbour)),
                                   rest, law});
      }
      bond = {};
      ++law;
    }
  }

 private:
  std::vector<BondSum> sums_{};
};

VolumeCell cell_of(const std::array<int, 8>& nodes, const CellMaterial& material, double volume,
                   int law) {
  const double modulus = material.volume_modulus();
  return {{.stiffness = modulus,
           .viscosity = modulus * material.retardation_time.value_or(0.0),
           .collapse = modulus > 0.0 ? 1.2 * material.spring_modulus() : 0.0,
           .volume = volume},
          nodes,
          law};
}

/// Materials of the cells of three layers: those around a layer of nodes, and those below, which
/// are needed for the mass of the next layer's nodes.
class CellLayers {
 public:
  struct Cell {
    CellMaterial material{};
    /// Share of a cell in an edge, a face diagonal and a body diagonal [N/m].
    std::array<double, 3> share{};
    int law = 0;
  };
  using Ask = std::function<CellMaterial(int, int, int)>;
  CellLayers(const LatticeShape& shape, const Ask& cell, SpringNetwork& network)
      : shape_(shape), cell_(cell), network_(network) {
    for (auto& layer : layers_) { layer.resize(grid_index(cells_of(shape.nodes), 0, 0, 1)); }
  }
  void ask(int l) {
    for_each_column(cells_of(shape_.nodes), [&](int i, int j) {
      const CellMaterial material = cell_(i, j, l);
      const BondStiffness k =
          bond_stiffness(material.spring_modulus(), shape_.spacing, shape_.connectivity);
      at(i, j, l) = {material,
                     {k.edge / 4.0, k.face_diagonal / 2.0, k.body_diagonal},
                     network_.law_number(material.law)};
    });
  }
  Cell& at(int i, int j, int l) {
    return layers_[static_cast<std::size_t>(l % 3)][grid_index(cells_of(shape_.nodes), i, j, 0)];
  }

 private:
  const LatticeShape& shape_;
  const Ask& cell_;
  SpringNetwork& network_;
  std::array<std::vector<Cell>, 3> layers_{};
};

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

void CellMaterial::set_moduli(double spring, double volume) {
  const double shear = 0.4 * spring;
  poissons_ratio = volume == 0.0 ? 0.25 : (volume + shear) / (2.0 * (volume + 2.0 * shear));
  youngs_modulus = volume == 0.0 ? spring : 2.0 * shear * (1.0 + poissons_ratio);
}

void MaterialMean::add(double part, const CellMaterial& material) {
  parts_ += part;
  spring_ += part * material.spring_modulus();
  volume_ += part * material.volume_modulus();
  sum_.density += part * material.density;
  sum_.damping_ratio += part * material.damping_ratio;
  viscosity_ += part * material.viscosity.value_or(0.0);
  viscous_ += material.viscosity ? part : 0.0;
  has_time_ = has_time_ || material.retardation_time;
  retarded_ += part * material.spring_modulus() * material.retardation_time.value_or(0.0);
  if (part * material.spring_modulus() > strongest_) {
    strongest_ = part * material.spring_modulus();
    law_ = material.law;
  }
}

CellMaterial MaterialMean::mean() const {
  CellMaterial mean = sum_;
  if (parts_ != 1.0) {
    mean.density /= parts_;
    mean.damping_ratio /= parts_;
  }
  mean.set_moduli(spring_ / parts_, volume_ / parts_);
  mean.law = law_;
  if (viscous_ > 0.5 * parts_) { mean.viscosity = viscosity_ / viscous_; }
  if (has_time_) { mean.retardation_time = spring_ > 0.0 ? retarded_ / spring_ : 0.0; }
  return mean;
}

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
  SpringNetwork network = lattice_nodes(shape);
  const double volume = shape.spacing * shape.spacing * shape.spacing;
  const auto directions = bond_directions(shape.connectivity);
  const auto node_at = [&](int i, int j, int l) { return shape.index(i, j, l); };
  CellLayers cells(shape, cell, network);
  const auto add_cells = [&](int l) {
    for_each_column(cells_of(shape.nodes), [&](int i, int j) {
      std::array<int, 8> corners{};
      auto next = corners.begin();
      for_each_corner(i, j, l, [&](int b, int c, int d) { *next++ = node_at(b, c, d); });
      const CellLayers::Cell& one = cells.at(i, j, l);
      const VolumeCell made = cell_of(corners, one.material, volume, one.law);
      if (made.stiffness > 0.0) { network.cells.push_back(made); }
    });
  };
  const auto add_masses = [&](int l) {
    for_each_node(shape.nodes, l, node_at, [&](const std::array<int, 3>& at, int node) {
      for_each_cell_around(shape.nodes, at, {0, 0, 0}, [&](int i, int j, int k) {
        network.mass(node) += cells.at(i, j, k).material.density * volume / 8.0;
      });
    });
  };
  BondSums bonds;
  cells.ask(0);
  add_cells(0);
  add_masses(0);
  for (int l = 0; l < shape.nodes[2]; ++l) {
    if (l + 2 < shape.nodes[2]) {
      cells.ask(l + 1);
      add_cells(l + 1);
    }
    if (l + 1 < shape.nodes[2]) { add_masses(l + 1); }
    for_each_bond(shape.nodes, l, shape.connectivity, node_at,
                  [&](const std::array<int, 3>& at, int node, std::size_t d, int neighbour) {
                    const auto kind = static_cast<std::size_t>(axes_spanned(directions[d]) - 1);
                    for_each_cell_around(shape.nodes, at, directions[d], [&](int i, int j, int k) {
                      const CellLayers::Cell& one = cells.at(i, j, k);
                      bonds.of(one.law).add(one.share[kind], one.material);
                    });
                    bonds.add_springs(node, neighbour, shape.bond_length(directions[d]), network);
                  });
  }
  return network;
}

SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass) {
  SpringNetwork network = lattice_nodes(shape);
  network.mass.setConstant(node_mass);
  const auto directions = bond_directions(shape.connectivity);
  const auto node_at = [&](int i, int j, int l) { return shape.index(i, j, l); };
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for_each_bond(shape.nodes, l, shape.connectivity, node_at,
                  [&](const std::array<int, 3>&, int node, std::size_t d, int neighbour) {
                    network.springs.push_back(
                        {node, neighbour, stiffness, viscosity, shape.bond_length(directions[d])});
                  });
  }
  return network;
}

SpringNetwork grid_network(
    const NodeGrid& nodes, int connectivity,
    const std::function<const CellMaterial*(int, int, int, int, int)>& cell) {
  SpringNetwork network;
  const auto count = std::ranges::count_if(nodes.node, [](int node) { return node >= 0; });
  network.rest_position.resize(3, count);
  network.mass = Eigen::VectorXd::Zero(count);
  network.fixed.assign(static_cast<std::size_t>(count), 0);
  const double volume = nodes.spacing.prod();
  const auto node_at = [&](int i, int j, int l) { return nodes.at(i, j, l); };
  for (int layer = 0; layer < nodes.count[2]; ++layer) {
    for_each_node(nodes.count, layer, node_at, [&](const std::array<int, 3>& at, int node) {
      network.rest_position.col(node) = nodes.place(at[0], at[1], at[2]);
      for_each_cell_around(nodes.count, at, {0, 0, 0}, [&](int i, int j, int l) {
        const CellMaterial* material = cell(i, j, l, node, node);
        if (material != nullptr) { network.mass(node) += material->density * volume / 8.0; }
      });
    });
  }
  if (count == static_cast<std::ptrdiff_t>(nodes.node.size())) {
    network.springs =
        springs_of_lattice({nodes.count, nodes.spacing.x(), connectivity}, network.rest_position);
  }
  for_each_place(cells_of(nodes.count), [&](int i, int j, int l) {
    std::array<int, 8> corners{};
    auto next = corners.begin();
    for_each_corner(i, j, l, [&](int b, int c, int d) { *next++ = nodes.at(b, c, d); });
    if (std::ranges::min(corners) < 0) { return; }
    MaterialMean mean;
    for (const int corner : corners) {
      const CellMaterial* material = cell(i, j, l, corner, corner);
      if (material != nullptr) { mean.add(1.0, *material); }
    }
    if (mean.parts() == 0.0) { return; }
    const CellMaterial material = mean.mean();
    network.cells.push_back(cell_of(corners, material, volume, network.law_number(material.law)));
  });
  const BoxBonds box = box_bonds(nodes.spacing, connectivity);
  BondSums bonds;
  const auto directions = bond_directions(connectivity);
  for (int layer = 0; layer < nodes.count[2]; ++layer) {
    for_each_bond(
        nodes.count, layer, connectivity, node_at,
        [&](const std::array<int, 3>& at, int node, std::size_t d, int neighbour) {
          const auto& step = directions[d];
          const int axes = axes_spanned(step);
          const double share = box.stiffness[d] / (axes == 1 ? 4.0 : axes == 2 ? 2.0 : 1.0);
          for_each_cell_around(nodes.count, at, step, [&](int i, int j, int l) {
            const CellMaterial* material = cell(i, j, l, node, neighbour);
            if (material == nullptr) { return; }
            bonds.of(network.law_number(material->law))
                .add(share * material->spring_modulus(), *material);
          });
          const Eigen::Vector3d offset(step[0], step[1], step[2]);
          bonds.add_springs(node, neighbour, nodes.spacing.cwiseProduct(offset).norm(), network);
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

// SPDX-License-Identifier: MIT
#include "model/stepping/far_field.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Sums of k s s^T over many s, some at a time.
class GramSum {
 public:
  GramSum(Index size, Index together) : rows_(size, together), sum_(MatrixXd::Zero(size, size)) {}
  template <class Row>
  void add(const Row& row, double factor) {
    rows_.col(count_++) = std::sqrt(factor) * row;
    if (count_ == rows_.cols()) { flush(); }
  }
  MatrixXd take() {
    flush();
    return sum_.selfadjointView<Eigen::Lower>();
  }

 private:
  void flush() {
    sum_.selfadjointView<Eigen::Lower>().rankUpdate(rows_.leftCols(count_));
    count_ = 0;
  }
  MatrixXd rows_;
  MatrixXd sum_;
  Index count_ = 0;
};
constexpr Index together = 512;

/// visit(spring, u, s) for each spring that moves with the shapes: it grows by s^T z less u . x of its near end, if
/// it has one, u being its direction towards the far one.
template <class Visit>
void visit_far_springs(const SpringNetwork& network, const FarShapes& shapes, Visit visit) {
  VectorXd grows(shapes.modes());
  for (const Spring& spring : network.springs) {
    const bool from = shapes.holds(spring.a);
    const bool to = shapes.holds(spring.b);
    if (!from && !to) { continue; }
    Vector3d u = (network.rest_position.col(spring.b) - network.rest_position.col(spring.a)).normalized();
    if (to) { grows.noalias() = shapes.of(spring.b) * u; }
    if (from && to) { grows.noalias() -= shapes.of(spring.a) * u; }
    if (from && !to) {
      u = -u;
      grows.noalias() = shapes.of(spring.a) * u;
    }
    visit(spring, u, grows);
  }
}

/// Columns are forces on the coarse coordinates [N].
MatrixXd loads_of(const GradedLattice& graded, const NetworkProblem& problem, const LatticeShape& shape,
                  const LatticeBox& box, const NeedlePath& path, int modes) {
  MatrixXd loads = MatrixXd::Zero(graded.dof(), modes);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto of_knots = static_cast<Index>(3 * path.knots().size());
  MatrixXd on_knots = MatrixXd::Zero(graded.dof(), of_knots);
  for (std::size_t k = 0; k < path.knots().size(); ++k) {
    for (const NeedlePath::Support& support : path.supports(path.knots()[k])) {
      const Index at = graded.coordinate(support.node);
      if (at < 0) { continue; }
      for (Index c = 0; c < 3; ++c) { on_knots(at + c, 3 * static_cast<Index>(k) + c) = support.weight; }
    }
  }
  if (modes < of_knots) {
    return on_knots * MatrixXd::NullaryExpr(of_knots, modes, [&] { return normal(random); });
  }
  loads.leftCols(of_knots) = on_knots;
  for (int node = 0; node < shape.node_count(); ++node) {
    if (problem.coordinate(node) < 0 || !box.holds(shape.place(node))) { continue; }
    for (Index c = 0; c < 3; ++c) {
      for (Index n = of_knots; n < modes; ++n) { loads(graded.coordinate(node) + c, n) = normal(random); }
    }
  }
  return loads;
}

/// Directions in which a Gram matrix is rounding are left out.
constexpr double least_share = 1e-11;

/// Columns c with c^T a c = 1 each, and 0 between two.
MatrixXd independent(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(a);
  const double least = least_share * modes.eigenvalues().maxCoeff();
  const Index left_out = (modes.eigenvalues().array() <= least).count();
  const Index kept = a.rows() - left_out;
  return modes.eigenvectors().rightCols(kept) *
         modes.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

FarShapes far_shapes(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box,
                     const NeedlePath& path, int modes) {
  const SpringNetwork& network = problem.network();
  const GradedLattice graded(problem, shape, box);
  const MatrixXd response = graded.respond(loads_of(graded, problem, shape, box, path, modes)).transpose();
  FarShapes shapes;
  shapes.column.assign(static_cast<std::size_t>(network.node_count()), -1);
  std::ptrdiff_t columns = 0;
  for (const int node : problem.free_nodes()) {
    if (box.holds(shape.place(node))) { continue; }
    shapes.column[static_cast<std::size_t>(node)] = columns;
    columns += 3;
  }
  shapes.phi = MatrixXd::Zero(modes, columns);
  double whole = 0.0;
  VectorXd root_mass(columns);
  for (const int node : problem.free_nodes()) {
    if (!shapes.holds(node)) { continue; }
    const std::ptrdiff_t first = shapes.column[static_cast<std::size_t>(node)];
    const GradedLattice::Place place = graded.place_of(node);
    for (std::size_t c = 0; c < place.weight.size(); ++c) {
      if (place.coordinate[c] < 0) { continue; }
      shapes.phi.middleCols<3>(first) += place.weight[c] * response.middleCols<3>(place.coordinate[c]);
    }
    whole += network.mass(node);
    root_mass.segment<3>(first).setConstant(std::sqrt(network.mass(node)));
  }
  const double mean = 3.0 * whole / static_cast<double>(std::max<std::ptrdiff_t>(columns, 1));
  // Loads differ by orders of magnitude in what they move.
  for (Index n = 0; n < modes; ++n) {
    const double size = shapes.phi.row(n).norm();
    if (size > 0.0) { shapes.phi.row(n) /= size; }
  }
  MatrixXd gram = MatrixXd::Zero(modes, modes);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(shapes.phi * root_mass.asDiagonal());
  const MatrixXd basis = independent(gram.selfadjointView<Eigen::Lower>());
  shapes.phi = (std::sqrt(mean) * basis.transpose() * shapes.phi).eval();
  GramSum stiffness(shapes.modes(), together);
  visit_far_springs(network, shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
    stiffness.add(grows, spring.stiffness);
  });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> own(stiffness.take());
  shapes.phi = (own.eigenvectors().transpose() * shapes.phi).eval();
  return shapes;
}

template <class Real>
FarField<Real>::FarField(const NetworkProblem& problem, const NetworkProblem& near, const FarShapes& shapes)
    : first_(near.dof()) {
  const SpringNetwork& network = problem.network();
  const Index modes = shapes.modes();
  struct Sum {
    Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
    MatrixXd coupling;
    double stiff = 0.0;
    double viscous = 0.0;
  };
  std::map<int, Sum> sums;
  VectorXd stiffness = VectorXd::Zero(modes);
  GramSum damping(modes, together);
  const auto near_end = [&](const Spring& spring) {
    const int end = shapes.holds(spring.a) ? spring.b : spring.a;
    return near.coordinate(end) >= 0 ? end : -1;
  };
  visit_far_springs(network, shapes, [&](const Spring& spring, const Vector3d& u, const VectorXd& grows) {
    stiffness += spring.stiffness * grows.cwiseAbs2();  // shapes are modes: no others
    const int end = near_end(spring);
    if (end < 0) {
      damping.add(grows, spring.viscosity);
      return;
    }
    Sum& sum = sums[end];
    if (sum.coupling.size() == 0) { sum.coupling = MatrixXd::Zero(modes, 3); }
    sum.stiffness += spring.stiffness * u * u.transpose();
    sum.coupling -= spring.stiffness * grows * u.transpose();
    sum.stiff += spring.stiffness;
    sum.viscous += spring.viscosity;
  });
  // Between near and far viscosity is shared out by stiffness.
  visit_far_springs(network, shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
    const int end = near_end(spring);
    if (end < 0) { return; }
    const Sum& sum = sums.at(end);
    damping.add(grows, spring.stiffness * (sum.stiff > 0.0 ? sum.viscous / sum.stiff : 0.0));
  });
  coupling_.resize(modes, 3 * static_cast<Index>(sums.size()));
  for (const auto& [node, sum] : sums) {
    coupling_.template middleCols<3>(3 * static_cast<Index>(edges_.size())) = sum.coupling.template cast<Real>();
    edges_.push_back({.coordinate = near.coordinate(node),
                      .rest = network.rest_position.col(node).template cast<Real>(),
                      .stiffness = sum.stiffness.template cast<Real>(),
                      .lag = static_cast<Real>(sum.stiff > 0.0 ? sum.viscous / sum.stiff : 0.0)});
  }
  stiffness_ = stiffness.template cast<Real>();
  damping_ = damping.take().template cast<Real>();
  double mass = 0.0;
  for (int node = 0; node < network.node_count(); ++node) {
    if (shapes.holds(node)) { mass += network.mass(node); }
  }
  mass_ = VectorXd::Constant(modes, 3.0 * mass / static_cast<double>(std::max<Index>(shapes.phi.cols(), 1)));
  moved_.setZero(coupling_.cols());
  pulled_.setZero(coupling_.cols());
}

template <class Real>
void FarField<Real>::gather(const Vector<Real>& all, bool from_rest) noexcept {
  Index at = 0;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = all.template segment<3>(edge.coordinate);
    if (from_rest) { moved_.template segment<3>(at) -= edge.rest; }
    at += 3;
  }
}

template <class Real>
void FarField<Real>::add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept {
  const auto z = q.segment(first_, modes());
  const auto rate = v.segment(first_, modes());
  // K u + C v of a spring between near and far is K (u + lag v).
  Index at = 0;
  pulled_.noalias() = coupling_.transpose() * z;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = q.template segment<3>(edge.coordinate) - edge.rest +
                                     edge.lag * v.template segment<3>(edge.coordinate);
    f.template segment<3>(edge.coordinate) -=
        edge.stiffness * moved_.template segment<3>(at) + pulled_.template segment<3>(at);
    at += 3;
  }
  pulled_.noalias() = coupling_.transpose() * rate;
  at = 0;
  for (const Edge& edge : edges_) {
    f.template segment<3>(edge.coordinate) -= edge.lag * pulled_.template segment<3>(at);
    at += 3;
  }
  auto on_shapes = f.segment(first_, modes());
  on_shapes.noalias() -= coupling_ * moved_;
  on_shapes -= stiffness_.cwiseProduct(z);
  on_shapes.noalias() -= damping_ * rate;
}

template <class Real>
void FarField<Real>::add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept {
  const auto rate = w.segment(first_, modes());
  pulled_.noalias() = coupling_.transpose() * rate;
  Index at = 0;
  for (const Edge& edge : edges_) {
    moved_.template segment<3>(at) = edge.lag * w.template segment<3>(edge.coordinate);
    f.template segment<3>(edge.coordinate) -=
        edge.stiffness * moved_.template segment<3>(at) + edge.lag * pulled_.template segment<3>(at);
    at += 3;
  }
  auto on_shapes = f.segment(first_, modes());
  on_shapes.noalias() -= coupling_ * moved_;
  on_shapes.noalias() -= damping_ * rate;
}

template <class Real>
double FarField<Real>::energy(const Vector<Real>& q) noexcept {
  const auto z = q.segment(first_, modes());
  gather(q, true);
  double energy = 0.5 * static_cast<double>(z.cwiseAbs2().dot(stiffness_));
  pulled_.noalias() = coupling_.transpose() * z;
  Index at = 0;
  for (const Edge& edge : edges_) {
    const auto u = moved_.template segment<3>(at);
    energy += static_cast<double>(u.dot(Real(0.5) * (edge.stiffness * u) + pulled_.template segment<3>(at)));
    at += 3;
  }
  return energy;
}

template <class Real>
void FarField<Real>::add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const {
  const auto add = [&](Index row, Index column) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), Real(0));
  };
  for (Index n = 0; n < modes(); ++n) {
    for (const Edge& edge : edges_) {
      for (Index c = 0; c < 3; ++c) {
        add(first_ + n, edge.coordinate + c);
        add(edge.coordinate + c, first_ + n);
      }
    }
    for (Index m = 0; m < modes(); ++m) { add(first_ + m, first_ + n); }
  }
}

template <class Real>
void FarField<Real>::find_slots(const Eigen::SparseMatrix<Real>& a) {
  const auto slot = [&a](Index row, Index column) -> std::ptrdiff_t {
    const int* begin = a.innerIndexPtr() + a.outerIndexPtr()[column];
    const int* end = a.innerIndexPtr() + a.outerIndexPtr()[column + 1];
    return std::lower_bound(begin, end, static_cast<int>(row)) - a.innerIndexPtr();
  };
  shape_slots_.clear();
  for (Edge& edge : edges_) {
    for (Index c = 0; c < 3; ++c) {
      edge.slots[c] = slot(first_, edge.coordinate + c);
      edge.diagonal_slots[c] = slot(edge.coordinate, edge.coordinate + c);
    }
  }
  for (Index n = 0; n < modes(); ++n) {
    for (const Edge& edge : edges_) { shape_slots_.push_back(slot(edge.coordinate, first_ + n)); }
    shape_slots_.push_back(slot(first_, first_ + n));
  }
}

template <class Real>
void FarField<Real>::add_jacobian(Real on_damping, Real on_stiffness, Eigen::SparseMatrix<Real>& a) const noexcept {
  Real* values = a.valuePtr();
  Index at = 0;
  for (const Edge& edge : edges_) {
    const Real factor = on_stiffness + on_damping * edge.lag;
    for (Index c = 0; c < 3; ++c) {
      for (Index r = 0; r < 3; ++r) { values[edge.diagonal_slots[c] + r] += factor * edge.stiffness(r, c); }
      for (Index n = 0; n < modes(); ++n) { values[edge.slots[c] + n] += factor * coupling_(n, at + c); }
    }
    at += 3;
  }
  auto next = shape_slots_.begin();
  for (Index n = 0; n < modes(); ++n) {
    at = 0;
    for (const Edge& edge : edges_) {
      const Real factor = on_stiffness + on_damping * edge.lag;
      for (Index c = 0; c < 3; ++c) { values[*next + c] += factor * coupling_(n, at + c); }
      ++next;
      at += 3;
    }
    for (Index m = 0; m < modes(); ++m) { values[*next + m] += on_damping * damping_(m, n); }
    values[*next + n] += on_stiffness * stiffness_(n);
    ++next;
  }
}

template <class Real>
std::size_t FarField<Real>::memory_bytes() const noexcept {
  const auto numbers = static_cast<std::size_t>(coupling_.size() + damping_.size() + stiffness_.size() +
                                                moved_.size() + pulled_.size());
  return numbers * sizeof(Real) + edges_.size() * sizeof(Edge) + shape_slots_.size() * sizeof(std::ptrdiff_t);
}

template class FarField<double>;
template class FarField<float>;

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/reduction/reduced_network.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <iterator>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "model/kernels/list_network.hpp"
#include "model/problem/cell_law.hpp"
#include "model/problem/spring_law.hpp"
#include "model/reduction/mode_basis.hpp"

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Forces of the reduced-order model on the near nodes and on its own modal coordinates, which
/// follow the coordinates of the near nodes.
template <class Real> class ReducedModel {
 public:
  /// Builds the model. `near` is the problem with all far nodes fixed.
  ReducedModel(const NetworkProblem& problem, const NetworkProblem& near, const ModeBasis& shapes)
      : first_(near.dof()) {
    const SpringNetwork& network = problem.network();
    const Index modes = shapes.modes();
    struct Sum {
      Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
      MatrixXd coupling;
      double stiff = 0.0;    ///< trace of the stiffness
      double viscous = 0.0;  ///< trace of the damping
      [[nodiscard]] double lag() const { return stiff > 0.0 ? viscous / stiff : 0.0; }
    };
    std::map<int, Sum> sums;
    std::map<std::pair<int, int>, Eigen::Matrix3d> pairs;
    const auto ends_of = [](const MixedPart& part) {
      return std::span(part.near).first(static_cast<std::size_t>(part.near_count));
    };
    visit_mixed_parts(network, shapes, [&](const MixedPart& part) {
      for (const auto& [node, g] : ends_of(part)) {
        Sum& sum = sums[node];
        if (sum.coupling.size() == 0) { sum.coupling = MatrixXd::Zero(modes, 3); }
        sum.stiffness += part.stiffness * g * g.transpose();
        sum.coupling += part.stiffness * part.grows * g.transpose();
        sum.stiff += part.stiffness * g.squaredNorm();
        sum.viscous += part.viscosity * g.squaredNorm();
        for (const auto& [other, h] : ends_of(part)) {
          if (node >= other) { continue; }
          const auto at = pairs.try_emplace({node, other}, Eigen::Matrix3d::Zero()).first;
          at->second += part.stiffness * g * h.transpose();
        }
      }
    });
    // Viscosity between near and far nodes is distributed in proportion to stiffness.
    GramSum damping(modes);
    visit_mixed_parts(network, shapes, [&](const MixedPart& part) {
      double lags = 0.0;
      for (const auto& [node, g] : ends_of(part)) { lags += sums.at(node).lag(); }
      damping.add(part.grows, part.stiffness * lags / part.near_count);
    });
    coupling_.resize(modes, 3 * static_cast<Index>(sums.size()));
    std::map<int, int> edge_of;
    for (const auto& [node, sum] : sums) {
      edge_of[node] = static_cast<int>(edges_.size());
      coupling_.template middleCols<3>(3 * static_cast<Index>(edges_.size())) =
          sum.coupling.template cast<Real>();
      edges_.push_back({.coordinate = near.coordinate(node),
                        .rest = network.rest_position.col(node).template cast<Real>(),
                        .stiffness = sum.stiffness.template cast<Real>(),
                        .lag = static_cast<Real>(sum.lag())});
    }
    for (const auto& [nodes, pair] : pairs) {
      const int one = edge_of.at(nodes.first);
      const int other = edge_of.at(nodes.second);
      links_.push_back({.one = one,
                        .other = other,
                        .stiffness = pair.template cast<Real>(),
                        .lag = std::sqrt(edge(one).lag * edge(other).lag)});
    }
    stiffness_ = shapes.stiffness.template cast<Real>();
    damping_ = (damping.take() + shapes.damping).template cast<Real>();
    mass_ = VectorXd::Constant(modes, shapes.mass);
    moved_.setZero(coupling_.cols());
    pulled_.setZero(coupling_.cols());
  }

  [[nodiscard]] Eigen::Index modes() const { return stiffness_.size(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const { return mass_; }  ///< of the modes [kg]
  void add(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept {
    const auto z = q.segment(first_, modes());
    const auto rate = v.segment(first_, modes());
    // K u + C v of a spring between a near and a far node is K (u + lag v).
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
    for (const Link& link : links_) {
      const Edge& one = edge(link.one);
      const Edge& other = edge(link.other);
      const auto moved = [&](const Edge& end) -> Eigen::Matrix<Real, 3, 1> {
        return q.template segment<3>(end.coordinate) - end.rest +
               link.lag * v.template segment<3>(end.coordinate);
      };
      f.template segment<3>(one.coordinate) -= link.stiffness * moved(other);
      f.template segment<3>(other.coordinate) -= link.stiffness.transpose() * moved(one);
    }
    auto on_shapes = f.segment(first_, modes());
    on_shapes.noalias() -= coupling_ * moved_;
    on_shapes -= stiffness_.cwiseProduct(z);
    on_shapes.noalias() -= damping_ * rate;
  }

  /// Adds C w to f.
  void add_damping(const Vector<Real>& w, Vector<Real>& f) noexcept {
    const auto rate = w.segment(first_, modes());
    pulled_.noalias() = coupling_.transpose() * rate;
    Index at = 0;
    for (const Edge& edge : edges_) {
      moved_.template segment<3>(at) = edge.lag * w.template segment<3>(edge.coordinate);
      f.template segment<3>(edge.coordinate) += edge.stiffness * moved_.template segment<3>(at) +
                                                edge.lag * pulled_.template segment<3>(at);
      at += 3;
    }
    for (const Link& link : links_) {
      const Edge& one = edge(link.one);
      const Edge& other = edge(link.other);
      f.template segment<3>(one.coordinate) +=
          link.lag * (link.stiffness * w.template segment<3>(other.coordinate));
      f.template segment<3>(other.coordinate) +=
          link.lag * (link.stiffness.transpose() * w.template segment<3>(one.coordinate));
    }
    auto on_shapes = f.segment(first_, modes());
    on_shapes.noalias() += coupling_ * moved_;
    on_shapes.noalias() += damping_ * rate;
  }

  [[nodiscard]] double energy(const Vector<Real>& q) noexcept {
    const auto z = q.segment(first_, modes());
    double energy = 0.5 * static_cast<double>(z.cwiseAbs2().dot(stiffness_));
    pulled_.noalias() = coupling_.transpose() * z;
    Index at = 0;
    for (const Edge& edge : edges_) {
      const Eigen::Matrix<Real, 3, 1> u = q.template segment<3>(edge.coordinate) - edge.rest;
      energy += static_cast<double>(
          u.dot(Real(0.5) * (edge.stiffness * u) + pulled_.template segment<3>(at)));
      at += 3;
    }
    for (const Link& link : links_) {
      const auto moved = [&](const Edge& end) -> Eigen::Matrix<Real, 3, 1> {
        return q.template segment<3>(end.coordinate) - end.rest;
      };
      energy +=
          static_cast<double>(moved(edge(link.one)).dot(link.stiffness * moved(edge(link.other))));
    }
    return energy;
  }

  void add_pattern(std::vector<Eigen::Triplet<Real>>& entries) const {
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
    for (const Link& link : links_) {
      for (Index r = 0; r < 3; ++r) {
        for (Index c = 0; c < 3; ++c) {
          add(edge(link.one).coordinate + r, edge(link.other).coordinate + c);
          add(edge(link.other).coordinate + r, edge(link.one).coordinate + c);
        }
      }
    }
  }

  /// Finds the entries of matrix `a` that add_jacobian() changes; call it after add_pattern().
  void find_slots(const Eigen::SparseMatrix<Real>& a) {
    shape_slots_.clear();
    for (Edge& edge : edges_) {
      for (Index c = 0; c < 3; ++c) {
        edge.slots[c] = slot_of(a, first_, edge.coordinate + c);
        edge.diagonal_slots[c] = slot_of(a, edge.coordinate, edge.coordinate + c);
      }
    }
    for (Link& link : links_) {
      for (Index c = 0; c < 3; ++c) {
        const Index one = edge(link.one).coordinate;
        const Index other = edge(link.other).coordinate;
        link.slots[c] = slot_of(a, one, other + c);
        link.mirrored_slots[c] = slot_of(a, other, one + c);
      }
    }
    for (Index n = 0; n < modes(); ++n) {
      for (const Edge& edge : edges_) {
        shape_slots_.push_back(slot_of(a, edge.coordinate, first_ + n));
      }
      shape_slots_.push_back(slot_of(a, first_, first_ + n));
    }
  }

  void add_jacobian(Real on_damping, Real on_stiffness,
                    Eigen::SparseMatrix<Real>& a) const noexcept {
    Real* values = a.valuePtr();
    Index at = 0;
    for (const Edge& edge : edges_) {
      const Real factor = on_stiffness + on_damping * edge.lag;
      for (Index c = 0; c < 3; ++c) {
        for (Index r = 0; r < 3; ++r) {
          values[edge.diagonal_slots[c] + r] += factor * edge.stiffness(r, c);
        }
        for (Index n = 0; n < modes(); ++n) {
          values[edge.slots[c] + n] += factor * coupling_(n, at + c);
        }
      }
      at += 3;
    }
    for (const Link& link : links_) {
      const Real factor = on_stiffness + on_damping * link.lag;
      for (Index c = 0; c < 3; ++c) {
        for (Index r = 0; r < 3; ++r) {
          values[link.slots[c] + r] += factor * link.stiffness(r, c);
          values[link.mirrored_slots[c] + r] += factor * link.stiffness(c, r);
        }
      }
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

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    const auto numbers = static_cast<std::size_t>(
        coupling_.size() + damping_.size() + stiffness_.size() + moved_.size() + pulled_.size());
    return numbers * sizeof(Real) + edges_.size() * sizeof(Edge) + links_.size() * sizeof(Link) +
           shape_slots_.size() * sizeof(std::ptrdiff_t);
  }

 private:
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  using Matrix3 = Eigen::Matrix<Real, 3, 3>;
  /// Near node with springs to far nodes, or in cells with far nodes.
  struct Edge {
    Eigen::Index coordinate = 0;
    Eigen::Matrix<Real, 3, 1> rest{};
    Matrix3 stiffness{};        ///< sum over these springs [N/m]
    Real lag{};                 ///< ratio of their viscosity to their stiffness [s]
    std::ptrdiff_t slots[3]{};  ///< first row of the modes in its three columns
    std::ptrdiff_t diagonal_slots[3]{};
  };
  /// Stiffness between two near nodes of cells with far nodes.
  struct Link {
    int one = 0;  ///< edges
    int other = 0;
    Matrix3 stiffness{};  ///< force on `one` by the displacement of `other` [N/m]
    Real lag{};  ///< geometric mean of both, so that the damping stays positive semidefinite [s]
    std::ptrdiff_t slots[3]{};  ///< first row of `one` in the three columns of `other`
    std::ptrdiff_t mirrored_slots[3]{};
  };
  [[nodiscard]] const Edge& edge(int n) const noexcept {
    return edges_[static_cast<std::size_t>(n)];
  }
  Eigen::Index first_ = 0;  ///< first modal coordinate
  std::vector<Edge> edges_{};
  std::vector<Link> links_{};
  Matrix coupling_{};         ///< modes x 3 edges [N/m]
  Vector<Real> stiffness_{};  ///< of the modes [N/m]
  Matrix damping_{};          ///< of the modes [N s/m]
  Eigen::VectorXd mass_{};
  std::vector<std::ptrdiff_t>
      shape_slots_{};     ///< entries of the edges in a mode's column, then of the modes
  Vector<Real> moved_{};  ///< displacements of the edges
  Vector<Real> pulled_{};
};

/// Inputs of the network: the problem of the near nodes and the reduced-order model.
struct NearAndFar {
  NetworkProblem near;  ///< problem with the far nodes fixed and without their springs
  ModeBasis shapes;
  /// Builds both. The tissue must be at rest at its natural lengths, without weight, and loaded at
  /// near nodes only.
  static NearAndFar of(const NetworkProblem& problem, const ReductionSetting& setting) {
    SpringNetwork near = problem.network();
    const FarNodes far = far_nodes(problem, setting.near);
    const auto is_far = [&](int node) { return far[static_cast<std::size_t>(node)] != 0; };
    std::vector<Spring> kept;
    std::ranges::copy_if(
        problem.network().springs, std::back_inserter(kept),
        [&](const Spring& spring) { return !is_far(spring.a) && !is_far(spring.b); });
    near.springs = SpringList(kept, near.springs.lattice());
    std::erase_if(near.cells,
                  [&](const VolumeCell& cell) { return std::ranges::any_of(cell.nodes, is_far); });
    for (int node = 0; node < near.node_count(); ++node) {
      if (!setting.near.holds(node)) { near.fixed[static_cast<std::size_t>(node)] = 1; }
    }
    return {NetworkProblem(std::move(near), problem.loads()), mode_basis(problem, setting)};
  }
};

template <class Real> class ReducedNetwork final : private NearAndFar, public ListNetwork<Real> {
 public:
  explicit ReducedNetwork(const NetworkProblem& problem, NearAndFar parts)
      : NearAndFar(std::move(parts)),
        ListNetwork<Real>(NearAndFar::near, {}, 0.0, true, {.further = shapes.modes()}),
        far_(problem, NearAndFar::near, shapes),
        points_moved_(VectorXd::Zero(shapes.phi.cols())) {
    Eigen::VectorXd mass(this->problem().dof() + far_.modes());
    mass << this->problem().mass(), far_.mass();
    this->set_mass(mass);
  }

  [[nodiscard]] bool has_dampers() const override { return true; }
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override {
    ListNetwork<Real>::damping(q, w, f);
    far_.add_damping(w, f);
  }
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override {
    ListNetwork<Real>::jacobian(q, v, on_damping, on_stiffness, a);
    far_.add_jacobian(on_damping, on_stiffness, a);
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    ListNetwork<Real>::pattern(a);
    far_.find_slots(a);
  }
  /// The modes depend on the stiffnesses. The new coordinates give the nearest displacements, in
  /// the norm of the masses, by which the modes are orthonormal.
  void prepare_to_continue(const NetworkSystem<Real>& from) override {
    ListNetwork<Real>::prepare_to_continue(from);
    const auto* other = dynamic_cast<const ReducedNetwork*>(&from);
    if (other == nullptr || other->shapes.far != shapes.far ||
        other->shapes.phi.cols() != shapes.phi.cols()) {
      throw std::invalid_argument("the far nodes are others than before");
    }
    const Eigen::SparseMatrix<double> mass = shapes.points->far_mass(shapes.far);
    const MatrixXd others = other->shapes.phi.transpose();
    from_modes_ = (shapes.phi * (mass.selfadjointView<Eigen::Lower>() * others) / shapes.mass)
                      .template cast<Real>();
  }
  void continue_from(const NetworkSystem<Real>& from, const Vector<Real>& q, const Vector<Real>& v,
                     State<Real>& state) noexcept override {
    ListNetwork<Real>::continue_from(from, q, v, state);
    const Index first = this->problem().dof();
    state.position.segment(first, far_.modes()).noalias() =
        from_modes_ * q.segment(first, from_modes_.cols());
    state.velocity.segment(first, far_.modes()).noalias() =
        from_modes_ * v.segment(first, from_modes_.cols());
  }
  [[nodiscard]] Eigen::Vector3d moved(const Vector<Real>& all, int node) const noexcept override {
    if (!shapes.holds(node)) { return Eigen::Vector3d::Zero(); }
    return shapes.points->interpolate(node, Vector3d(Vector3d::Zero()), [&](Index first) {
      return Vector3d(point_moved(all, first), point_moved(all, first + 1),
                      point_moved(all, first + 2));
    });
  }
  void move_all(const Vector<Real>& all) noexcept override {
    for (Index at = 0; at < points_moved_.size(); ++at) {
      points_moved_(at) = point_moved(all, at);
    }
  }
  [[nodiscard]] Eigen::Vector3d moved(int node) const noexcept override {
    if (!shapes.holds(node)) { return Eigen::Vector3d::Zero(); }
    return shapes.points->interpolate(node, Vector3d(Vector3d::Zero()), [&](Index first) {
      return points_moved_.template segment<3>(first);
    });
  }

 private:
  /// Returns a coordinate of the points' displacements.
  [[nodiscard]] double point_moved(const Vector<Real>& all, Index at) const noexcept {
    const auto modes = all.segment(this->problem().dof(), far_.modes());
    return shapes.phi.col(at).dot(modes.template cast<double>());
  }
  void add_springs(const Vector<Real>& q, const Vector<Real>& v,
                   Vector<Real>& f) noexcept override {
    ListNetwork<Real>::add_springs(q, v, f);
    far_.add(q, v, f);
  }
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override {
    const double of_near = ListNetwork<Real>::measure_springs(q, v, f);
    far_.add(q, v, f);
    return of_near + far_.energy(q);
  }
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override {
    return ListNetwork<Real>::elastic_energy(q) + far_.energy(q);
  }
  [[nodiscard]] std::size_t spring_bytes() const noexcept override {
    return ListNetwork<Real>::spring_bytes() + far_.memory_bytes() + near.memory_bytes() +
           static_cast<std::size_t>(shapes.phi.size() + points_moved_.size()) * sizeof(double) +
           shapes.far.capacity();
  }
  void add_entries(std::vector<Eigen::Triplet<Real>>& entries) const override {
    far_.add_pattern(entries);
  }

  mutable ReducedModel<Real> far_;
  VectorXd points_moved_{};  ///< of move_all()
  /// Modal coordinates from those of another network; empty without prepare_to_continue().
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> from_modes_{};
};

}  // namespace

template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_reduced_network(const NetworkProblem& problem,
                                                          const ReductionSetting& setting) {
  return std::make_unique<ReducedNetwork<Real>>(problem, NearAndFar::of(problem, setting));
}

template std::unique_ptr<NetworkSystem<double>> make_reduced_network(const NetworkProblem&,
                                                                     const ReductionSetting&);
template std::unique_ptr<NetworkSystem<float>> make_reduced_network(const NetworkProblem&,
                                                                    const ReductionSetting&);

namespace {

/// Limit on load cases times nodes: the error of larger tissue is judged at some of its load cases,
/// evenly spaced.
constexpr std::size_t most_judged_nodes = 5'000'000;

/// Adds K x of a cell about rest.
void add_linear(const SpringNetwork& network, const VolumeCell& cell, const NodeVectors& x,
                NodeVectors& f) {
  const std::array<Vector3d, 8> gradient = volume_gradient(network, cell);
  double growth = 0.0;
  for (std::size_t n = 0; n < 8; ++n) { growth += gradient[n].dot(x.col(cell.nodes[n])); }
  const double pull = cell.stiffness * cell.volume * growth;
  for (std::size_t n = 0; n < 8; ++n) { f.col(cell.nodes[n]) += pull * gradient[n]; }
}

/// Computes K x of springs and cells about rest; zero at fixed nodes.
NodeVectors stiffness_times(const SpringNetwork& network, const NodeVectors& x) {
  NodeVectors f = NodeVectors::Zero(3, x.cols());
  for (const Spring& s : network.springs) {
    const Vector3d u =
        (network.rest_position.col(s.b) - network.rest_position.col(s.a)).normalized();
    const Vector3d pull = s.stiffness * u.dot(x.col(s.b) - x.col(s.a)) * u;
    f.col(s.a) -= pull;
    f.col(s.b) += pull;
  }
  for (const VolumeCell& cell : network.cells) {
    if (cell.stiffness > 0.0) { add_linear(network, cell, x, f); }
  }
  for (int node = 0; node < network.node_count(); ++node) {
    if (network.is_fixed(node)) { f.col(node).setZero(); }
  }
  return f;
}

/// Returns r . K^-1 r from below, by conjugate gradients until ten iterations add less than 1 %.
double energy_left(const SpringNetwork& network, NodeVectors r) {
  constexpr int most = 200;
  constexpr int look = 10;
  NodeVectors p = r;
  double square = r.squaredNorm();
  double energy = 0.0;
  double before = 0.0;
  for (int n = 1; n <= most && square > 0.0; ++n) {
    const NodeVectors kp = stiffness_times(network, p);
    const double alpha = square / p.cwiseProduct(kp).sum();
    energy += alpha * square;
    r -= alpha * kp;
    const double next = r.squaredNorm();
    p = r + next / square * p;
    square = next;
    if (n % look == 0 && energy < 1.01 * std::exchange(before, energy)) { break; }
  }
  return energy;
}

}  // namespace

ReductionError::ReductionError(const NetworkProblem& problem, const ReductionSetting& setting,
                               const Vector3d& direction)
    : problem_(problem),
      network_(problem.network()),
      far_(far_nodes(problem, setting.near)),
      direction_(direction) {
  ReducedNetwork<double> reduced(problem, NearAndFar::of(problem, setting));
  Eigen::SparseMatrix<double> a;
  reduced.pattern(a);
  const VectorXd still = VectorXd::Zero(reduced.dof());
  reduced.jacobian(reduced.initial_position(), still, 0.0, 1.0, a);
  a.diagonal() -= reduced.mass();
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> statics(a);
  std::vector<LoadCase> loads = setting.load_cases;
  std::erase_if(loads, [&](const LoadCase& load) {
    return !direction.isZero() && std::abs(load.direction.dot(direction)) < 0.5;
  });
  const auto nodes = static_cast<std::size_t>(network_.node_count());
  const std::size_t apart = 1 + loads.size() * nodes / most_judged_nodes;
  for (std::size_t n = 0; n < loads.size(); n += apart) {
    const LoadCase& load = loads[n];
    VectorXd force = still;
    NodeVectors left = NodeVectors::Zero(3, network_.node_count());
    for (const NeedlePath::Support& s : load.on) {
      force.segment<3>(reduced.layout().first[static_cast<std::size_t>(s.node)]) +=
          s.weight * load.direction;
      left.col(s.node) += s.weight * load.direction;
    }
    const VectorXd moved = statics.solve(force);
    Response response{.load = load,
                      .moved = NodeVectors(3, network_.node_count()),
                      .compliance = moved.dot(force)};
    reduced.move_all(moved);
    for (int node = 0; node < network_.node_count(); ++node) {
      const Index first = reduced.layout().first[static_cast<std::size_t>(node)];
      response.moved.col(node) =
          first >= 0 ? Vector3d(moved.segment<3>(first)) : reduced.moved(node);
    }
    left -= stiffness_times(network_, response.moved);
    const double lacking = energy_left(network_, std::move(left));
    linear_ = std::max(linear_, lacking / (response.compliance + lacking));
    responses_.push_back(std::move(response));
  }
}

NodeVectors ReductionError::excess(const NodeVectors& position) const {
  constexpr SpringTerms elastic{.viscous = false};
  NodeVectors excess = NodeVectors::Zero(3, network_.node_count());
  const auto is_far = [&](int node) { return far_[static_cast<std::size_t>(node)] != 0; };
  for (const Spring& s : network_.springs) {
    if (!is_far(s.a) && !is_far(s.b)) { continue; }
    const Vector3d rest = network_.rest_position.col(s.b) - network_.rest_position.col(s.a);
    const Vector3d now = position.col(s.b) - position.col(s.a);
    const Vector3d u = rest.normalized();
    const double tension = s.law > 0
                               ? elastic_pull(network_.law_of(s), s, now.norm()).tension
                               : SpringTension<elastic>::of(numbers_of<double>(s), now.norm(), 0.0);
    const Vector3d pull = tension * now.normalized() - s.stiffness * u.dot(now - rest) * u;
    excess.col(s.a) += pull;
    excess.col(s.b) -= pull;
  }
  const NodeVectors displacement = position - network_.rest_position;
  for (const VolumeCell& cell : network_.cells) {
    if (cell.stiffness == 0.0 || std::ranges::none_of(cell.nodes, is_far)) { continue; }
    Corners<double> x;
    for (std::size_t n = 0; n < 8; ++n) {
      const Vector3d place = position.col(cell.nodes[n]);
      x[n] = {place.x(), place.y(), place.z()};
    }
    Corners<double> force{};
    add_cell_forces<false>(cell.as<double>(), x, {}, force);
    for (std::size_t n = 0; n < 8; ++n) {
      excess.col(cell.nodes[n]) += Vector3d(force[n].x, force[n].y, force[n].z);
    }
    add_linear(network_, cell, displacement, excess);
  }
  return excess;
}

double ReductionError::place_of(const Response& response, const NodeVectors& position) const {
  double sum = 0.0;
  double weight = 0.0;
  for (const NeedlePath::Support& support : response.load.on) {
    sum += support.weight * direction_.dot(position.col(support.node));
    weight += support.weight;
  }
  return sum / weight;
}

std::vector<const ReductionError::Response*> ReductionError::around(
    std::optional<double> tip, const NodeVectors& position) const {
  std::vector<double> place;
  for (const Response& response : responses_) { place.push_back(place_of(response, position)); }
  double before = -std::numeric_limits<double>::infinity();
  double after = std::numeric_limits<double>::infinity();
  for (const double each : place) {
    if (each <= tip) { before = std::max(before, each); }
    if (each >= tip) { after = std::min(after, each); }
  }
  std::vector<const Response*> counts;
  for (std::size_t n = 0; n < place.size(); ++n) {
    if (!tip || place[n] == before || place[n] == after) { counts.push_back(&responses_[n]); }
  }
  return counts;
}

double ReductionError::nonlinear(const Moment& moment) const {
  const NodeVectors pull = excess(*moment.position);
  double largest = 0.0;
  for (const Response* response : around(moment.tip, *moment.position)) {
    largest = std::max(largest, std::abs(pull.cwiseProduct(response->moved).sum()) /
                                    (response->compliance + moment.contact));
  }
  return largest;
}

double ReductionError::nonlinear_there(const Moment& moment) const {
  if (problem_.free_nodes().size() > most_factorised_nodes) { return nonlinear(moment); }
  const VectorXd still = VectorXd::Zero(problem_.dof());
  const auto coordinates_of = [&](const NodeVectors& nodes) {
    VectorXd all = still;
    for (const int node : problem_.free_nodes()) {
      all.segment<3>(problem_.coordinate(node)) = nodes.col(node);
    }
    return all;
  };
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem_.jacobian(coordinates_of(*moment.position), still, stiffness, damping);
  const StaticSolver statics(stiffness, EveryNode(problem_).places());
  if (!statics.held()) { return nonlinear(moment); }
  const VectorXd pull = coordinates_of(excess(*moment.position));
  double largest = 0.0;
  for (const Response* response : around(moment.tip, *moment.position)) {
    VectorXd force = still;
    for (const NeedlePath::Support& s : response->load.on) {
      force.segment<3>(problem_.coordinate(s.node)) += s.weight * response->load.direction;
    }
    const VectorXd moved = statics.respond(force);
    largest = std::max(largest, std::abs(pull.dot(moved)) / (force.dot(moved) + moment.contact));
  }
  return largest;
}

double ReductionError::largest_nonlinear(const std::vector<Moment>& moments, double small) const {
  std::vector<std::pair<double, const Moment*>> about_rest;
  for (const Moment& moment : moments) { about_rest.emplace_back(nonlinear(moment), &moment); }
  std::ranges::sort(about_rest, std::greater{}, &std::pair<double, const Moment*>::first);
  double largest = 0.0;
  for (const auto& [force, moment] : about_rest) {
    if (force <= largest) { break; }
    largest = std::max(largest, force > small ? nonlinear_there(*moment) : force);
  }
  return largest;
}

double ReductionError::expected(const std::function<Push(double, double)>& push,
                                double small) const {
  std::deque<NodeVectors> positions;
  std::vector<Moment> moments;
  double peak = 0.0;
  for (const Response& response : responses_) {
    const Push here = push(place_of(response, network_.rest_position), response.compliance);
    positions.emplace_back(network_.rest_position + here.force * response.moved);
    moments.push_back({.position = &positions.back(),
                       .tip = place_of(response, positions.back()),
                       .contact = here.contact});
    peak = std::max(peak, here.force);
  }
  return peak > 0.0 ? largest_nonlinear(moments, small * peak) / peak : 0.0;
}

}  // namespace palpate

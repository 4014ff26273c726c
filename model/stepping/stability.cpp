// SPDX-License-Identifier: MIT

#include "model/stepping/stability.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/cell_law.hpp"
#include "model/problem/problem.hpp"
#include "model/reduction/mode_basis.hpp"
#include "model/stepping/integrator.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double roundings = 1e-12;  ///< relative, for sums and eigenvalues

// Contributions of a network's springs to the stiffness and damping matrices at the initial
// positions.

enum class MatrixKind { stiffness, stretched_stiffness, damping };

/// Returns k u u^T with the geometric stiffness, of all springs or of stretched ones only, or c u
/// u^T. Omitting compressed springs leaves no negative stiffness and can only raise the
/// frequencies. Empty for a spring of zero length.
std::optional<Matrix3d> block_of(const SpringList::Bond& bond, const Vector3d& d, MatrixKind kind) {
  const double length = d.norm();
  if (length < zero_length) { return {}; }
  const Vector3d u = d / length;
  const Matrix3d along = u * u.transpose();
  if (kind == MatrixKind::damping) { return bond.viscosity * along; }
  constexpr SpringTerms elastic{.viscous = false};
  double tension = SpringTension<elastic>::of(numbers_of<double>(bond), length, 0.0);
  if (kind == MatrixKind::stretched_stiffness) { tension = std::max(0.0, tension); }
  return bond.stiffness * along + tension / length * (Matrix3d::Identity() - along);
}

/// Last block of a bond that a run of nodes shares. It is recomputed only if the spring differs
/// from that of the node before by more than rounding error.
struct KnownBlock {
  Vector3d d = Vector3d::Zero();
  std::optional<Matrix3d> block{};
  bool computed = false;

  const std::optional<Matrix3d>& at(const SpringList::Bond& bond, const Vector3d& now,
                                    MatrixKind kind) {
    const double near = 0.1 * roundings * d.cwiseAbs().maxCoeff();
    if (!computed || !((now - d).cwiseAbs().maxCoeff() <= near)) {
      *this = {now, block_of(bond, now, kind), true};
    }
    return block;
  }
};

/// Range of node indices.
struct NodeRange {
  int first = 0;
  int last = std::numeric_limits<int>::max();
  /// Returns true if a run can have a spring with an end in the range.
  [[nodiscard]] bool meets(const SpringList::Run& run,
                           std::span<const SpringList::Bond> bonds) const {
    const auto [least, most] = std::ranges::minmax(bonds, {}, &SpringList::Bond::to);
    const int run_last = run.first_node + run.nodes - 1;
    return run.first_node + std::min(0, least.to) <= last &&
           run_last + std::max(0, most.to) >= first;
  }
};

/// Calls visit(a, b, matrix) for the springs in `range` with an end at a coordinate that `wanted`
/// accepts.
template <class Wanted, class Visit>
void visit_blocks(const NetworkProblem& problem, MatrixKind kind, const NodeRange& range,
                  Wanted wanted, Visit visit) {
  const SpringNetwork& network = problem.network();
  const NodeVectors& place = problem.held_position();
  for (const SpringList::Run& run : network.springs.runs()) {
    const auto bonds = network.springs.bonds(run);
    if (!range.meets(run, bonds)) { continue; }
    std::vector<KnownBlock> blocks(bonds.size());
    for (int node = run.first_node; node < run.first_node + run.nodes; ++node) {
      const Eigen::Index a = problem.coordinate(node);
      for (std::size_t n = 0; n < bonds.size(); ++n) {
        const int other = node + bonds[n].to;
        const Eigen::Index b = problem.coordinate(other);
        if (!(a >= 0 && wanted(a)) && !(b >= 0 && wanted(b))) { continue; }
        if (kind == MatrixKind::damping && !(bonds[n].viscosity > 0.0)) { continue; }
        const auto& matrix = blocks[n].at(bonds[n], place.col(other) - place.col(node), kind);
        if (matrix) { visit(a, b, *matrix); }
      }
    }
  }
}

/// Part of a cell in a stiffness or damping matrix, factor * g g^T, with the gradient g of its
/// volume in units of V0. The pressure of a cell that is not at rest is left out.
struct CellPart {
  std::array<Eigen::Index, 8> at{};  ///< coordinates of the corners; -1: fixed
  std::array<Vector3d, 8> gradient{};
  double factor = 0.0;
};

/// Calls visit(part) for the cells with a corner at a coordinate that `wanted` accepts.
template <class Wanted, class Visit>
void visit_cells(const NetworkProblem& problem, MatrixKind kind, Wanted wanted, Visit visit) {
  for (const VolumeCell& cell : problem.network().cells) {
    CellPart part;
    Corners<double> x{};
    bool found = false;
    for (std::size_t n = 0; n < 8; ++n) {
      part.at[n] = problem.coordinate(cell.nodes[n]);
      found = found || (part.at[n] >= 0 && wanted(part.at[n]));
      const Vector3d place = problem.held_position().col(cell.nodes[n]);
      x[n] = {place.x(), place.y(), place.z()};
    }
    part.factor = cell.volume * (kind == MatrixKind::damping ? cell.viscosity : cell.stiffness);
    if (!found || part.factor == 0.0) { continue; }
    const CellVolumes<double> volumes = volumes_of(x, cell.volume);
    Corners<double> sum{};
    for (std::size_t n = 0; n < 8; ++n) {
      add_gradient(volumes.corner[n], n, 0.125 / cell.volume, sum);
    }
    for (std::size_t n = 0; n < 8; ++n) { part.gradient[n] = {sum[n].x, sum[n].y, sum[n].z}; }
    visit(part);
  }
}

// Lower bound on the highest frequency of a network.

constexpr int most_vectors = 200;
constexpr double accuracy = 1e-5;
/// Largest number of free nodes whose modes are computed for the whole network, and the size of the
/// subset of a larger one.
constexpr Eigen::Index most_nodes = 8000;

/// Subset of a problem's coordinates, with all others fixed. Its highest frequency does not exceed
/// that of the whole network, so it is a lower bound.
struct Part {
  /// Index in the subset for each coordinate of the whole, or -1.
  std::vector<Eigen::Index> coordinate;
  VectorXd mass;  ///< [kg]
  NodeRange nodes;
};

/// Returns all coordinates of a small network. For a larger one it returns those around free node
/// `fastest`.
Part whole_or_part(const NetworkProblem& problem, Eigen::Index fastest) {
  const auto& free = problem.free_nodes();
  const auto nodes = static_cast<Eigen::Index>(free.size());
  std::vector<Eigen::Index> order(free.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  if (nodes > most_nodes) {
    const NodeVectors& places = problem.network().rest_position;
    const Vector3d middle = places.col(free[static_cast<std::size_t>(fastest)]);
    const auto distance = [&](Eigen::Index i) {  // maximum norm: cubes suit lattices
      return (places.col(free[static_cast<std::size_t>(i)]) - middle).lpNorm<Eigen::Infinity>();
    };
    std::ranges::nth_element(order, order.begin() + most_nodes, {}, distance);
    order.resize(static_cast<std::size_t>(most_nodes));
    std::ranges::sort(order);
  }
  Part part{.coordinate = std::vector<Eigen::Index>(static_cast<std::size_t>(3 * nodes), -1),
            .mass = VectorXd(3 * static_cast<Eigen::Index>(order.size())),
            .nodes = {}};
  if (!order.empty()) {
    part.nodes = {free[static_cast<std::size_t>(order.front())],
                  free[static_cast<std::size_t>(order.back())]};
  }
  Eigen::Index next = 0;
  for (const Eigen::Index i : order) {
    part.coordinate[static_cast<std::size_t>(3 * i)] = next;
    part.mass.segment<3>(next) = problem.mass().segment<3>(3 * i);
    next += 3;
  }
  return part;
}

/// Lanczos' method for M^-1 B in the M inner product, with three vectors in memory. A second pass
/// with the coordinates of a Ritz vector computes that vector.
class Lanczos {
 public:
  /// Uses B of the springs of `part`, which must outlive this object.
  Lanczos(const NetworkProblem& problem, MatrixKind kind, const Part& part) : mass_(part.mass) {
    const auto in_part = [&](Eigen::Index c) {
      return c < 0 ? c : part.coordinate[static_cast<std::size_t>(c)];
    };
    const auto wanted = [&](Eigen::Index c) { return in_part(c) >= 0; };
    visit_blocks(problem, kind, part.nodes, wanted,
                 [&](Eigen::Index a, Eigen::Index b, const Matrix3d& matrix) {
                   blocks_.push_back({in_part(a), in_part(b), matrix});
                 });
    visit_cells(problem, kind, wanted, [&](CellPart cell) {
      for (Eigen::Index& at : cell.at) { at = in_part(at); }
      cells_.push_back(cell);
    });
  }

  /// Returns the largest eigenvalue [1/s^2 or 1/s]; a Ritz value is a lower bound of it.
  double largest() {
    begin();
    double value = 0.0;
    for (int n = 0; n < most_vectors; ++n) {
      advance();
      const bool look = n % 8 == 7 || n + 1 == most_vectors || !(beta_.back() > 0.0);
      if (!look) { continue; }
      const auto steps = static_cast<Eigen::Index>(alpha_.size());
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
      ritz.computeFromTridiagonal(Eigen::Map<const VectorXd>(alpha_.data(), steps),
                                  Eigen::Map<const VectorXd>(beta_.data(), steps - 1));
      value = ritz.eigenvalues()(steps - 1);
      ritz_ = ritz.eigenvectors().col(steps - 1);
      // Error of the vector; the error of the value is its square.
      if (!(beta_.back() * std::abs(ritz_(steps - 1)) > accuracy * value)) { break; }
    }
    return value * (1.0 - roundings);
  }

  /// Returns the Ritz vector of the value from largest().
  VectorXd vector() {
    begin();
    VectorXd sum = VectorXd::Zero(mass_.size());
    for (const double share : ritz_) {
      sum += share * now_;
      advance();
    }
    return sum;
  }

 private:
  /// Block of one spring between two coordinates (-1: fixed).
  struct Block {
    Eigen::Index a;
    Eigen::Index b;
    Matrix3d matrix;
  };

  /// Computes y = M^-1 (sum of blocks) x.
  void apply(const VectorXd& x, VectorXd& y) const {
    y.setZero();
    for (const Block& block : blocks_) {
      Vector3d difference = Vector3d::Zero();
      if (block.a >= 0) { difference -= x.segment<3>(block.a); }
      if (block.b >= 0) { difference += x.segment<3>(block.b); }
      const Vector3d f = block.matrix * difference;
      if (block.a >= 0) { y.segment<3>(block.a) -= f; }
      if (block.b >= 0) { y.segment<3>(block.b) += f; }
    }
    for (const CellPart& cell : cells_) {
      double growth = 0.0;
      for (std::size_t n = 0; n < 8; ++n) {
        if (cell.at[n] >= 0) { growth += cell.gradient[n].dot(x.segment<3>(cell.at[n])); }
      }
      for (std::size_t n = 0; n < 8; ++n) {
        if (cell.at[n] >= 0) {
          y.segment<3>(cell.at[n]) += cell.factor * growth * cell.gradient[n];
        }
      }
    }
    y.array() /= mass_.array();
  }

  void begin() {
    now_.resize(mass_.size());  // fixed vector with components of every wavelength
    for (Eigen::Index i = 0; i < now_.size(); ++i) {
      now_(i) = std::cos(1.0 + 12.9898 * static_cast<double>(i)) + (i % 2 == 0 ? 0.3 : -0.3);
    }
    now_ /= std::sqrt(now_.dot(mass_.cwiseProduct(now_)));
    before_ = VectorXd::Zero(mass_.size());
    next_ = before_;
    alpha_.clear();
    beta_.clear();
  }

  void advance() {
    apply(now_, next_);
    alpha_.push_back(next_.dot(mass_.cwiseProduct(now_)));
    next_ -= alpha_.back() * now_;
    if (!beta_.empty()) { next_ -= beta_.back() * before_; }
    beta_.push_back(std::sqrt(next_.dot(mass_.cwiseProduct(next_))));
    before_.swap(now_);
    now_ = beta_.back() > 0.0 ? VectorXd(next_ / beta_.back()) : next_;
  }

  const VectorXd& mass_;
  std::vector<Block> blocks_;
  std::vector<CellPart> cells_;
  VectorXd before_, now_, next_;
  std::vector<double> alpha_, beta_;  ///< diagonal and off-diagonal of the tridiagonal matrix
  VectorXd ritz_;
};

/// Upper triangle of a symmetric matrix: xx, xy, xz, yy, yz, zz.
using Upper = Eigen::Matrix<double, 6, 1>;
Upper upper_of(const Matrix3d& m) {
  Upper upper;
  upper << m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2);
  return upper;
}
Matrix3d whole_of(const Upper& m) {
  Matrix3d whole;
  whole << m(0), m(1), m(2), m(1), m(3), m(4), m(2), m(4), m(5);
  return whole;
}

struct Fastest {
  double bound = 0.0;
  Eigen::Index free_node = 0;  ///< node of the bound
};

/// Computes a bound on the eigenvalues. For any positive weights w, |x_a - x_b|_B^2 <= (1 +
/// w_b/w_a) |x_a|_B^2 + (1 + w_a/w_b) |x_b|_B^2. No eigenvalue of M^-1 B therefore exceeds the
/// maximum over nodes of lambda_max(sum (1 + w_b/w_a) B) / m.
Fastest bound_with_weights(const NetworkProblem& problem, MatrixKind kind, const VectorXd& weight) {
  const VectorXd& mass = problem.mass();
  std::vector<Upper> sums(static_cast<std::size_t>(mass.size() / 3), Upper::Zero());
  const auto add = [&](Eigen::Index self, Eigen::Index other, const Matrix3d& matrix) {
    if (self < 0) { return; }
    const double factor = other < 0 ? 1.0 : 1.0 + weight(other / 3) / weight(self / 3);
    sums[static_cast<std::size_t>(self / 3)] += factor * upper_of(matrix);
  };
  const auto everywhere = [](Eigen::Index) { return true; };
  visit_blocks(problem, kind, {}, everywhere,
               [&](Eigen::Index a, Eigen::Index b, const Matrix3d& matrix) {
                 add(a, b, matrix);
                 add(b, a, matrix);
               });
  // (sum g_n . x_n)^2 <= sum (g_n . x_n)^2 / s_n for shares s_n that sum to one.
  visit_cells(problem, kind, everywhere, [&](const CellPart& cell) {
    std::array<double, 8> share{};
    double total = 0.0;
    for (std::size_t n = 0; n < 8; ++n) {
      if (cell.at[n] < 0) { continue; }
      total += share[n] = cell.gradient[n].norm() * weight(cell.at[n] / 3);
    }
    for (std::size_t n = 0; n < 8; ++n) {
      if (!(share[n] > 0.0)) { continue; }
      sums[static_cast<std::size_t>(cell.at[n] / 3)] +=
          cell.factor * total / share[n] *
          upper_of(cell.gradient[n] * cell.gradient[n].transpose());
    }
  });
  Fastest fastest;
  Upper before = Upper::Zero();  // matrix of the last evaluated node, divided by its mass
  for (std::size_t i = 0; i < sums.size(); ++i) {
    // No eigenvalue exceeds the largest row sum of magnitudes; this test is sufficient for most
    // nodes of a lattice.
    const auto at = static_cast<Eigen::Index>(i);
    const Matrix3d sum = whole_of(sums[i]);
    const double most = sum.cwiseAbs().rowwise().sum().maxCoeff() / mass(3 * at);
    if (most <= fastest.bound * (1.0 + roundings)) { continue; }
    const Upper now = sums[i] / mass(3 * at);
    // The change of an eigenvalue does not exceed the sum of the changes of the entries.
    if ((now - before).cwiseAbs().sum() <= 0.1 * roundings * fastest.bound) { continue; }
    before = now;
    const double top =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(sum, Eigen::EigenvaluesOnly).eigenvalues()(2);
    if (!(top / mass(3 * at) <= fastest.bound)) { fastest = {top / mass(3 * at), at}; }
  }
  return fastest;
}

struct Extreme {
  double estimate;
  double upper;
  Eigen::Index free_node = 0;  ///< node of the largest bound
};

/// Returns the best of three bounds, with equal weights, with inverse masses (exact for one
/// spring), and, for a network that is small enough, with the shape of the fastest mode plus a
/// lower limit.
Extreme largest_eigenvalue(const NetworkProblem& problem, MatrixKind kind) {
  const VectorXd& mass = problem.mass();
  const Eigen::Index nodes = mass.size() / 3;
  const Fastest equal = bound_with_weights(problem, kind, VectorXd::Ones(nodes));
  if (!(equal.bound > 0.0)) { return {0.0, 0.0}; }
  double upper = equal.bound;
  if (mass.minCoeff() < mass.maxCoeff()) {  // otherwise the weights are equal again
    const VectorXd inverse_mass =
        Eigen::Map<const VectorXd, 0, Eigen::InnerStride<3>>(mass.data(), nodes).cwiseInverse();
    upper = std::min(upper, bound_with_weights(problem, kind, inverse_mass).bound);
  }
  const Part part = whole_or_part(problem, equal.free_node);
  Lanczos lanczos(problem, kind, part);
  const double estimate = lanczos.largest();
  if (part.mass.size() < mass.size()) {
    return {estimate, upper * (1.0 + 2.0 * roundings), equal.free_node};
  }
  const VectorXd x = lanczos.vector();
  VectorXd amplitude(nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) { amplitude(i) = x.segment<3>(3 * i).norm(); }
  for (const double floor : {0.3, 0.1, 0.03}) {
    const VectorXd weight = (amplitude.array() / amplitude.maxCoeff() + floor).matrix();
    if (weight.allFinite()) {
      upper = std::min(upper, bound_with_weights(problem, kind, weight).bound);
    }
  }
  return {estimate, upper * (1.0 + 2.0 * roundings), equal.free_node};
}

bool any_compressed(const NetworkProblem& problem) {
  constexpr double counts = 1e-9;  // relative change that is too small to matter
  const NodeVectors& place = problem.held_position();
  return std::ranges::any_of(problem.network().springs, [&](const Spring& s) {
    const double least = (1.0 - counts) * s.rest_length;
    return (place.col(s.b) - place.col(s.a)).squaredNorm() < least * least;
  });
}

/// Bounds the stiffness. Compressed springs lower the frequencies, so the bound omits them and the
/// estimate includes them.
Extreme stiffness_extreme(const NetworkProblem& problem) {
  Extreme extreme = largest_eigenvalue(problem, MatrixKind::stretched_stiffness);
  if (extreme.upper > 0.0 && any_compressed(problem)) {
    const Part part = whole_or_part(problem, extreme.free_node);
    extreme.estimate = Lanczos(problem, MatrixKind::stiffness, part).largest();
  }
  return extreme;
}

}  // namespace

SpectralBounds spectral_bounds(const NetworkProblem& problem) {
  SpectralBounds bounds;
  const Extreme stiffness = stiffness_extreme(problem);
  const Extreme damping = largest_eigenvalue(problem, MatrixKind::damping);
  double slope = 1.0;  // springs that stiffen are at most that much stiffer than at rest
  for (const MaterialLaw& law : problem.network().laws) {
    slope = std::max(slope, law.largest_slope());
  }
  bounds.omega_estimate = std::sqrt(stiffness.estimate);
  bounds.omega_upper = std::sqrt(slope * stiffness.upper);
  bounds.damping_upper = damping.upper;
  bounds.relaxation_lower = std::numeric_limits<double>::infinity();
  for (const SpringList::Bond& bond : problem.network().springs.kinds()) {
    if (bond.stiffness > 0.0) {
      bounds.relaxation_lower = std::min(bounds.relaxation_lower, bond.viscosity / bond.stiffness);
    }
  }
  for (const VolumeCell& cell : problem.network().cells) {
    if (cell.stiffness > 0.0) {
      bounds.relaxation_lower = std::min(bounds.relaxation_lower, cell.viscosity / cell.stiffness);
    }
  }
  if (!std::isfinite(bounds.relaxation_lower)) { bounds.relaxation_lower = 0.0; }
  return bounds;
}

std::optional<FirstMode> first_mode(const NetworkProblem& problem) {
  constexpr std::size_t most_nodes = 8000;
  constexpr int most_iterations = 100;
  const std::size_t nodes = problem.free_nodes().size();
  const bool held = problem.dof() < 3 * problem.network().node_count();
  if (nodes == 0 || nodes > most_nodes || !held) { return {}; }
  JacobianMatrix stiffness, damping;
  problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), stiffness, damping);
  const StaticSolver statics(stiffness, EveryNode(problem).places());
  if (!statics.held()) { return {}; }
  VectorXd x = VectorXd::LinSpaced(problem.dof(), 1.0, 2.0);
  double square = 0.0;
  for (int n = 0; n < most_iterations; ++n) {
    x /= std::sqrt(x.dot(problem.mass().cwiseProduct(x)));
    x = statics.respond(problem.mass().cwiseProduct(x));
    const double now = x.dot(stiffness * x) / x.dot(problem.mass().cwiseProduct(x));
    if (std::abs(now - std::exchange(square, now)) < 1e-4 * now) { break; }
  }
  if (!(square > 0.0) || !std::isfinite(square)) { return {}; }
  const double rate = x.dot(damping * x) / x.dot(problem.mass().cwiseProduct(x));
  return FirstMode{std::sqrt(square), 0.5 * rate / std::sqrt(square)};
}

SpectralBounds spectral_bounds(const Oscillator& o) {
  const double omega = std::sqrt(o.stiffness / o.mass);
  return {omega, omega, o.viscosity / o.mass, o.stiffness > 0.0 ? o.viscosity / o.stiffness : 0.0};
}

namespace {

/// Tolerance of the stability conditions for rounding error.
constexpr double rounding = 1e-13;

/// Shortest and longest step times the fastest rate. A scheme that amplifies the shortest step is
/// assumed to amplify every step.
constexpr double shortest_step = 1e-4;
constexpr double longest_step = 100.0;

/// One scheme on oscillators of unit mass, with workspace allocated once.
class ScalarStepper {
 public:
  ScalarStepper(const IntegratorInfo& scheme, double omega, double damping)
      : system_({.mass = 1.0, .stiffness = omega * omega, .viscosity = damping}),
        scheme_(scheme.make<double>()),
        state_{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)},
        implicit_(scheme.implicit) {
    if (!implicit_) { scheme_->prepare(system_, state_, 1.0); }
  }

  /// Returns the matrix of one step for (position, h times velocity).
  Eigen::Matrix2d step_matrix(double h) {
    if (implicit_) { scheme_->prepare(system_, state_, h); }
    Eigen::Matrix2d step;
    for (int column = 0; column < 2; ++column) {
      state_.position(0) = column == 0 ? 1.0 : 0.0;
      state_.velocity(0) = column == 0 ? 0.0 : 1.0 / h;  // scaled: position change per step
      scheme_->step(system_, state_, 0.0, h);
      step.col(column) << state_.position(0), state_.velocity(0) * h;
    }
    return step;
  }

 private:
  OscillatorSystem<double> system_;
  std::unique_ptr<Integrator<double>> scheme_;
  State<double> state_;
  bool implicit_;
};

/// Returns true if both eigenvalues are inside the unit circle, by Jury's conditions. These lose no
/// digits where the eigenvalues coincide.
bool keeps_bounded(const Eigen::Matrix2d& step) {
  const double determinant = step.determinant();
  return determinant <= 1.0 + rounding && std::abs(step.trace()) <= 1.0 + determinant + rounding;
}

/// Computes stable_step(); values of `enough` or more are returned as infinite.
double stable_step_below(double enough, const IntegratorInfo& scheme, double omega,
                         double damping) {
  const double rate = std::max(omega, damping);
  if (scheme.implicit || !(rate > 0.0)) { return std::numeric_limits<double>::infinity(); }
  ScalarStepper stepper(scheme, omega, damping);
  const auto stable = [&](double h) { return keeps_bounded(stepper.step_matrix(h)); };
  if (!stable(shortest_step / rate)) { return 0.0; }
  // Increases the step by 5 % until the first growth, then bisects.
  double low = shortest_step / rate;
  double high = 10.0 * low;
  const double longest = std::min(enough, longest_step / rate);
  while (low < longest && stable(high)) {
    low = high;
    high *= 1.05;
  }
  if (low >= longest) { return std::numeric_limits<double>::infinity(); }
  for (int n = 0; n < 45; ++n) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

double amplification(const IntegratorInfo& scheme, double omega, double damping, double h) {
  const Eigen::Matrix2d step = ScalarStepper(scheme, omega, damping).step_matrix(h);
  const double half_trace = 0.5 * step.trace();
  const std::complex<double> root =
      std::sqrt(std::complex<double>(half_trace * half_trace - step.determinant(), 0.0));
  return std::max(std::abs(half_trace + root), std::abs(half_trace - root));
}

double stepped_damping_ratio(const IntegratorInfo& scheme, const FirstMode& mode, double h) {
  const Eigen::Matrix2d step =
      ScalarStepper(scheme, mode.omega, 2.0 * mode.damping_ratio * mode.omega).step_matrix(h);
  const double radius = std::sqrt(std::max(0.0, step.determinant()));
  if (!(std::abs(step.trace()) < 2.0 * radius)) { return 1.0; }
  const double decay = -std::log(radius);
  return decay / std::hypot(decay, std::acos(0.5 * step.trace() / radius));
}

double stable_step(const IntegratorInfo& scheme, double omega, double damping) {
  return stable_step_below(std::numeric_limits<double>::infinity(), scheme, omega, damping);
}

double stable_step(const IntegratorInfo& scheme, const SpectralBounds& bounds) {
  if (scheme.implicit) { return std::numeric_limits<double>::infinity(); }
  constexpr int grid = 12;
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = grid; i >= 0;
       --i) {  // from the fastest oscillator, which is usually decisive, to pure drag (omega = 0)
    const double omega = bounds.omega_upper * i / grid;
    const double least = std::min(bounds.relaxation_lower * omega * omega, bounds.damping_upper);
    for (int j = 0; j <= grid; ++j) {
      const double damping = least + (bounds.damping_upper - least) * j / grid;
      smallest = std::min(smallest, stable_step_below(smallest, scheme, omega, damping));
    }
  }
  return smallest;
}

}  // namespace palpate

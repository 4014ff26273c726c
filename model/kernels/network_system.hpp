// SPDX-License-Identifier: MIT
#pragma once
/// Interface of a network to an integrator. This class adds loads, weight and energies; derived
/// classes compute the springs.

#include <vector>

#include "model/kernels/relaxation.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

template <class Real> class NetworkSystem : public System<Real> {
 public:
  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept final;
  /// Computes the force as force() does and returns the elastic energy [J].
  double measure(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                 Vector<Real>& f) noexcept;
  void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept final;

  [[nodiscard]] const NodeLayout& layout() const { return layout_; }
  [[nodiscard]] NodeVectors places() const override;
  [[nodiscard]] virtual Vector<Real> initial_position() const = 0;
  [[nodiscard]] Vector<Real> initial_velocity() const;
  /// Returns the displacement or velocity of a node without coordinates; zero for a fixed node.
  [[nodiscard]] virtual Eigen::Vector3d moved(const Vector<Real>& /*all*/,
                                              int /*node*/) const noexcept {
    return Eigen::Vector3d::Zero();
  }
  /// Prepares moved(node) for all nodes, which is then cheaper than moved(all, node). For one
  /// thread at a time.
  virtual void move_all(const Vector<Real>& /*all*/) noexcept {}
  /// Returns moved(all, node) for the vector of the last move_all().
  [[nodiscard]] virtual Eigen::Vector3d moved(int /*node*/) const noexcept {
    return Eigen::Vector3d::Zero();
  }
  /// Returns the total energy [J]. A tool's coordinate may follow in the vectors.
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept {
    return energy(q, v, elastic_energy(q));
  }
  /// Returns the total energy [J] for a known elastic energy [J].
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v,
                              double elastic) const noexcept;
  /// Returns the elastic energy that measure() left out [J].
  [[nodiscard]] virtual double unmeasured_energy(const Vector<Real>& /*q*/) const noexcept {
    return 0.0;
  }
  /// Ends a step: q is the position at time t, from which relaxation goes on.
  virtual void remember(double /*t*/, const Vector<Real>& /*q*/) noexcept {}
  /// Prepares continue_from() for a network of the same tissue with other stiffnesses, which may
  /// be in use: only what its steps do not change is read. Allocates. Throws std::invalid_argument
  /// if internal variables cannot be taken from it.
  virtual void prepare_to_continue(const NetworkSystem& /*from*/) {}
  /// Takes the internal variables of the network of prepare_to_continue() at its state q, v, and
  /// writes the coordinates of `state` that belong to no node.
  virtual void continue_from(const NetworkSystem& /*from*/, const Vector<Real>& /*q*/,
                             const Vector<Real>& /*v*/, State<Real>& /*state*/) noexcept {}
  /// Returns the number of a spring or cell that relaxes, for relaxed(); -1 for others.
  [[nodiscard]] virtual int relaxing(const Spring& /*spring*/) const { return -1; }
  [[nodiscard]] virtual int relaxing(const VolumeCell& /*cell*/) const { return -1; }
  /// Returns what acts now of the elastic tension of a spring [N].
  [[nodiscard]] virtual Relaxed relaxed_spring(int /*number*/) const noexcept { return {}; }
  /// Returns what acts now of kappa (J - 1) of a cell [Pa].
  [[nodiscard]] virtual Relaxed relaxed_cell(int /*number*/) const noexcept { return {}; }
  [[nodiscard]] int zero_length_springs(const Vector<Real>& q) const noexcept;
  /// Returns the number of springs with a free end; with skip = false, of all springs.
  [[nodiscard]] std::size_t spring_count() const { return spring_count_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
  /// Returns the fraction of the movable part that is currently integrated.
  [[nodiscard]] virtual double awake_share() const noexcept { return 1.0; }

 protected:
  NetworkSystem(const NetworkProblem& problem, NodeLayout layout, bool skip);
  [[nodiscard]] const NetworkProblem& problem() const { return problem_; }
  /// Computes the weight per coordinate; call it after set_mass().
  void spread_weight();
  /// Overwrites f with the weight.
  void put_weight(Vector<Real>& f) const noexcept;
  /// Returns the weight as forces on the coordinates [N], or null if there is no gravity.
  [[nodiscard]] const Real* weight() const { return weight_.size() > 0 ? weight_.data() : nullptr; }
  /// Adds the spring forces and returns the elastic energy [J].
  /// Prepares the forces of relaxing tissue at time t, that of a stage of a step.
  virtual void reach(double /*t*/) noexcept {}
  virtual double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                 Vector<Real>& f) noexcept {
    add_springs(q, v, f);
    return elastic_energy(q);
  }

 private:
  virtual void add_springs(const Vector<Real>& q, const Vector<Real>& v,
                           Vector<Real>& f) noexcept = 0;
  [[nodiscard]] virtual double elastic_energy(const Vector<Real>& q) const noexcept = 0;
  [[nodiscard]] virtual std::size_t spring_bytes() const noexcept = 0;

  struct LoadOnCoordinate {
    int load;
    Eigen::Index coordinate;
  };
  const NetworkProblem& problem_;
  NodeLayout layout_;
  bool skip_;
  std::vector<LoadOnCoordinate> loaded_;
  std::size_t spring_count_ = 0;
  Vector<Real> weight_;  ///< m g per coordinate [N]; empty if there is no gravity
};

}  // namespace palpate

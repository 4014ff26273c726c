// SPDX-License-Identifier: MIT
#pragma once
/// Interface of a network to an integrator. This class adds loads, weight and energies; derived
/// classes compute the springs.

#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

template <class Real> class NetworkSystem : public System<Real> {
 public:
  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept final;
  /// force(), and returns the springs' energy [J].
  double measure(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                 Vector<Real>& f) noexcept;
  void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept final;

  [[nodiscard]] const NodeLayout& layout() const { return layout_; }
  [[nodiscard]] virtual Vector<Real> initial_position() const = 0;
  [[nodiscard]] Vector<Real> initial_velocity() const;
  /// Displacement, or velocity, of a node without coordinates of its own; zero where it is held.
  [[nodiscard]] virtual Eigen::Vector3d moved(const Vector<Real>& /*all*/,
                                              int /*node*/) const noexcept {
    return Eigen::Vector3d::Zero();
  }
  /// Vectors may be longer: a tool's coordinate comes after those of the network.
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept {
    return energy(q, v, elastic_energy(q));
  }
  /// Where the springs' energy is known.
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v,
                              double elastic) const noexcept;
  [[nodiscard]] int zero_length_springs(const Vector<Real>& q) const noexcept;
  /// With a free end; all of them without skipping.
  [[nodiscard]] std::size_t spring_count() const { return spring_count_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
  /// Of what can move: the part that is stepped.
  [[nodiscard]] virtual double awake_share() const noexcept { return 1.0; }

 protected:
  NetworkSystem(const NetworkProblem& problem, NodeLayout layout, bool skip);
  [[nodiscard]] const NetworkProblem& problem() const { return problem_; }
  /// After set_mass().
  void spread_weight();
  /// Sets all of f.
  void put_weight(Vector<Real>& f) const noexcept;
  [[nodiscard]] const Vector<Real>& weight() const {
    return weight_;
  }  ///< empty where it is skipped [N]
  /// add_springs(), and returns their energy [J].
  virtual double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                                 Vector<Real>& f) noexcept {
    add_springs(q, v, f);
    return elastic_energy(q);
  }

 protected:
  struct LoadOnCoordinate {
    int load;
    Eigen::Index coordinate;
  };
  [[nodiscard]] const std::vector<LoadOnCoordinate>& loaded() const { return loaded_; }
  /// Of one of loaded() [N].
  [[nodiscard]] Eigen::Vector3d load_at(const LoadOnCoordinate& on, double t,
                                        double gate) const noexcept {
    const Load& load = loads_[static_cast<std::size_t>(on.load)];
    return load_factor(load, t, gate) * load.force;
  }

 private:
  virtual void add_springs(const Vector<Real>& q, const Vector<Real>& v,
                           Vector<Real>& f) noexcept = 0;
  [[nodiscard]] virtual double elastic_energy(const Vector<Real>& q) const noexcept = 0;
  [[nodiscard]] virtual std::size_t spring_bytes() const noexcept = 0;

  const NetworkProblem& problem_;
  NodeLayout layout_;
  bool skip_;
  std::vector<Load> loads_;
  std::vector<LoadOnCoordinate> loaded_;
  std::size_t spring_count_ = 0;
  Vector<Real> weight_;  ///< m g per coordinate [N]; empty where it is skipped
};

}  // namespace palpate

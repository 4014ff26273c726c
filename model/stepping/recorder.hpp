// SPDX-License-Identifier: MIT
#pragma once
/// The columns of a scene's records, and their values at a tick. Only what is recorded is computed.

#include <span>
#include <vector>

#include "model/dynamics/problem.hpp"
#include "model/dynamics/spring_force.hpp"
#include "model/dynamics/trace.hpp"

namespace palpate {

class Recorder {
 public:
  Recorder(const Scene& scene, const NetworkProblem& problem);

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  [[nodiscard]] bool needs_velocity() const { return needs_velocity_; }
  /// q, v: coordinates of the free nodes; v may be anything unless needs_velocity().
  void sample(double t, double gate, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
              std::span<double> row) const noexcept;

 private:
  struct Item {
    int node;
    RecordedQuantity quantity;
    std::vector<int> springs;  ///< of the node, for its force
    std::vector<int> loads;
  };
  [[nodiscard]] Eigen::Vector3d position(int node, const Eigen::VectorXd& q) const noexcept;
  [[nodiscard]] Eigen::Vector3d velocity(int node, const Eigen::VectorXd& v) const noexcept;
  [[nodiscard]] Eigen::Vector3d force(const Item& item, double t, double gate,
                                      const Eigen::VectorXd& q,
                                      const Eigen::VectorXd& v) const noexcept;

  const NetworkProblem& problem_;
  NodeVectors held_;
  SpringLaw law_;
  std::vector<Item> items_;
  std::vector<Column> columns_;
  bool needs_velocity_ = false;
};

}  // namespace palpate

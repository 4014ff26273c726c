// SPDX-License-Identifier: MIT
#pragma once
/// The columns of a scene's records, and their values at a tick. Only what is recorded is computed.

#include <span>
#include <vector>

#include "model/dynamics/problem.hpp"
#include "model/dynamics/spring_force.hpp"
#include "model/dynamics/trace.hpp"

namespace palpate {

/// Where nodes are at an instant, and how fast.
class NodeMotion {
 public:
  virtual ~NodeMotion() = default;
  [[nodiscard]] virtual Eigen::Vector3d position(int node) noexcept = 0;  ///< [m]
  [[nodiscard]] virtual Eigen::Vector3d velocity(int node) noexcept = 0;  ///< [m/s]
};

class Recorder {
 public:
  Recorder(const Scene& scene, const NetworkProblem& problem);

  [[nodiscard]] const std::vector<Column>& columns() const { return columns_; }
  void sample(double t, double gate, NodeMotion& now, std::span<double> row) const noexcept;

 private:
  struct Item {
    int node;
    RecordedQuantity quantity;
    std::vector<Spring> springs;  ///< of the node, for its force
    std::vector<int> loads;
  };
  [[nodiscard]] Eigen::Vector3d force(const Item& item, double t, double gate, NodeMotion& now) const noexcept;

  const NetworkProblem& problem_;
  SpringLaw law_;
  std::vector<Item> items_;
  std::vector<Column> columns_;
};

}  // namespace palpate

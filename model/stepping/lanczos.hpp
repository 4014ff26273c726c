// SPDX-License-Identifier: MIT
#pragma once
/// The fastest mode of a network, sought from below.

#include <vector>

#include <Eigen/Core>

#include "model/dynamics/problem.hpp"
#include "model/stepping/spring_blocks.hpp"

namespace palpate {

/// Part of a problem's coordinates, in which all others stand still. No motion of the part is faster than the
/// fastest of the whole, so what it says is said of the whole from below.
struct Part {
  std::vector<Eigen::Index> coordinate;  ///< by that of the whole: in the part, or -1
  Eigen::VectorXd mass;                         ///< [kg]
  spring_blocks::NodeRange nodes;
};

/// All of a network whose modes are still sought as a whole; of a larger one what lies around free node `fastest`.
Part whole_or_part(const NetworkProblem& problem, Eigen::Index fastest);

/// Lanczos' method for M^-1 B in the M inner product, three vectors at a time; going through it again with
/// the coordinates of a Ritz vector adds that vector up.
class Lanczos {
 public:
  /// B: of the springs of `part`, which outlives this.
  Lanczos(const NetworkProblem& problem, spring_blocks::Which which, const Part& part);

  /// Largest eigenvalue [1/s^2 or 1/s], from below: a Ritz value can only fall short of it.
  double largest();
  /// The vector of the value that largest() found.
  Eigen::VectorXd vector();

 private:
  /// Of one spring between two coordinates (-1: fixed).
  struct Block {
    Eigen::Index a;
    Eigen::Index b;
    Eigen::Matrix3d matrix;
  };

  void apply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  void begin();
  void advance();

  const Eigen::VectorXd& mass_;
  std::vector<Block> blocks_;
  Eigen::VectorXd before_, now_, next_;
  std::vector<double> alpha_, beta_;  ///< diagonal of the tridiagonal matrix, and beside it
  Eigen::VectorXd ritz_;
};

}  // namespace palpate

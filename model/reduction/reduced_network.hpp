// SPDX-License-Identifier: MIT
#pragma once
/// Reduced-order model of the tissue far from a tool, linear about the rest state
/// (model/EQUATIONS.md, "Far field").

#include <functional>
#include <memory>
#include <vector>

#include "model/kernels/network_system.hpp"
#include "model/reduction/mode_basis.hpp"

namespace palpate {

/// Builds a network with the near nodes as a list of springs and a reduced-order model of the far
/// nodes. The coordinates of the near nodes come first, then the modal coordinates. The tissue must
/// be at rest at its natural lengths, without weight, and loaded at near nodes only. The problem
/// must outlive the network.
template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_reduced_network(const NetworkProblem& problem,
                                                          const ReductionSetting& setting);

/// Estimates of what a reduced-order model changes, without the solution of the whole tissue
/// (model/EQUATIONS.md, "Error of the far field"). Computed beside a run, not in its ticks.
class ReductionError {
 public:
  /// Solves the reduced model for a unit force of each load case whose direction has a component of
  /// half or more along `direction`; of each one if that is zero. Of large tissue some are left
  /// out, evenly along the tool, so that load cases times nodes are at most five million.
  ReductionError(const NetworkProblem& problem, const ReductionSetting& setting,
                 const Eigen::Vector3d& direction);
  /// Largest share of the linear compliance that the modes lack [1]. Conjugate gradients bound it
  /// from below.
  [[nodiscard]] double linear() const { return linear_; }
  /// Tissue under a tool.
  struct Moment {
    const NodeVectors* position = nullptr;  ///< of all nodes [m]
    std::optional<double> tip{};            ///< place of a needle's tip along `direction` [m]
    double contact = 0.0;                   ///< compliance between tool and contact points [m/N]
  };
  /// Largest force [N] of the linear springs and cells in excess of the exact ones, felt where a
  /// load case is held at its displacement. With a tip only the contact points around it count.
  /// First order about rest.
  [[nodiscard]] double nonlinear(const Moment& moment) const;
  /// The same to first order about the position: it factorises the stiffness there. Returns
  /// nonlinear() if the tissue has more than 5000 free nodes or is not stable there.
  [[nodiscard]] double nonlinear_there(const Moment& moment) const;
  /// Returns the largest force of several moments [N], to first order about their own positions
  /// where that about rest is above `small` [N].
  [[nodiscard]] double largest_nonlinear(const std::vector<Moment>& moments, double small) const;
  /// Force of a tool [N], and the compliance between it and the contact points [m/N].
  struct Push {
    double force = 0.0;
    double contact = 0.0;
  };
  /// Returns the share of the largest force that linear springs and cells are expected to change
  /// [1], before a run: each load case displaces the tissue as if it were linear. `push` has the
  /// force at the place of a load case along `direction` [m], which has a compliance [m/N]. `small`
  /// is a share below which first order about rest is enough.
  [[nodiscard]] double expected(const std::function<Push(double, double)>& push,
                                double small) const;

 private:
  struct Response {
    LoadCase load{};
    NodeVectors moved{};  ///< of all nodes under a unit force [m/N]
    double compliance = 0.0;
  };
  /// Returns the place of a load case along the direction [m].
  [[nodiscard]] double place_of(const Response& response, const NodeVectors& position) const;
  /// Returns the responses of the contact points around a tip; all without one.
  [[nodiscard]] std::vector<const Response*> around(std::optional<double> tip,
                                                    const NodeVectors& position) const;
  /// Forces of the springs and cells with far nodes less their linear ones [N].
  [[nodiscard]] NodeVectors excess(const NodeVectors& position) const;

  const NetworkProblem& problem_;
  const SpringNetwork& network_;
  FarNodes far_;
  Eigen::Vector3d direction_;
  std::vector<Response> responses_{};
  double linear_ = 0.0;
};

}  // namespace palpate

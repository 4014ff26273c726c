// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice in SIMD lanes, on one thread or several.

#include <memory>
#include <vector>

#include "model/kernels/lattice_rows.hpp"
#include "model/kernels/network_system.hpp"

namespace palpate {

/// Returns the largest useful number of threads, at most `wanted`: two layers or more for each.
/// Rows of one vector are not partitioned, because vectors at the ends of such a row access rows of
/// other layers.
int most_lattice_threads(int layers, long vectors, int wanted);

template <class Real> struct LatticeOptions {
  bool skip = true;  ///< false: absent dampers and rows of fixed nodes are computed too
  int threads = 1;
  lattice::Kernels<Real> kernels = lattice_kernels<Real>().front();
  /// Limit of the sum of all forces on sleeping nodes [N]; 0: no node sleeps. Sleeping rows require
  /// one thread and no weight.
  double sleep_force = 0.0;
  std::vector<int> touched{};  ///< nodes whose rows never sleep
};

/// Builds the network of a regular lattice. Throws std::invalid_argument for any other network.
/// `problem` must outlive it.
template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_lattice_network(const NetworkProblem& problem,
                                                          const LatticeOptions<Real>& options = {});

}  // namespace palpate

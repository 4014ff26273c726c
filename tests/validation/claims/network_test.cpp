// SPDX-License-Identifier: MIT
/// Tests that faults planted in the candidate fail the verdicts of group "network", which pass
/// without a fault.

#include <cstdio>
#include <limits>

#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST("one missing spring is seen") {
  const Mutation fault{
      .name = "one spring missing", .model = [](Scene&, SpringNetwork& network) {
        if (network.springs.empty()) { return; }
        const auto middle = static_cast<std::ptrdiff_t>(network.springs.size() / 2);
        network.springs.edit([&](std::vector<Spring>& all) { all.erase(all.begin() + middle); });
      }};
  check_red(fault, {"network/patch-test", "network/chain-frequencies", "network/kernels",
                    "network/lattice-kernels", "network/manufactured",
                    "network/order/velocity-verlet", "network/order/rk4", "network/heterogeneous"});
}

TEST("one per cent of stiffness is seen") {
  const Mutation fault{.name = "stiffness +1 %", .model = [](Scene&, SpringNetwork& network) {
                         network.springs.change_each([&](Spring& s) { s.stiffness *= 1.01; });
                       }};
  check_red(fault, {"network/patch-test", "network/chain-frequencies", "network/dispersion",
                    "network/kernels", "network/lattice-kernels", "network/manufactured",
                    "network/order/euler-cromer", "network/order/rk4"});
}

TEST("one per cent of mass is seen") {
  const Mutation fault{.name = "nodes 1 % lighter",
                       .model = [](Scene&, SpringNetwork& network) { network.mass *= 0.99; }};
  check_red(fault, {"network/patch-test", "network/chain-frequencies", "network/load-edges",
                    "network/heavy-nodes", "network/order/leapfrog"});
}

TEST("damping with the wrong sign is seen") {
  const Mutation fault{
      .name = "damping turned round", .model = [](Scene&, SpringNetwork& network) {
        network.springs.change_each([&](Spring& s) { s.viscosity = -s.viscosity; });
      }};
  check_red(fault, {"network/conservation/energy", "network/conservation/work", "network/kernels",
                    "network/lattice-kernels", "network/order/velocity-verlet", "network/skew/26"});
}

TEST("a step used twice is seen") {
  const Mutation fault{.name = "step twice", .step_twice = true};
  check_red(fault,
            {"network/chain-frequencies", "network/load-edges", "network/heavy-nodes",
             "network/conservation/work", "network/order/euler-cromer", "network/order/rk4"});
}

TEST("a NaN at one node is never a pass") {
  const Mutation fault{
      .name = "NaN at one node", .trace = [](Trace& motion) {
        motion.position(motion.position.rows() / 2, motion.position.cols() - 1) = nan;
        if (motion.velocity.size() > 0) {
          motion.velocity(motion.velocity.rows() / 2, motion.velocity.cols() - 1) = nan;
        }
        if (motion.find("energy_j") != nullptr) { motion.values("energy_j").back() = nan; }
      }};
  check_red(fault,
            {"network/chain-frequencies", "network/dispersion", "network/skew/6", "network/skew/26",
             "network/conservation/momentum", "network/conservation/energy",
             "network/conservation/work", "network/invariance", "network/order/rk4",
             "network/heterogeneous", "network/heavy-nodes", "network/float", "network/skip"});
}

TEST("one node a millimetre off is seen") {
  const Mutation fault{.name = "one node 1 mm off", .trace = [](Trace& motion) {
                         motion.position(motion.position.rows() - 1, motion.position.cols() - 1) +=
                             1e-3;
                       }};
  check_red(fault, {"network/chain-frequencies", "network/dispersion", "network/skew/26",
                    "network/conservation/work", "network/order/velocity-verlet",
                    "network/order/rk4", "network/heterogeneous", "network/heavy-nodes"});
}

TEST("frames shifted by one are seen") {
  const Mutation fault{.name = "frames shifted by one", .trace = [](Trace& motion) {
                         for (Eigen::MatrixXd* frames : {&motion.position, &motion.velocity}) {
                           for (Eigen::Index n = frames->cols() - 1; n > 0; --n) {
                             frames->col(n) = frames->col(n - 1).eval();
                           }
                         }
                       }};
  check_red(fault, {"network/chain-frequencies", "network/conservation/work",
                    "network/order/velocity-verlet", "network/order/rk4", "network/heavy-nodes"});
}

TEST("work that skipping changes is seen") {
  const Mutation fault{.name = "another bit now and then", .trace = [](Trace& motion) {
                         static bool odd = false;
                         odd = !odd;
                         if (odd) { motion.position(0, motion.position.cols() - 1) *= 1.0 + 1e-15; }
                       }};
  check_red(fault, {"network/skip", "network/invariance"});
}

}  // namespace

// SPDX-License-Identifier: MIT

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("every fault planted in a network fails the cases that measure its effect") {
  const Mutation nan_at_the_end{
      .name = "NaN at one node at the end", .trace = [](Trace& motion) {
        motion.position(motion.position.rows() / 2, motion.position.cols() - 1) = quiet_nan;
        if (motion.velocity.size() > 0) {
          motion.velocity(motion.velocity.rows() / 2, motion.velocity.cols() - 1) = quiet_nan;
        }
        if (motion.find("energy_j") != nullptr) { motion.values("energy_j").back() = quiet_nan; }
      }};
  const Mutation shifted{.name = "one node 1 mm off", .trace = [](Trace& motion) {
                           motion.position(motion.position.rows() - 1,
                                           motion.position.cols() - 1) += 1e-3;
                         }};
  const Mutation rounded{.name = "another last bit in every second run",
                         .trace = [](Trace& motion) {
                           static bool odd = false;
                           odd = !odd;
                           if (odd) {
                             motion.position(0, motion.position.cols() - 1) *= 1.0 + 1e-15;
                           }
                         }};
  const Mutation squeezable{.name = "volume modulus -1 %", .model = [](Scene&, SpringNetwork& n) {
                              for (VolumeCell& cell : n.cells) { cell.stiffness *= 0.99; }
                            }};
  const Mutation viscous{.name = "viscosity +2 %", .model = [](Scene&, SpringNetwork& n) {
                           n.springs.change_each([](Spring& s) { s.viscosity *= 1.02; });
                           for (VolumeCell& cell : n.cells) { cell.viscosity *= 1.02; }
                         }};
  const Mutation softening{.name = "stiffening -1 %", .model = [](Scene&, SpringNetwork& n) {
                             for (MaterialLaw& law : n.laws) {
                               law.stiffening.rate *= 0.99;
                               law.stiffening.cubic *= 0.99;
                             }
                           }};
  const Mutation slow{.name = "relaxation time +1 %", .model = [](Scene&, SpringNetwork& n) {
                        for (MaterialLaw& law : n.laws) {
                          for (RelaxationBranch& b : law.branches) { b.time *= 1.01; }
                        }
                      }};
  check_red("network/",
            {{missing_spring(),
              {"patch-test", "chain-frequencies", "kernels", "lattice-kernels", "manufactured",
               "order/velocity-verlet", "order/rk4", "heterogeneous"}},
             {stiffer(),
              {"patch-test", "poisson", "chain-frequencies", "dispersion", "kernels",
               "lattice-kernels", "manufactured", "order/euler-cromer", "order/rk4"}},
             {lighter(),
              {"patch-test", "chain-frequencies", "load-edges", "heavy-nodes", "order/leapfrog"}},
             {reversed_damping(),
              {"conservation/energy", "conservation/work", "kernels", "lattice-kernels",
               "order/velocity-verlet", "skew/26"}},
             {double_steps(),
              {"chain-frequencies", "load-edges", "heavy-nodes", "conservation/work",
               "order/euler-cromer", "order/rk4"}},
             {nan_at_the_end,
              {"chain-frequencies", "dispersion", "skew/6", "skew/26", "conservation/momentum",
               "conservation/energy", "conservation/work", "invariance", "order/rk4",
               "heterogeneous", "heavy-nodes", "float", "skip"}},
             {shifted,
              {"chain-frequencies", "dispersion", "skew/26", "conservation/work",
               "order/velocity-verlet", "order/rk4", "heterogeneous", "heavy-nodes"}},
             {late_frames(),
              {"chain-frequencies", "conservation/work", "order/velocity-verlet", "order/rk4",
               "heavy-nodes"}},
             {squeezable, {"poisson"}},
             {viscous, {"retardation"}},
             {softening, {"stiffening", "relaxation"}},
             {slow, {"relaxation"}},
             {rounded, {"skip", "invariance"}}});
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
#pragma once
/// Choice of integrator, step and kernels for a scene, made before the first step, with the reason
/// for each choice.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/stepping/integrator_info.hpp"
#include "model/stepping/stability.hpp"

namespace palpate {

struct ReductionSetting;                    // mode_basis.hpp
template <class Real> class NetworkSystem;  // network_system.hpp

/// Automatic substeps keep h below this share of the stable step.
inline constexpr double stability_margin = 0.5;

struct StepPlan {
  const IntegratorInfo* integrator = nullptr;
  std::string integrator_reason{};
  int substeps = 1;
  std::string substeps_reason{};
  double h = 0.0;  ///< [s] step of the integrator
  SpectralBounds bounds{};
  std::map<std::string, double> stable_step{};  ///< [s] by integrator; infinite: no limit
  bool lattice = false;                         ///< a regular lattice, stepped in lanes
  int threads = 1;                              ///< that share a lattice
  double sleep_force = 0.0;  ///< [N] that sleeping nodes of a lattice may withhold; 0: none sleeps
  std::vector<int> touched{};  ///< nodes that a tool may push, whose rows never sleep
  std::shared_ptr<const ReductionSetting> far{};  ///< tissue left to a reduced-order model, or null
  PrintedForm printed{};
  std::string kernel{};
  std::vector<std::string> skipped{};  ///< "dampers: every spring has zero viscosity"
  std::vector<std::string> warnings{};
  bool skip = true;
};

/// Throws std::invalid_argument for an unknown integrator, or one that cannot carry an erratum.
StepPlan plan_steps(const Scene& scene, const Problem& problem, bool skip = true);

/// The network in the form that the plan steps: a lattice in lanes, a list of springs, or a list
/// with a reduced-order model. `problem` must outlive it.
template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_network_system(const NetworkProblem& problem,
                                                         const StepPlan& plan);

}  // namespace palpate

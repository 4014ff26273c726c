// SPDX-License-Identifier: MIT
#pragma once
/// Choice of integrator, step and kernels for a scene, with the reasons.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/problem/problem.hpp"
#include "model/stepping/integrator_info.hpp"
#include "model/stepping/stability.hpp"

namespace palpate {

struct ReductionSetting;                    // mode_basis.hpp
template <class Real> class NetworkSystem;  // network_system.hpp

/// Automatic substeps keep h below this fraction of the stable step.
inline constexpr double stability_margin = 0.5;

/// Largest number of nodes whose stiffness an implicit scheme factorises. The memory of the factors
/// grows faster than the nodes (docs/notebook/reduced-order-model.md).
inline constexpr std::size_t most_implicit_nodes = 100'000;

struct StepPlan {
  const IntegratorInfo* integrator = nullptr;
  std::string integrator_reason{};
  int substeps = 1;
  std::string substeps_reason{};
  double h = 0.0;  ///< step of the integrator [s]
  SpectralBounds bounds{};
  /// First mode, and its damping ratio with these steps [1]; empty if the scheme adds no damping.
  std::optional<FirstMode> first_mode{};
  double stepped_damping_ratio = 0.0;
  std::map<std::string, double> stable_step{};  ///< by integrator [s]; infinite: no limit
  bool lattice = false;                         ///< regular lattice, computed in SIMD lanes
  int threads = 1;                              ///< number of threads for a lattice
  double sleep_force = 0.0;  ///< limit of the force withheld on sleeping nodes [N]; 0: none sleeps
  std::vector<int> touched{};                     ///< nodes that a tool can load; they never sleep
  std::shared_ptr<const ReductionSetting> far{};  ///< reduced-order model, or null
  std::string far_reason{};  ///< of the choice of `far`; empty if the scene sets it
  TipCompliance tip{};       ///< that the grid lacks under the tool
  PrintedForm printed{};
  std::string kernel{};
  std::vector<std::string> skipped{};  ///< omitted computations, each with the reason
  std::vector<std::string> warnings{};
  bool skip = true;
};

/// Throws std::invalid_argument for an integrator that is unknown or does not support an erratum.
StepPlan plan_steps(const Scene& scene, const Problem& problem, bool skip = true);

/// Returns the warning that a layer is dented too deep, because neither its cells nor the linear
/// compliance of the contact have the tension of a membrane.
std::string membrane_warning(const NeedlePath& path, const DentTable& table);

/// Builds the network in the planned form. `problem` must outlive it.
template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_network_system(const NetworkProblem& problem,
                                                         const StepPlan& plan);

}  // namespace palpate

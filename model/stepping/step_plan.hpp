// SPDX-License-Identifier: MIT
#pragma once
/// What a scene needs, decided before the first step and said in words.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/reduction/mode_basis.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/stability.hpp"

namespace palpate {

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
  double sleep_force = 0.0;                     ///< [N] as in NetworkOptions
  std::optional<NearNodes> near{};              ///< outside which a far field stands for the tissue
  std::string kernel{};
  std::vector<std::string> skipped{};  ///< "dampers: every spring has zero viscosity"
  std::vector<std::string> warnings{};
  bool skip = true;
};

/// Throws std::invalid_argument for an unknown integrator, or one that cannot carry an erratum.
StepPlan plan_steps(const Scene& scene, const Problem& problem, bool skip = true);

}  // namespace palpate

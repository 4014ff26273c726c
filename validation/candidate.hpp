// SPDX-License-Identifier: MIT
#pragma once
/// The one way in which a case lets the model move, so that a mutation reaches every case.

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "model/dynamics/scene.hpp"

namespace palpate {

struct CaseContext;
struct Insertion;

/// A sampled motion of the coordinates of a problem (free nodes, three each, in node order).
struct Motion {
  std::vector<double> time{};   ///< [s]
  Eigen::MatrixXd position{};   ///< dof x times [m]
  Eigen::MatrixXd velocity{};   ///< dof x times [m/s]; empty unless asked for
  std::vector<double> energy{}; ///< [J]; empty unless asked for
  bool diverged = false;
  double diverged_at = 0.0;     ///< [s]
  int substeps = 1;
  double h = 0.0;               ///< [s] of the integrator
  double seconds = 0.0;         ///< wall time of the ticks alone
  long steps = 0;
};

/// A fault planted in the candidate.
struct Mutation {
  std::string name{};
  std::function<void(Scene&, SpringNetwork&)> model{};  ///< before the run; network may be empty
  std::function<void(Motion&)> motion{};                ///< after it
  std::function<void(Insertion&)> insertion{};          ///< after that of a tool
  std::function<void(std::vector<double>&)> pressure{};  ///< of a simulated insertion, before it is compared [Pa]
  int loop_delay = 0;                                   ///< further ticks in every haptic loop
  bool step_twice = false;                              ///< every step taken with twice its length
};

struct Wanted {
  bool velocity = false;
  bool energy = false;
  long every = 1;  ///< ticks between samples; the first and the last are always there
};

/// The scene in motion; `network` replaces the scene's tissue unless it is nullptr.
Motion simulate(const CaseContext& context, Scene scene, const SpringNetwork* network = nullptr,
                const Wanted& wanted = {});

/// A scene around a network made in memory.
Scene scene_of(const std::string& integrator, double step, double duration, int substeps = 1);

}  // namespace palpate

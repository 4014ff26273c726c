// SPDX-License-Identifier: MIT
#pragma once
/// The one way in which a case lets a tool move in tissue, so that a mutation reaches every case.

#include <string>
#include <vector>

#include "model/dynamics/trace.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/candidate.hpp"

namespace palpate {

/// A tool in tissue, sampled at ticks; the first sample is t = 0.
struct Insertion {
  std::vector<double> time{};       ///< [s]
  std::vector<ToolReport> tool{};
  std::vector<std::string> layer{};
  std::vector<Event> events{};
  std::vector<double> pressure{};   ///< [Pa]; empty without a syringe
  std::vector<double> energy{};     ///< [J]
  Eigen::MatrixXd position{};       ///< dof x samples [m]; empty unless asked for
  Eigen::MatrixXd velocity{};       ///< likewise [m/s]
  bool diverged = false;
  std::string integrator{};
  int substeps = 1;
  double h = 0.0;                   ///< [s]
  double seconds = 0.0;             ///< wall time of the ticks alone

  /// Time of the first such event in a layer [s]; NaN when there was none.
  [[nodiscard]] double time_of(std::string_view kind, std::string_view detail = {}) const;
  [[nodiscard]] long count(std::string_view kind) const;
};

struct InsertionWanted {
  long every = 1;       ///< ticks between samples
  bool motion = false;  ///< position and velocity of the free nodes
};

/// The scene's tool in the scene's tissue.
Insertion insert_tool(const CaseContext& context, Scene scene, const InsertionWanted& wanted = {});

}  // namespace palpate

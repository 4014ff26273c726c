// SPDX-License-Identifier: MIT
#pragma once
/// A short insertion that calibrations are tried on, and its simulation as a straight line.

#include "validation/calibration/calibration.hpp"
#include "validation/case.hpp"
#include "validation/insertion.hpp"

namespace palpate::clinical {

/// The last 20 mm of an insertion through ligament, on one column of nodes: some 5 ms a simulation.
Scene short_way();
/// With syringes that reach the thumb's limit before the needle is through: beyond, the law bends.
std::vector<calibration::Parameter> fitted_parameters(const Scene& scene);
/// With the columns that observe() asks for.
Trace trace_of(const Insertion& run, std::vector<double> pressure);
/// The candidate: planted faults damage its scene, its insertion and its pressure.
calibration::ObservedInsertion candidate(const CaseContext& context, const Scene& scene);

/// The candidate as a straight line in what its observables are straight in: cutting forces, the thumb's
/// force, time constant and resistance of the syringe. Six simulations instead of thousands.
class StraightScene {
 public:
  explicit StraightScene(const CaseContext& context);
  [[nodiscard]] calibration::ObservedInsertion at(const Scene& scene) const;

 private:
  [[nodiscard]] Scene with_numbers(const Eigen::VectorXd& all) const;

  Scene base_;
  Eigen::VectorXd middle_;
  calibration::Observation value_{};
  Eigen::MatrixXd slope_{};
};

}  // namespace palpate::clinical

// SPDX-License-Identifier: MIT
#pragma once
/// Forward model of a calibration: the scene simulated at given parameter values.

#include <atomic>
#include <functional>
#include <map>
#include <stdexcept>
#include <vector>

#include "validation/calibration/observation.hpp"
#include "validation/calibration/parameter.hpp"

namespace palpate::calibration {

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Shortcuts for faster simulations. The block keeps its width with three nodes along x and y, if
/// it has a larger odd number of nodes (one column is then free); the step is multiplied by
/// `step_factor`; the scene ends `after` seconds after the needle stops.
struct Coarsening {
  bool block = true;
  double step_factor = 4.0;
  double after = 3.0;  ///< [s]
};
Scene coarser(Scene scene, const Coarsening& how = {});

/// Forward model from parameter values (in the order of the list) to observables, with a cache.
class Forward {
 public:
  using Values = std::vector<double>;
  /// Replacement of the simulation, for tests and planted faults.
  using Simulate = std::function<ObservedInsertion(const Scene&)>;

  Forward(Scene scene, std::vector<Parameter> parameters, int jobs = 1,
          const std::atomic<bool>* stop = nullptr, Simulate simulate = {});
  /// Simulates at several parameter values, `jobs` at a time; cached values are not simulated
  /// again. Throws runtime_error if a scene diverges or shows no loss of resistance.
  std::vector<Observation> at(const std::vector<Values>& places);
  Observation at(const Values& place) { return at(std::vector<Values>{place}).front(); }

  [[nodiscard]] const std::vector<Parameter>& parameters() const { return parameters_; }
  [[nodiscard]] std::size_t simulations() const { return seen_.size(); }
  [[nodiscard]] Values priors() const;

 private:
  Observation simulate(const Values& place) const;
  void simulate_new(const std::vector<Values>& places);

  Scene scene_;
  std::vector<Parameter> parameters_;
  int jobs_;
  const std::atomic<bool>* stop_;
  Simulate simulate_;
  std::map<Values, Observation> seen_{};
};

/// Runs the scene without shortcuts and returns its observables.
ObservedInsertion simulate_insertion(const Scene& scene, const std::atomic<bool>* stop = nullptr);

}  // namespace palpate::calibration

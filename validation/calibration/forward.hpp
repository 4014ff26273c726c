// SPDX-License-Identifier: MIT
#pragma once
/// The scene simulated at other values of its parameters: what a fit compares with recordings.

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

/// Keeps the width of the block with three nodes along x and y, where there is an odd number of
/// more (one column is free then); four times the step; and lasts for `after` seconds from when the
/// needle stops.
struct Coarsening {
  bool block = true;
  double step_factor = 4.0;
  double after = 3.0;  ///< [s]
};
Scene coarser(Scene scene, const Coarsening& how = {});

/// Values of parameters (in the order of the list) to observables.
class Forward {
 public:
  using Values = std::vector<double>;
  /// Replaces the simulation: for tests, and for planted faults.
  using Simulate = std::function<ObservedInsertion(const Scene&)>;

  Forward(Scene scene, std::vector<Parameter> parameters, int jobs = 1,
          const std::atomic<bool>* stop = nullptr, Simulate simulate = {});
  /// Simulated at `jobs` places at a time; a place that was seen before is not simulated again.
  /// Throws runtime_error for a scene that diverges or shows no loss of resistance there.
  std::vector<Observation> at(const std::vector<Values>& places);
  Observation at(const Values& place) { return at(std::vector<Values>{place}).front(); }

  [[nodiscard]] const std::vector<Parameter>& parameters() const { return parameters_; }
  [[nodiscard]] Scene scene_at(const Values& place) const {
    return with_values(scene_, parameters_, place);
  }
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

/// One run of the scene as it is.
ObservedInsertion simulate_insertion(const Scene& scene, const std::atomic<bool>* stop = nullptr);

}  // namespace palpate::calibration

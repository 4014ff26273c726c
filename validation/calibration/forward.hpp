// SPDX-License-Identifier: MIT
#pragma once
/// Forward model of a calibration: the scene simulated at given parameter values. Each parameter of
/// the layers down to the epidural space and of the syringe has a log-normal prior about the value
/// of the scene; user settings override the defaults.

#include <atomic>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/problem/scene.hpp"
#include "validation/calibration/observation.hpp"
#include "validation/subject/subject.hpp"

namespace palpate::calibration {

/// Half width in standard deviations of the interval that contains 0.95 of a normal distribution.
inline constexpr double normal_factor = 1.959964;

struct Parameter {
  std::string key{};  ///< as in --set: "material.fat.friction", "layer.1.thickness"
  std::string unit{};
  double prior = 0.0;   ///< value of the scene, > 0
  double spread = 0.5;  ///< standard deviation of its logarithm [1]
  double lower = 0.0;   ///< > 0; by default four spreads below the prior
  double upper = 0.0;
  std::string origin{};  ///< source of the spread

  /// Returns the standardised value: 0 is the prior, 1 is one spread above it.
  [[nodiscard]] double standardised(double value) const;
  [[nodiscard]] double value(double standardised) const;
};

/// Sets the bounds from prior and spread.
void set_default_bounds(Parameter& parameter);

/// Returns all parameters of a scene with a value above zero: layers in order, then the syringe.
std::vector<Parameter> parameters_of(const Scene& scene);

/// Returns the reason why a scene cannot be calibrated. It needs a needle on a prescribed path
/// through layers, with a syringe, beyond the epidural space. Empty if it can.
std::string why_not_calibrated(const Scene& scene);

/// Returns the scene with other values of those parameters that it has. If the thickness of a layer
/// changes, the end depth of the needle and the duration of the scene change accordingly.
Scene with_values(Scene scene, const std::vector<Parameter>& parameters,
                  const std::vector<double>& values);

/// Returns the keys and values in which `changed` differs from `scene`, of those that with_values()
/// may change.
std::vector<std::pair<std::string, double>> changes(const Scene& scene, const Scene& changed);

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

/// Forward model from parameter values (in the order of the list) to the observables of one or
/// several scenes, with a cache.
class Forward {
 public:
  using Values = std::vector<double>;
  /// Replacement of the simulation, for other observables, tests and planted faults.
  using Simulate = std::function<ObservedInsertion(const Scene&)>;

  /// The observables of several scenes follow one another. A parameter changes the scenes that
  /// have it.
  Forward(std::vector<Scene> scenes, std::vector<Parameter> parameters, int jobs = 1,
          const std::atomic<bool>* stop = nullptr, Simulate simulate = {});
  Forward(const Scene& scene, std::vector<Parameter> parameters, int jobs = 1,
          const std::atomic<bool>* stop = nullptr, Simulate simulate = {})
      : Forward(std::vector{scene}, std::move(parameters), jobs, stop, std::move(simulate)) {}
  /// Simulates at several parameter values, `jobs` at a time; cached values are not simulated
  /// again. Throws runtime_error if a scene diverges or shows no loss of resistance.
  std::vector<Observation> at(const std::vector<Values>& places);
  Observation at(const Values& place) { return at(std::vector<Values>{place}).front(); }

  [[nodiscard]] const std::vector<Parameter>& parameters() const { return parameters_; }
  [[nodiscard]] std::size_t simulations() const { return seen_.size(); }  ///< of single scenes
  [[nodiscard]] Values priors() const;

 private:
  /// A scene at the values of its own parameters.
  struct Trial {
    std::size_t scene = 0;
    Values values{};
    auto operator<=>(const Trial&) const = default;
  };
  [[nodiscard]] Trial trial(std::size_t scene, const Values& place) const;
  Observation simulate(const Trial& trial) const;
  void simulate_new(const std::vector<Trial>& trials);

  std::vector<Scene> scenes_;
  std::vector<Parameter> parameters_;
  std::vector<std::vector<std::size_t>> own_;  ///< indices of the parameters of each scene
  int jobs_;
  const std::atomic<bool>* stop_;
  Simulate simulate_;
  std::map<Trial, Observation> seen_{};
};

/// Runs a scene without shortcuts. Throws Interrupted on a stop.
Trace run_to_end(Subject& subject, const Scene& scene, const std::atomic<bool>* stop);

/// Returns the observables of a run; a refusal if it diverged.
ObservedInsertion observe_run(const Trace& run);

/// Runs the scene with our model and returns its observables.
ObservedInsertion simulate_insertion(const Scene& scene, const std::atomic<bool>* stop = nullptr);

}  // namespace palpate::calibration

// SPDX-License-Identifier: MIT
/// Short insertion for tests of calibrations, and a linear model of its simulation.

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "validation/calibration/calibration.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/claims/groups.hpp"
#include "validation/comparison/reconstruction.hpp"
#include "validation/roll_out.hpp"

namespace palpate::clinical {

namespace {

using namespace calibration;

/// Returns the last 20 mm of an insertion, on one column of nodes, which is fast to simulate.
Scene short_way() {
  Scene scene;
  scene.simulation = {.duration = 7.5, .step = 4e-3};
  scene.tissue.source = Source::layers;
  scene.tissue.fixed = {{Face::x_min, Face::x_max, Face::y_min, Face::y_max, Face::z_max}};
  scene.tissue.block = {.nodes = {3, 3}, .spacing = 0.01};
  const auto material = [](const char* name, double modulus, double cutting, double friction) {
    return Material{.name = name,
                    .youngs_modulus = modulus,
                    .density = 1100.0,
                    .damping_ratio = 0.5,
                    .cutting_force = cutting,
                    .friction = friction};
  };
  scene.materials = {material("interspinous", 10e6, 4.56, 74.0),
                     material("flavum", 15e6, 7.4, 354.0),
                     material("epidural-space", 2.4e3, 0.0, 0.0)};
  scene.tissue.layers = {{"interspinous", "interspinous", 0.0105},
                         {"flavum", "flavum", 0.0034},
                         {"epidural space", "epidural-space", 0.006}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.003, .depth = 0.0169};
  scene.syringe = Syringe{};
  return scene;
}

/// Parameters of syringes below the limit of the thumb, where the response is linear.
std::vector<Parameter> fitted_parameters(const Scene& scene) {
  std::vector<Parameter> parameters = parameters_of(scene);
  std::erase_if(parameters, [](const Parameter& p) {
    return !p.key.ends_with("cutting_force") && !p.key.ends_with("thumb_force") &&
           !p.key.ends_with("compliance") && !p.key.ends_with("epidural_resistance");
  });
  for (Parameter& p : parameters) {
    if (p.key.starts_with("syringe.")) { p.spread = 0.2; }
    set_default_bounds(p);
  }
  return parameters;
}

/// Runs the candidate, with the planted fault in its scene or trace, and returns its observables.
ObservedInsertion candidate(const CaseContext& context, const Scene& scene) {
  return observe(roll_out(context, scene, {}));
}

Eigen::VectorXd numbers(const Scene& scene) {
  const Syringe& s = *scene.syringe;
  Eigen::VectorXd all(5);
  all << scene.materials[0].cutting_force, scene.materials[1].cutting_force, s.thumb_force,
      s.compliance * s.epidural_resistance, s.epidural_resistance;
  return all;
}

/// Linear model of the candidate in the quantities with a linear effect: cutting forces, thumb
/// force, time constant and resistance of the syringe. It replaces thousands of simulations by six.
class StraightScene {
 public:
  explicit StraightScene(const CaseContext& context) {
    constexpr double step = 0.2;
    value_ = candidate(context, base_).value;
    slope_.resize(observable_count, middle_.size());
    for (Eigen::Index n = 0; n < middle_.size(); ++n) {
      Eigen::VectorXd there = middle_;
      there[n] *= 1.0 + step;
      slope_.col(n) =
          (candidate(context, with_numbers(there)).value - value_) / (step * middle_[n]);
    }
  }
  [[nodiscard]] ObservedInsertion at(const Scene& scene) const {
    return {.value = value_ + slope_ * (numbers(scene) - middle_), .force = ForceSource::recorded};
  }

 private:
  [[nodiscard]] Scene with_numbers(const Eigen::VectorXd& all) const {
    Scene scene = base_;
    scene.materials[0].cutting_force = all[0];
    scene.materials[1].cutting_force = all[1];
    scene.syringe->thumb_force = all[2];
    scene.syringe->compliance = all[3] / all[4];
    scene.syringe->epidural_resistance = all[4];
    return scene;
  }

  Scene base_ = short_way();
  Eigen::VectorXd middle_ = numbers(base_);
  Observation value_{};
  Eigen::MatrixXd slope_{};
};

// Calibration: known parameters are recovered within their intervals, and the groups of the trial
// keep the order and range of their published pressures.

/// Errors common to all readings of one study besides the transducer, of the size that the fit
/// assumes: depth, drop time, and forces in a coarser block.
void add_shared_errors(std::vector<ObservedRecording>& subjects, const SharedUncertainty& shared,
                       device::Seeded& seeded) {
  Observation offset = Observation::Zero(observable_count);
  Observation factor = Observation::Ones(observable_count);
  offset[index_of(Observable::drop_time)] = shared.drop_time * seeded.normal();
  offset[index_of(Observable::depth_of_loss)] = shared.depth * seeded.normal();
  for (Eigen::Index n = 0; n < observable_count; ++n) {
    if (calibration::unit_of(n) == "N") { factor[n] += shared.model * seeded.normal(); }
  }
  for (ObservedRecording& subject : subjects) {
    subject.seen.value = subject.seen.value.cwiseProduct(factor) + offset;
  }
}

/// Synthetic subjects, each with a factor on its tissue, measured with one transducer.
std::vector<ObservedRecording> noisy_subjects(const Scene& scene, std::size_t count,
                                              device::Seeded& seeded) {
  const Trace clean = roll_out({}, scene, {});
  const SharedUncertainty shared;
  const double zero = shared.transducer.zero * seeded.normal();
  const double gain = 1.0 + shared.transducer.gain * seeded.normal();
  const double force_gain = 1.0 + shared.force_gain * seeded.normal();
  std::vector<ObservedRecording> subjects;
  for (std::size_t n = 0; n < count; ++n) {
    const double factor = 1.0 + 0.1 * seeded.normal();
    Recording recording{.name = "made-up",
                        .sample_rate = 250.0,
                        .time = clean.time,
                        .pressure = clean.values("syringe.pressure_pa"),
                        .depth = clean.values("tool.depth_m"),
                        .force = clean.values("tool.force_n")};
    for (double& p : recording.pressure) { p = gain * factor * p + zero; }
    for (double& f : recording.force) { f *= force_gain * factor; }
    add_noise(recording.pressure, 0.3 * pascals_per_mmhg, seeded);
    add_noise(recording.force, 0.02, seeded);
    subjects.push_back({.recording = {.name = recording.name}, .seen = observe(recording)});
  }
  add_shared_errors(subjects, shared, seeded);
  return subjects;
}

struct Coverage {
  std::vector<std::size_t> held{};
  double constrained = 0.0;  ///< parameters that the data constrain
  double squares = 0.0;      ///< of errors over stated deviations
};

/// Draws true values from the priors; the flavum needs more force than the layers before it.
Forward::Values drawn_truth(const std::vector<Parameter>& parameters, device::Seeded& seeded) {
  Forward::Values truth;
  for (const Parameter& p : parameters) { truth.push_back(p.value(seeded.normal())); }
  truth[1] = std::fmax(truth[1], 1.05 * truth[0]);
  return truth;
}

void fit_one(const StraightScene& straight, std::uint64_t seed, Coverage& coverage) {
  const Scene scene = short_way();
  const std::vector<Parameter> parameters = fitted_parameters(scene);
  device::Seeded seeded(seed);
  const Forward::Values truth = drawn_truth(parameters, seeded);
  const std::vector<ObservedRecording> subjects =
      noisy_subjects(with_values(scene, parameters, truth), 5, seeded);
  Forward forward(scene, parameters, 1, nullptr, [&](const Scene& at) { return straight.at(at); });
  const Fit found = fit(forward, pool(subjects));
  coverage.held.resize(parameters.size(), 0);
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    const FittedParameter& each = found.parameters[n];
    coverage.held[n] += each.interval.holds(truth[n]) ? 1 : 0;
    coverage.constrained += each.telling == Telling::told ? 1.0 : 0.0;
    const double error =
        each.parameter.standardised(each.value) - each.parameter.standardised(truth[n]);
    coverage.squares += error * error / (each.deviation * each.deviation);
  }
}

/// Returns the RMS relative difference between the linear model and the undamaged simulation.
double straightness(const StraightScene& straight) {
  const Scene scene = short_way();
  const std::vector<Parameter> parameters = fitted_parameters(scene);
  Largest worst;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    device::Seeded seeded(seed);
    const Scene other = with_values(scene, parameters, drawn_truth(parameters, seeded));
    const Eigen::VectorXd errors =
        relative_errors(straight.at(other).value, candidate({}, other).value);
    worst.add(root_mean_square(errors));
  }
  return worst.value();
}

void measure_coverage(const CaseContext& context, Outcome& outcome) {
  // With fewer than 149 trials intervals of any width could pass: 0.95^149 < 0.0005.
  const std::size_t trials = context.quick ? 160 : 300;
  const StraightScene straight(context);
  Coverage coverage;
  for (std::size_t n = 0; n < trials; ++n) { fit_one(straight, 1000 + n, coverage); }
  const std::vector<Parameter> parameters = fitted_parameters(short_way());
  const comparison::Interval expected = comparison::expected_share(0.95, trials);
  for (std::size_t n = 0; n < parameters.size(); ++n) {
    outcome.judge_between("intervals_that_hold_" + parameters[n].key,
                          static_cast<double>(coverage.held[n]) / static_cast<double>(trials),
                          expected.lower, expected.upper,
                          "0.95 is stated of each interval; binomial, 0.999");
  }
  const double all = static_cast<double>(trials * parameters.size());
  outcome.judge_at_most("straight_line_against_simulation", straightness(straight),
                        0.1 / std::sqrt(5.0),
                        "standard error of the mean of five subjects who differ by 10 %");
  outcome.report("share_of_parameters_told", coverage.constrained / all);
  outcome.report("rms_error_over_stated_deviation", std::sqrt(coverage.squares / all));
}

struct Group {
  const char* name;
  double body_mass_index;  ///< middle [kg/m^2]
  double peak;             ///< published mean [mmHg], Wee et al. 2017
};
constexpr std::array groups{Group{"BMI 18-24.9", 22.0, 461.0}, Group{"BMI 25-34.9", 30.0, 430.0},
                            Group{"BMI 35-44.9", 40.0, 415.0}, Group{"BMI >= 45", 47.0, 376.0}};

/// Returns groups of five subjects with the published mean and the spread of the stored recordings.
std::vector<ObservedRecording> reconstructed_group(const Group& group, std::uint64_t seed) {
  std::vector<ObservedRecording> subjects;
  constexpr double ligament_ratio = 7.467 / 12.133;  // of the needle force, Davidor et al. 2023
  for (const double score : even_scores(5, seed)) {
    const double peak = group.peak * pascals_per_mmhg * (1.0 + 0.22 * score);
    const Recording drawn = draw_insertion({.plateau = ligament_ratio * peak,
                                            .peak = peak,
                                            .floor = 15.0 * pascals_per_mmhg,
                                            .start = 0.5e-3,
                                            .flavum_begin = 10.5e-3,
                                            .flavum_end = 13.9e-3,
                                            .tremor = 0.02,
                                            .noise = 0.3 * pascals_per_mmhg,
                                            .seed = seed + subjects.size()});
    subjects.push_back(
        {.recording = {.name = drawn.name, .group = group.name}, .seen = observe(drawn)});
  }
  return subjects;
}

/// Returns the peak pressure of the scene that was fitted to these recordings [mmHg].
double fitted_peak(const StraightScene& straight, std::span<const ObservedRecording> subjects) {
  const Scene scene = short_way();
  Forward forward(scene, fitted_parameters(scene), 1, nullptr,
                  [&](const Scene& at) { return straight.at(at); });
  return fit(forward, pool(subjects)).after[index_of(Observable::pressure_peak)] / pascals_per_mmhg;
}

double slope_over_body_mass(const std::array<double, groups.size()>& peaks) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (std::size_t n = 0; n < groups.size(); ++n) {
    mean_x += groups[n].body_mass_index / groups.size();
    mean_y += peaks[n] / groups.size();
  }
  double products = 0.0;
  double squares = 0.0;
  for (std::size_t n = 0; n < groups.size(); ++n) {
    const double x = groups[n].body_mass_index - mean_x;
    products += x * (peaks[n] - mean_y);
    squares += x * x;
  }
  return products / squares;
}

void measure_groups(const CaseContext& context, Outcome& outcome) {
  const StraightScene straight(context);
  std::array<std::vector<ObservedRecording>, groups.size()> subjects;
  std::array<double, groups.size()> own{};
  for (std::size_t n = 0; n < groups.size(); ++n) {
    subjects[n] = reconstructed_group(groups[n], 10 * n + 1);
  }
  for (std::size_t n = 0; n < groups.size(); ++n) {
    own[n] = fitted_peak(straight, subjects[n]);
    std::vector<ObservedRecording> others;
    for (std::size_t m = 0; m < groups.size(); ++m) {
      if (m != n) { others.insert(others.end(), subjects[m].begin(), subjects[m].end()); }
    }
    outcome.judge_between(std::string("peak_calibrated_without_") + groups[n].name,
                          fitted_peak(straight, others), 376.0, 500.0,
                          "least mean of the trial (Wee 2017), highest porcine peak (Vaughan 2012)",
                          "mmHg");
    outcome.report(std::string("peak_calibrated_on_") + groups[n].name, own[n], "mmHg");
  }
  outcome.judge_at_most("slope_of_calibrated_peaks_over_bmi", slope_over_body_mass(own), -0.04,
                        "published means fall: 461, 430, 415, 376 mmHg (p = 0.52: no size is "
                        "claimed); rounding them to 1 mmHg over 25 kg/m^2 alone makes 0.04",
                        "mmHg m^2/kg");
  outcome.notes.emplace_back(
      "Circular by nature: the groups are drawn from the published means, so that what is shown is "
      "that a calibration hands them on, not that simulated forces match patients.");
}

/// Peak pressures of the shipped scenes of four body-mass indices, with their own force of the
/// thumb and with one for all.
void measure_body_mass(const CaseContext& context, Outcome& outcome) {
  if (!context.shipped_scene) { throw CannotDo("not run: the shipped scenes are not at hand"); }
  Table& table = outcome.table("peaks", "Peak pressure and body-mass index",
                               "Peaks with each scene's own force of the thumb, and with that of "
                               "the first scene in all: then "
                               "the scenes differ in their fat alone.",
                               {"BMI (kg/m^2)", "published (mmHg)", "own (mmHg)", "shared (mmHg)"});
  std::optional<double> thumb;
  Largest off;
  Largest fat_alone;
  double first = 0.0;
  for (const Group& group : groups) {
    const auto index = static_cast<int>(group.body_mass_index);
    std::optional<Scene> scene = context.shipped_scene("epidural-bmi-" + std::to_string(index));
    if (!scene) { throw CannotDo("not run: the shipped scenes are not at hand"); }
    const auto peak = [](const Scene& of) {
      const Scene less = coarser(of);
      ModelSubject model{Simulation(less)};
      const Trace run = run_to_end(model, less, nullptr);
      return std::ranges::max(run.values("syringe.pressure_pa")) / pascals_per_mmhg;
    };
    const double own = peak(*scene);
    thumb = thumb.value_or(scene->syringe->thumb_force);
    scene->syringe->thumb_force = *thumb;
    const double shared = peak(*scene);
    if (first == 0.0) { first = shared; }
    off.add(std::abs(own / group.peak - 1.0));
    fat_alone.add(std::abs(shared / first - 1.0));
    table.rows.push_back({index, group.peak, own, shared});
  }
  outcome.judge_at_most("error_of_peak_pressure", off.value(), 0.005,
                        "published means, to 1 mmHg, and forces of the thumb to 0.01 N");
  outcome.judge_at_most("change_of_peak_by_fat_alone", fat_alone.value(), 1e-12,
                        "the thumb alone limits the pressure; rounding");
  outcome.notes.emplace_back(
      "Circular by nature: the thumb's force of each scene is the published mean times the area of "
      "the plunger. The trial does not say why the means differ (p = 0.52).");
}

}  // namespace

std::vector<Case> calibration_cases() {
  return {
      {"clinical/body-mass", "clinical",
       "The scenes of four body-mass indices have the published peak pressures, by the force of "
       "the thumb: more fat does not change the peak.",
       measure_body_mass, 1.0},
      {"clinical/calibration/coverage", "clinical",
       "Known parameters come back from noisy recordings within the intervals that a "
       "calibration states.",
       measure_coverage, 3.0},
      {"clinical/calibration/groups", "clinical",
       "Calibrated on each BMI group pressure falls with BMI; on all others it stays in the "
       "published range.",
       measure_groups, 0.5}};
}

}  // namespace palpate::clinical

// SPDX-License-Identifier: MIT

#include "reference/solver_cross_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "reference/exact_problems.hpp"
#include "reference/integrate.hpp"

namespace palpate::reference {

using Eigen::MatrixXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void check_sizes(const MatrixXd& candidate, const MatrixXd& reference) {
  if (candidate.rows() != reference.rows() || candidate.cols() != reference.cols() ||
      reference.size() == 0) {
    throw std::invalid_argument("trajectories of different size cannot be compared");
  }
}

}  // namespace

double peak_displacement(const MatrixXd& position) {
  if (!position.allFinite()) { return infinity; }
  return (position.colwise() - position.col(0)).cwiseAbs().maxCoeff();
}

double peak_speed(const MatrixXd& velocity) {
  return velocity.allFinite() ? velocity.cwiseAbs().maxCoeff() : infinity;
}

std::vector<double> instant_errors(const MatrixXd& candidate, const MatrixXd& reference,
                                   double scale) {
  check_sizes(candidate, reference);
  std::vector<double> errors;
  for (Eigen::Index n = 0; n < reference.cols(); ++n) {
    const auto difference = candidate.col(n) - reference.col(n);
    if (!difference.allFinite() || !std::isfinite(scale)) {
      errors.push_back(infinity);
      continue;
    }
    const double largest = difference.cwiseAbs().maxCoeff();
    errors.push_back(largest == 0.0 ? 0.0 : largest / scale);
  }
  return errors;
}

double trajectory_error(const MatrixXd& candidate, const MatrixXd& reference, double scale) {
  return std::ranges::max(instant_errors(candidate, reference, scale));
}

double digits(double error) {
  if (!(error < infinity)) { return 0.0; }
  return std::clamp(-std::log10(error), 0.0, 17.0);
}

namespace {

struct Scales {
  double position;
  double velocity;
};

Scales scales_of(const Trace& solution) {
  return {peak_displacement(solution.position), peak_speed(solution.velocity)};
}

void check_families(const std::vector<NamedSolver>& families) {
  const auto differs = [&](const NamedSolver& s) { return s.family != families.front().family; };
  if (families.size() < 2 || !std::ranges::any_of(families, differs)) {
    throw std::invalid_argument("a reference needs solvers of at least two families");
  }
}

void refuse(Reference& reference, const std::string& reason) {
  reference.reason += (reference.reason.empty() ? "" : "; ") + reason;
}

std::string rounded(double digits) {
  return std::to_string(std::floor(10.0 * digits) / 10.0).substr(0, 4);
}

void climb(const Problem& problem, const Tolerance& finest, const NamedSolver& primary,
           const EstablishOptions& options, Reference& reference) {
  const Scales scales = scales_of(reference.solution);
  for (int below = options.rungs - 1; below > 0; --below) {
    Tolerance tolerance = finest;
    tolerance.relative *= std::pow(options.rung_ratio, below);
    Rung rung{tolerance.relative, infinity, infinity};
    try {
      const Trace coarse = solve_cached(options.cache, primary.name, primary.solve, problem,
                                        reference.solution.time, tolerance);
      rung.position_error =
          trajectory_error(coarse.position, reference.solution.position, scales.position);
      rung.velocity_error =
          trajectory_error(coarse.velocity, reference.solution.velocity, scales.velocity);
      rung.steps = coarse.steps;
      rung.evaluations = coarse.evaluations;
      rung.seconds = coarse.seconds;
    } catch (const SolverError& error) { reference.notes.push_back(error.what()); }
    reference.ladder.push_back(rung);
  }
}

void judge_ladder(const EstablishOptions& options, Reference& reference) {
  if (options.rungs < 4) {
    reference.notes.push_back("ladder of " + std::to_string(options.rungs) +
                              " tolerances; 4 make a reference");
  }
  // At the level of rounding the order cannot be measured.
  constexpr double rounding = 1e-13;
  reference.ladder_is_monotone = true;
  for (std::size_t n = 1; n < reference.ladder.size(); ++n) {
    const double before = reference.ladder[n - 1].position_error;
    const double now = reference.ladder[n].position_error;
    const bool falls = now < before || now < rounding;
    reference.ladder_is_monotone = reference.ladder_is_monotone && falls;
  }
  if (!reference.ladder_is_monotone) {
    refuse(reference, "tighter tolerances do not come closer to the finest");
  }
}

void raise(std::vector<double>& floor, const std::vector<double>& errors) {
  floor.resize(errors.size(), 0.0);
  for (std::size_t n = 0; n < errors.size(); ++n) { floor[n] = std::max(floor[n], errors[n]); }
}

void ask_others(const Problem& problem, const Tolerance& finest,
                const std::vector<NamedSolver>& families, const EstablishOptions& options,
                Reference& reference) {
  const Trace& primary = reference.solution;
  const Scales scales = scales_of(primary);
  bool complete = true;
  for (auto other = families.begin() + 1; other != families.end(); ++other) {
    try {
      Trace opinion =
          solve_cached(options.cache, other->name, other->solve, problem, primary.time, finest);
      raise(reference.position_floor,
            instant_errors(opinion.position, primary.position, scales.position));
      raise(reference.velocity_floor,
            instant_errors(opinion.velocity, primary.velocity, scales.velocity));
      reference.second_opinions.push_back(std::move(opinion));
    } catch (const SolverError& error) {
      complete = false;
      refuse(reference, std::string("no second opinion: ") + error.what());
    }
  }
  if (!complete) { return; }
  reference.agreed_digits = digits(std::ranges::max(reference.position_floor));
  reference.agreed_velocity_digits = digits(std::ranges::max(reference.velocity_floor));
}

void judge_steps(const Problem& problem, Reference& reference) {
  const long steps = reference.solution.steps;
  const auto least = static_cast<long>(segments_of(problem, reference.solution.time).size()) + 9;
  if (steps > 0 && steps < least) {  // a closed form takes no steps
    refuse(reference, "only " + std::to_string(steps) + " steps; breaks + 10 are demanded");
  }
}

void judge_agreement(const EstablishOptions& options, Reference& reference) {
  if (reference.second_opinions.empty()) { return; }  // already rejected
  if (reference.agreed_digits < options.demanded_digits) {
    refuse(reference, "the families agree to " + rounded(reference.agreed_digits) + " digits; " +
                          rounded(options.demanded_digits) + " are demanded");
  }
}

/// Returns the same network with its springs reordered and reversed. Returns nothing if that is
/// another problem: springs of a printed form of the equations are not accessible.
std::optional<NetworkProblem> permuted(const NetworkProblem& problem) {
  SpringNetwork network = problem.network();
  std::mt19937 order(20);  // any fixed seed; the order must be reproducible
  network.springs.edit([&](std::vector<Spring>& all) { std::ranges::shuffle(all, order); });
  network.springs.change_each([&](Spring& spring) { std::swap(spring.a, spring.b); });
  NetworkProblem shuffled(std::move(network), problem.loads(), problem.gravity());
  Eigen::VectorXd q = problem.initial_position();
  q.array() +=
      1e-3 * q.cwiseAbs().maxCoeff() * Eigen::ArrayXd::LinSpaced(q.size(), -1.0, 1.0).sin();
  const Eigen::VectorXd v = Eigen::ArrayXd::LinSpaced(q.size(), -1.0, 1.0).cube();
  Eigen::VectorXd f(q.size()), shuffled_f(q.size());
  problem.force(0.0, 0.0, q, v, f);
  shuffled.force(0.0, 0.0, q, v, shuffled_f);
  if ((f - shuffled_f).norm() > 1e-10 * f.norm()) { return std::nullopt; }
  return shuffled;
}

void condition(const Problem& problem, const Tolerance& finest, const NamedSolver& primary,
               Reference& reference) {
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  const auto shuffled = network != nullptr ? permuted(*network) : std::nullopt;
  if (!shuffled) {
    reference.notes.emplace_back("permuted springs: not run, not a network of the corrected law");
    return;
  }
  const Trace other = primary.solve(*shuffled, reference.solution.time, finest);
  const Scales scales = scales_of(reference.solution);
  reference.conditioning_digits =
      digits(trajectory_error(other.position, reference.solution.position, scales.position));
}

bool conserves_energy(const Problem& problem) {
  if (const auto* linear = dynamic_cast<const LinearProblem*>(&problem)) {
    return conserves_energy(linear->base());
  }
  if (const auto* oscillator = dynamic_cast<const OscillatorProblem*>(&problem)) {
    const Oscillator& o = oscillator->oscillator();
    return o.viscosity == 0.0 && o.drive_amplitude == 0.0;
  }
  const auto* network = dynamic_cast<const NetworkProblem*>(&problem);
  return network != nullptr && network->loads().empty() && !is_damped(network->network());
}

}  // namespace

std::optional<double> energy_digits(const Problem& problem, const Trace& solution) {
  if (!conserves_energy(problem)) { return std::nullopt; }
  double drift = 0.0;
  double kinetic = 0.0;
  const double begin = problem.energy(solution.position.col(0), solution.velocity.col(0));
  for (Eigen::Index n = 0; n < solution.position.cols(); ++n) {
    const auto v = solution.velocity.col(n);
    const double change = std::abs(problem.energy(solution.position.col(n), v) - begin);
    if (!std::isfinite(change)) { return 0.0; }
    drift = std::max(drift, change);
    kinetic = std::max(kinetic, 0.5 * v.cwiseAbs2().dot(problem.mass()));
  }
  return digits(drift == 0.0 ? 0.0 : drift / kinetic);
}

Reference establish(const Problem& problem, const std::vector<double>& times,
                    const Tolerance& finest, const std::vector<NamedSolver>& families,
                    const EstablishOptions& options) {
  check_families(families);
  const NamedSolver& primary = families.front();
  Reference reference;
  reference.solution =
      solve_cached(options.cache, primary.name, primary.solve, problem, times, finest);
  ask_others(problem, finest, families, options, reference);
  judge_agreement(options, reference);
  judge_steps(problem, reference);
  climb(problem, finest, primary, options, reference);
  judge_ladder(options, reference);
  if (options.permute_springs) { condition(problem, finest, primary, reference); }
  reference.energy_digits = energy_digits(problem, reference.solution);
  reference.trustworthy = reference.reason.empty();
  return reference;
}

}  // namespace palpate::reference

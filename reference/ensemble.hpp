// SPDX-License-Identifier: MIT
#pragma once
/// When a computed trajectory may be called a reference: several methods of different families
/// agree, tighter tolerances come closer, energy balances where it must. Every check that was not
/// made is named in `notes`.

#include <optional>
#include <string>
#include <vector>

#include "reference/cache.hpp"
#include "reference/solution.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

struct EstablishOptions {
  int rungs = 4;                 ///< tolerances of the primary; 1 where a ladder costs too much
  double rung_ratio = 100.0;     ///< between neighbouring tolerances
  double demanded_digits = 9.0;  ///< of agreement, in position
  const Cache* cache = nullptr;  ///< of solutions between runs; nullptr: none
  bool permute_springs = false;  ///< run once more with the springs in another order
};

/// One tolerance of the primary against its finest.
struct Rung {
  double relative_tolerance = 0.0;
  double position_error = 0.0;  ///< as trajectory_error; infinite when the solver failed
  double velocity_error = 0.0;
  long steps = 0;
  long evaluations = 0;
  double seconds = 0.0;
};

/// Errors are relative to the peak displacement and the peak speed of the primary.
struct Reference {
  Solution solution{};                      ///< the primary, at the finest tolerance
  std::vector<Solution> second_opinions{};  ///< the other families
  std::vector<Rung> ladder{};               ///< coarse to fine, without the finest itself
  bool ladder_is_monotone = false;
  double agreed_digits = 0.0;  ///< in position, worst instant, worst second opinion
  double agreed_velocity_digits = 0.0;
  std::vector<double> position_floor{};  ///< disagreement at each stored instant
  std::vector<double> velocity_floor{};
  std::optional<double> energy_digits{};        ///< undamped and unloaded problems only
  std::optional<double> conditioning_digits{};  ///< of the run with permuted springs
  bool trustworthy = false;
  std::string reason{};              ///< why not; empty when trustworthy
  std::vector<std::string> notes{};  ///< checks not made, and why
};

/// families: the primary first, then at least one of another family (std::invalid_argument
/// otherwise). SolverError when the primary fails; a second opinion that fails is a reason.
Reference establish(const Problem& problem, const std::vector<double>& times,
                    const Tolerance& finest, const std::vector<NamedSolver>& families,
                    const EstablishOptions& options = {});

/// Digits of energy conservation along a solution, relative to its largest kinetic energy; nothing
/// for a problem that is damped, loaded, or of an unknown kind.
std::optional<double> energy_digits(const Problem& problem, const Solution& solution);

}  // namespace palpate::reference

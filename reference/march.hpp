// SPDX-License-Identifier: MIT
#pragma once
/// The part of every solution that does not depend on the method: restart at each break, stop at
/// each requested time, store, count, and refuse a run that took too few steps.

#include <string>
#include <vector>

#include "reference/first_order.hpp"
#include "reference/segments.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

/// A run ends with an error rather than never: most steps between two stops.
inline constexpr long step_limit = 10'000'000;

/// One library's integrator over y = [u; v] of a FirstOrderSystem.
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual void begin(const Segment& segment) = 0;  ///< restart at segment.start from state()
  virtual void advance(double time) = 0;           ///< state() at `time` [s], or SolverError
  [[nodiscard]] virtual const double* state() const = 0;
  [[nodiscard]] virtual long segment_steps() const = 0;  ///< since begin()
};

struct Method {
  std::string name{};     ///< "cvode-adams"
  std::string version{};  ///< "SUNDIALS 6.4.1"
};

/// Throws SolverError, also when steps < breaks + 10 or the result is not finite.
Solution march(const Method& method, FirstOrderSystem& system, const std::vector<double>& times,
               const Tolerance& tolerance, Integrator& integrator);

/// "cvode-adams: CVode failed with CV_TOO_MUCH_WORK at t = 0.01 s: <why>"
[[noreturn]] void fail(const std::string& solver, const std::string& function,
                       const std::string& flag, double time, const std::string& why);

}  // namespace palpate::reference

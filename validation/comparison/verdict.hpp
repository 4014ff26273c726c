// SPDX-License-Identifier: MIT
#pragma once
/// What a comparison may conclude, for one number and for a whole.

#include <string>
#include <string_view>
#include <vector>

namespace palpate::comparison {

enum class Verdict {
  agrees,               ///< within its tolerance even if off by the validation uncertainty
  not_distinguishable,  ///< the uncertainty reaches across the edge of the tolerance: nobody can tell
  differs,              ///< outside even if off by the validation uncertainty
  not_comparable,       ///< there is nothing to compare, and a reason why
  not_judged,           ///< of one feature: absent from both, or fixed by the alignment
};
std::string_view name_of(Verdict verdict);  ///< "not distinguishable"

/// Standard uncertainties of ASME V&V 20: the error E = S - D is known to within u_val = sqrt(num^2 +
/// input^2 + data^2), and |E| < u_val says nothing about the model.
struct ValidationUncertainty {
  double numerical = 0.0;  ///< u_num, of the simulated value: step, sampling
  double input = 0.0;      ///< u_input, of what the simulation was given
  double data = 0.0;       ///< u_D, of the recorded value: noise, sampling, transducer
  [[nodiscard]] double total() const;
};

/// S - D against an allowed interval of S, with expanded uncertainty (coverage factor times u_val).
Verdict judge(double simulated, double lower, double upper, double expanded);

/// Why, with what it led to; for people.
struct Reason {
  Verdict verdict = Verdict::not_judged;
  std::string text{};
};
/// Their texts, what led to the worst first and else in the order given: the first explains the whole.
std::vector<std::string> worst_first(std::vector<Reason> reasons);

/// The worst of two: differs, then not distinguishable, then agrees; not judged counts for nothing.
Verdict worse(Verdict a, Verdict b);

}  // namespace palpate::comparison

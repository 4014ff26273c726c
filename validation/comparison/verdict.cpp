// SPDX-License-Identifier: MIT
#include "validation/comparison/verdict.hpp"

#include <cmath>

namespace palpate::comparison {

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees: return "agrees";
    case Verdict::not_distinguishable: return "not distinguishable";
    case Verdict::differs: return "differs";
    case Verdict::not_comparable: return "not comparable";
    case Verdict::not_judged: break;
  }
  return "not judged";
}

double ValidationUncertainty::total() const { return std::hypot(numerical, input, data); }

Verdict judge(double simulated, double lower, double upper, double expanded) {
  if (!(std::isfinite(simulated) && std::isfinite(lower) && std::isfinite(upper) &&
        std::isfinite(expanded))) {
    return Verdict::not_comparable;
  }
  if (simulated + expanded < lower || simulated - expanded > upper) { return Verdict::differs; }
  const bool inside = simulated - expanded >= lower && simulated + expanded <= upper;
  return inside ? Verdict::agrees : Verdict::not_distinguishable;
}

Verdict worse(Verdict a, Verdict b) {
  const auto rank = [](Verdict v) {
    switch (v) {
      case Verdict::not_comparable: return 4;
      case Verdict::differs: return 3;
      case Verdict::not_distinguishable: return 2;
      case Verdict::agrees: return 1;
      case Verdict::not_judged: break;
    }
    return 0;
  };
  return rank(a) >= rank(b) ? a : b;
}

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#include "validation/comparison/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace palpate::comparison {

namespace {

/// Not judged counts for nothing.
int rank(Verdict verdict) {
  switch (verdict) {
    case Verdict::not_comparable: return 4;
    case Verdict::differs: return 3;
    case Verdict::not_distinguishable: return 2;
    case Verdict::agrees: return 1;
    case Verdict::not_judged: break;
  }
  return 0;
}

}  // namespace

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

Verdict worse(Verdict a, Verdict b) { return rank(a) >= rank(b) ? a : b; }

std::vector<std::string> worst_first(std::vector<Reason> reasons) {
  std::ranges::stable_sort(reasons, std::greater{}, [](const Reason& one) { return rank(one.verdict); });
  std::vector<std::string> texts;
  for (Reason& one : reasons) { texts.push_back(std::move(one.text)); }
  return texts;
}

}  // namespace palpate::comparison

// SPDX-License-Identifier: MIT
#include "validation/comparison/verdict.hpp"

#include <limits>

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

TEST("inside with all its uncertainty agrees, outside with all of it differs, between nobody can tell") {
  CHECK(judge(10.0, 9.0, 11.0, 0.5) == Verdict::agrees);
  CHECK(judge(10.8, 9.0, 11.0, 0.5) == Verdict::not_distinguishable);
  CHECK(judge(11.2, 9.0, 11.0, 0.5) == Verdict::not_distinguishable);
  CHECK(judge(11.6, 9.0, 11.0, 0.5) == Verdict::differs);
  CHECK(judge(8.4, 9.0, 11.0, 0.5) == Verdict::differs);
  CHECK(judge(10.0, 9.0, 11.0, 5.0) == Verdict::not_distinguishable);  // larger than the tolerance
}

TEST("what is not a number is never judged") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(judge(nan, 0.0, 1.0, 0.1) == Verdict::not_comparable);
  CHECK(judge(0.5, 0.0, nan, 0.1) == Verdict::not_comparable);
  CHECK(judge(0.5, 0.0, 1.0, nan) == Verdict::not_comparable);
}

TEST("uncertainties add in squares") {
  CHECK_NEAR((ValidationUncertainty{.numerical = 2.0, .input = 3.0, .data = 6.0}.total()), 7.0, 1e-15);
}

TEST("the worst verdict is that of the whole") {
  CHECK(worse(Verdict::agrees, Verdict::differs) == Verdict::differs);
  CHECK(worse(Verdict::not_distinguishable, Verdict::agrees) == Verdict::not_distinguishable);
  CHECK(worse(Verdict::not_judged, Verdict::agrees) == Verdict::agrees);
  CHECK(worse(Verdict::not_distinguishable, Verdict::differs) == Verdict::differs);
}

TEST("verdicts read as people say them") {
  CHECK(name_of(Verdict::agrees) == "agrees" && name_of(Verdict::differs) == "differs");
  CHECK(name_of(Verdict::not_distinguishable) == "not distinguishable");
  CHECK(name_of(Verdict::not_comparable) == "not comparable");
}

TEST("what led to the worst is told first, and the order is kept among equals") {
  const std::vector<std::string> told = worst_first({{Verdict::not_distinguishable, "a"},
                                                     {Verdict::differs, "b"},
                                                     {Verdict::not_judged, "c"},
                                                     {Verdict::differs, "d"},
                                                     {Verdict::not_distinguishable, "e"}});
  CHECK(told == std::vector<std::string>({"b", "d", "a", "e", "c"}));
}

}  // namespace

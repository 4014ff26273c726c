// SPDX-License-Identifier: MIT
#include "validation/comparison/prepared_trace.hpp"

#include "tests/check.hpp"
#include "validation/cases/clinical_traces.hpp"

namespace {

using namespace palpate;
using namespace palpate::comparison;

std::string refusal(const std::vector<double>& time, const std::vector<double>& value) {
  return refusal_of({.time = time, .value = value});
}

TEST("what cannot be compared is refused with its reason") {
  CHECK(refusal({}, {}) == "is empty");
  CHECK(refusal({0.0}, {1.0}) == "has one sample");
  CHECK(refusal({0.0, 1.0}, {1.0}) == "has more times than values, or fewer");
  CHECK(refusal({0.0, 0.0}, {1.0, 2.0}) == "has times that do not increase");
  CHECK(refusal({0.0, 1.0}, {not_measured, not_measured}) == "holds no number");
  CHECK(refusal({0.0, 1.0, 2.0}, {1.0, 2.0, 3.0}) == "holds fewer than 10 numbers");
  const std::vector<double> time = clinical::instants(1.0, 100.0);
  CHECK(refusal(time, std::vector<double>(time.size(), 7.0)) == "is constant");
  CHECK(refusal(time, time).empty());
  std::vector<double> huge = time;
  huge[3] = -1e101;
  CHECK(refusal(time, huge) == "holds a value beyond 1e100");
  std::vector<double> far = time;
  far.back() = 1e9;  // a grid of its usual interval would have 1e11 instants
  CHECK(refusal(far, time) == "spans more than ten million of its usual intervals");
}

TEST("a trace of single samples between gaps is refused") {
  const std::vector<double> time = clinical::instants(1.0, 100.0);
  std::vector<double> value = time;
  for (std::size_t n = 0; n < value.size(); n += 2) { value[n] = not_measured; }
  CHECK(prepare({.time = time, .value = value}, 20.0, {}).refusal == "has no three samples without a gap");
}

TEST("a good trace keeps its samples, its filtered ones and its depth on one grid") {
  const std::vector<double> time = clinical::instants(14.0, 100.0);
  const std::vector<double> value = clinical::pressures({}, time);
  const PreparedTrace prepared = prepare({.time = time, .value = value, .depth = time}, 20.0, {});
  CHECK(prepared.refusal.empty());
  CHECK(prepared.input.raw.size() == time.size() && prepared.input.filtered.size() == time.size());
  CHECK(prepared.input.depth.size() == time.size());
  CHECK_NEAR(1.0 / prepared.input.raw.step, 100.0, 1e-6);
  CHECK(prepared.features.loss.found());
}

}  // namespace

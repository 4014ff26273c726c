// SPDX-License-Identifier: MIT

#include "validation/bench/work_precision.hpp"

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::bench;
using namespace palpate;

constexpr Signal first_coordinate{.first = 0, .count = 1};

/// Two coordinates at three ticks; the first is the tool.
Trace run_of(double error) {
  Trace run;
  run.position.resize(2, 3);
  run.position << 0.0, 1.0, 2.0, 5.0, 5.0, 1.0;
  run.position(0, 1) += error;
  run.columns = {{"energy_j", "J", {1.0, 1.0, 9.0 + 8.0 * error}}};
  return run;
}

Point point(Point::Kind kind, double seconds, double median, double error) {
  return {.kind = kind, .seconds = seconds, .median = median, .errors = {.tool = error}};
}

TEST("errors are relative to the range of the truth, not to its first or last value") {
  const Truth truth = truth_of(run_of(0.0), run_of(1e-6), first_coordinate);
  CHECK_NEAR(truth.peak, 2.0, 1e-15);
  CHECK_NEAR(truth.travel, 4.0, 1e-15);
  CHECK_NEAR(truth.energy, 8.0, 1e-15);
  CHECK_NEAR(truth.floor, 5e-7, 1e-15);
  const Errors errors = errors_of(run_of(0.1), truth);
  CHECK_NEAR(errors.tool, 0.05, 1e-15);
  CHECK_NEAR(errors.tool_mean, 0.05 / std::sqrt(3.0), 1e-15);
  CHECK_NEAR(errors.trajectory, 0.025, 1e-15);
  CHECK_NEAR(errors.trajectory_mean, 0.025 / std::sqrt(6.0), 1e-15);
  CHECK_NEAR(errors.energy, 0.1, 1e-14);
  CHECK(errors.tool_at_end == 0.0);
}

TEST("a tick where the tool's signal jumps is left out there and counts elsewhere") {
  const Truth truth = truth_of(run_of(0.0), run_of(0.0), first_coordinate, {false, true, false});
  const Errors errors = errors_of(run_of(0.1), truth);
  CHECK(errors.tool == 0.0);
  CHECK(errors.trajectory > 0.0);
}

TEST("a run that failed, is short or is not finite has infinite errors") {
  const Truth truth = truth_of(run_of(0.0), run_of(0.0), first_coordinate);
  Trace failed = run_of(0.0);
  failed.diverged = true;
  CHECK(std::isinf(errors_of(failed, truth).tool));
  CHECK(std::isinf(errors_of(run_of(std::nan("")), truth).trajectory));
  Trace cut = run_of(0.0);
  cut.position.conservativeResize(2, 2);
  CHECK(std::isinf(errors_of(cut, truth).tool));
}

TEST("a point is on the frontier if no point of its precision is better in both") {
  using enum Point::Kind;
  const std::vector<Point> points{
      point(in_double, 1.0, 1.0, 1e-2), point(in_double, 2.0, 2.0, 1e-3),
      point(in_double, 3.0, 3.0, 2e-3), point(in_float, 0.5, 0.5, 1e-5)};
  CHECK(on_frontier(points, points[0]));
  CHECK(on_frontier(points, points[1]));
  CHECK(on_frontier(points, points[3]));
  CHECK(!on_frontier(points, points[2]));
}

TEST("libraries are compared with what solves their problem: in double, with every node") {
  using enum Point::Kind;
  std::vector<Point> points{point(in_double, 3.0, 3.0, 1e-3), point(in_float, 1.0, 1.0, 1e-5),
                            point(in_double, 2.0, 2.0, 1e-3)};
  points.back().far_field = true;
  CHECK(cheapest(points, 1e-3, Among::here) == &points[1]);
  CHECK(cheapest(points, 1e-3, Among::here_as_libraries) == &points.front());
  CHECK(cheapest(points, 1e-6, Among::here) == nullptr);
  CHECK(cheapest(points, 1.0, Among::libraries) == nullptr);
  points.push_back(point(elsewhere, 4.0, 4.0, 1e-4));
  CHECK(cheapest(points, 1.0, Among::libraries) == &points.back());
}

TEST("an automatic choice off the frontier is detected, and noise is not") {
  using enum Point::Kind;
  const Point better = point(in_double, 1.0, 1.05, 1e-3);
  CHECK_NEAR(automatic_over_best({better, point(automatic, 2.1, 2.2, 2e-3)}), 2.0, 1e-12);
  CHECK(automatic_over_best({better, point(automatic, 1.03, 1.1, 2e-3)}) < 1.0);
  CHECK(automatic_over_best({better, point(automatic, 2.1, 2.2, 5e-4)}) == 0.0);  // nearer than any
  CHECK(std::isnan(automatic_over_best({better})));                               // it did not run
}

TEST("noise is the ratio of nine in ten settings of this machine, at least a tenth") {
  using enum Point::Kind;
  std::vector<Point> points(10, point(in_double, 1.0, 1.02, 1e-3));
  CHECK_NEAR(noise_of(points), 1.1, 1e-15);
  points[3].median = 1.3;
  CHECK_NEAR(noise_of(points), 1.3, 1e-15);
  points.insert(points.end(), 10, point(elsewhere, 1.0, 9.0, 1e-3));
  CHECK_NEAR(noise_of(points), 1.3, 1e-15);
}

/// Scheme of a given order: error = scale / cost^order.
void add_scheme(std::vector<Point>& points, const char* name, double scale, double order) {
  for (double cost = 100.0; cost <= 6400.0; cost *= 2.0) {
    points.push_back({.method = name,
                      .evaluations = std::lround(cost),
                      .errors = {.tool = scale / std::pow(cost, order)}});
  }
}

std::vector<Point> scheme(const char* name, double scale, double order) {
  std::vector<Point> points;
  add_scheme(points, name, scale, order);
  return points;
}

TEST("cost and digits follow the law of a scheme within its points, and exist only there") {
  const std::vector<Point> points = scheme("second", 1e2, 2.0);
  // On a straight line interpolation is exact.
  CHECK_NEAR(cost_at(points, 1e-3) / std::sqrt(1e5), 1.0, 1e-12);
  CHECK_NEAR(digits_at(points, 3000.0), 2.0 * std::log10(3000.0) - 2.0, 1e-12);
  // Nothing is cheaper than what was measured.
  CHECK_NEAR(cost_at(points, 0.5), 100.0, 1e-9);
  CHECK_NEAR(digits_at(points, 1e9), -std::log10(1e2 / (6400.0 * 6400.0)), 1e-12);
  CHECK(std::isnan(cost_at(points, 1e-9)));
  CHECK(std::isnan(digits_at(points, 99.0)));
  CHECK(std::isnan(cost_at({}, 1e-3)));
  CHECK(std::isnan(digits_at({}, 1e3)));
}

TEST("the cheaper scheme counts: low order for a coarse error, high order for a fine one") {
  std::vector<Point> points = scheme("first", 10.0, 1.0);
  add_scheme(points, "fourth", 1e9, 4.0);
  CHECK_NEAR(cost_at(points, 0.05), 200.0, 1e-9);
  CHECK_NEAR(cost_at(points, 1e-5) / std::pow(1e14, 0.25), 1.0, 1e-12);
}

TEST("a scheme that lost an order costs more at a fine error, and has fewer digits") {
  const std::vector<Point> good = scheme("x", 1.0, 2.0);
  const std::vector<Point> damaged = scheme("x", 1.0 / 100.0, 1.0);  // equal at the first
  CHECK(cost_at(damaged, 1e-5) > 1.5 * cost_at(good, 1e-5));
  CHECK(digits_at(damaged, 1600.0) < digits_at(good, 1600.0) - 1.0);
}

}  // namespace PALPATE_FILE

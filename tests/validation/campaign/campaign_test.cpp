// SPDX-License-Identifier: MIT

#include <cmath>
#include <numbers>
#include <set>

#include "model/problem/input_error.hpp"
#include "tests/check.hpp"
#include "validation/campaign/findings.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::campaign;

Parameter range_of(std::string key, double low, double high, Scale scale = Scale::linear) {
  return {.key = std::move(key), .range = {low, high}, .scale = scale};
}

TEST("shards contain every item once, and their text is read back") {
  for (const std::size_t count : {1U, 3U, 7U}) {
    for (std::size_t item = 0; item < 50; ++item) {
      std::size_t found = 0;
      for (std::size_t index = 1; index <= count; ++index) {
        const Shard shard = parse_shard(Shard{index, count}.text(), "test");
        found += shard.has(item) ? 1 : 0;
      }
      CHECK(found == 1);
    }
  }
}

TEST("a text that is no shard is refused") {
  for (const char* text : {"", "1", "0/3", "4/3", "1/", "/3", "1/3x", "-1/3", "1/99999999999999"}) {
    bool refused = false;
    try {
      (void)parse_shard(text, "--shard");
    } catch (const InputError&) { refused = true; }
    CHECK(refused);
  }
}

TEST("an array expression joins neighbours") {
  CHECK(array_expression(std::vector<std::size_t>{}).empty());
  CHECK(array_expression(std::vector<std::size_t>{3, 17, 18, 19, 20}) == "3,17-20");
  CHECK(array_expression(std::vector<std::size_t>{1, 2, 4}) == "1-2,4");
}

TEST("a grid is the product of its values, the last parameter fastest") {
  Parameter ends = range_of("b", 1.0, 100.0, Scale::log);
  ends.count = 3;
  const auto rows = rows_of({.parameters = {{.key = "a", .values = {5.0, 6.0}}, ends}});
  REQUIRE(rows.size() == 6);
  CHECK(rows[1][0] == 5.0);
  CHECK_NEAR(rows[1][1], 10.0, 1e-14);  // rounding of pow
  CHECK(rows[5][0] == 6.0);
}

TEST("a Latin hypercube has one value in every interval of every parameter") {
  const Design design{.method = Method::latin_hypercube,
                      .samples = 20,
                      .seed = 4,
                      .parameters = {range_of("a", 0.0, 1.0), range_of("b", 2.0, 4.0)}};
  const auto rows = rows_of(design);
  REQUIRE(rows.size() == row_count(design));
  std::set<int> first;
  std::set<int> second;
  for (const auto& row : rows) {
    first.insert(static_cast<int>(20.0 * row[0]));
    second.insert(static_cast<int>(10.0 * (row[1] - 2.0)));
  }
  CHECK(first.size() == 20);
  CHECK(second.size() == 20);
}

TEST("Sobol points fill every quarter of an interval alike") {
  const Design design{
      .method = Method::sobol, .samples = 63, .parameters = {range_of("a", 0.0, 1.0)}};
  int low = 0;
  for (const auto& row : rows_of(design)) { low += row[0] < 0.25 ? 1 : 0; }
  CHECK(low >= 15);  // 16 of the 64 points that begin with 0, which GSL leaves out
  CHECK(low <= 16);
}

/// Ishigami's function with a = 7, b = 0.1, whose indices are known in closed form.
double ishigami(const std::vector<double>& x) {
  return std::sin(x[0]) + 7.0 * std::pow(std::sin(x[1]), 2) +
         0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}

TEST("indices of Ishigami's function agree with their closed form") {
  constexpr double pi = std::numbers::pi;
  const Design design{
      .method = Method::saltelli,
      .samples = 4096,
      .parameters = {range_of("a", -pi, pi), range_of("b", -pi, pi), range_of("c", -pi, pi)}};
  std::vector<double> values;
  for (const auto& row : rows_of(design)) { values.push_back(ishigami(row)); }
  const auto found = sensitivity_of(values, 3, {.draws = 100});
  REQUIRE(found.size() == 3);
  const double a = 0.5 * std::pow(1.0 + 0.1 * std::pow(pi, 4) / 5.0, 2);
  const double b = 49.0 / 8.0;
  const double c = 0.01 * std::pow(pi, 8) * (1.0 / 18.0 - 1.0 / 50.0);
  const double all = a + b + c;
  constexpr double enough =
      0.02;  // 1/sqrt(4096) is 0.016 for random points; Sobol points do better
  CHECK_NEAR(found[0].first, a / all, enough);
  CHECK_NEAR(found[1].first, b / all, enough);
  CHECK_NEAR(found[2].first, 0.0, enough);
  CHECK_NEAR(found[0].total, (a + c) / all, enough);
  CHECK_NEAR(found[1].total, b / all, enough);
  CHECK_NEAR(found[2].total, c / all, enough);
  CHECK(found[0].first_interval.holds(a / all));
  CHECK(found[2].total_interval.holds(c / all));
}

TEST("a base sample with a missing value is left out, and constant values have no indices") {
  const Design design{.method = Method::saltelli,
                      .samples = 64,
                      .parameters = {range_of("a", 0.0, 1.0), range_of("b", 0.0, 1.0)}};
  std::vector<double> values;
  for (const auto& row : rows_of(design)) { values.push_back(row[0]); }
  values[7] = std::nan("");
  const auto found = sensitivity_of(values, 2, {.draws = 10});
  REQUIRE(found.size() == 2);
  CHECK(found[0].samples == 63);
  CHECK(found[1].total == 0.0);
  CHECK(sensitivity_of(std::vector<double>(64 * 4, 1.0), 2).empty());
}

JobResult job(std::string id, long nodes, std::string status, std::string cause, double value) {
  return {.id = std::move(id),
          .group = "scene",
          .nodes = nodes,
          .status = std::move(status),
          .cause = std::move(cause),
          .quantities = {{"force", value}}};
}

TEST("failures are grouped by cause with the job of the fewest nodes") {
  const std::vector<JobResult> results{job("a", 900, "error", "no answer", 1.0),
                                       job("b", 30, "error", "no answer", 1.0),
                                       job("c", 10, "ok", "", 1.0), job("d", 50, "ok", "", 9.0)};
  const Campaign of{.claims = {{.quantity = "force", .upper = 2.0, .bound_from = "test"}}};
  const auto outcomes = outcomes_of(of, results);
  const Outcome& jobs = outcomes.front();
  CHECK(jobs.status == Status::fail);
  REQUIRE(jobs.tables.size() == 1);
  REQUIRE(jobs.tables[0].rows.size() == 2);
  CHECK(std::get<std::string>(jobs.tables[0].rows[0][0]) == "error: no answer");
  CHECK(std::get<double>(jobs.tables[0].rows[0][1]) == 2.0);
  CHECK(std::get<std::string>(jobs.tables[0].rows[0][4]) == "b");
  CHECK(std::get<std::string>(jobs.tables[0].rows[1][4]) == "d");
  CHECK(outcomes[1].status == Status::fail);
}

TEST("a claim on a quantity that a job lacks fails") {
  std::vector<JobResult> results{job("a", 1, "ok", "", 1.0), job("b", 1, "ok", "", 1.5)};
  const Campaign of{.claims = {{.quantity = "force", .upper = 2.0, .bound_from = "test"}}};
  CHECK(outcomes_of(of, results)[1].status == Status::pass);
  results[1].quantities.clear();
  CHECK(outcomes_of(of, results)[1].status == Status::fail);
  results[1].quantities["force"] = std::nan("");
  CHECK(outcomes_of(of, results)[1].status == Status::fail);
}

TEST("time is judged only if every node was qualified for it") {
  std::vector<JobResult> results{job("a", 1, "ok", "", 1.0), job("b", 1, "ok", "", 1.5)};
  const auto timing = [&results] {
    for (const Outcome& outcome : outcomes_of({}, results)) {
      if (outcome.name == "campaign/timing") { return outcome.status; }
    }
    return Status::error;
  };
  CHECK(timing() == Status::error);  // no claim on time, no outcome
  results[0].timing = "pass";
  results[1].timing = "not judged";
  CHECK(timing() == Status::skip);
  results[1].timing = "pass";
  CHECK(timing() == Status::pass);
  results[1].timing = "fail";
  CHECK(timing() == Status::fail);
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
#include "validation/bench/frontier.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace palpate::bench {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// In the plane of logarithms.
struct Place {
  double cost = 0.0;
  double error = 0.0;
};

/// Each method's points by rising cost.
std::vector<std::vector<Place>> ladders_of(std::span<const Effort> efforts) {
  std::map<std::string, std::vector<Place>> by_method;
  for (const Effort& each : efforts) {
    by_method[each.method].push_back({std::log10(each.cost), std::log10(each.error)});
  }
  std::vector<std::vector<Place>> ladders;
  for (auto& [method, ladder] : by_method) {
    std::ranges::sort(ladder, {}, &Place::cost);
    ladders.push_back(std::move(ladder));
  }
  return ladders;
}

double between(double at, double from, double to, double value_from, double value_to) {
  return value_from + (value_to - value_from) * (at - from) / (to - from);
}

double cost_on(const std::vector<Place>& ladder, double error) {
  if (ladder.front().error <= error) { return ladder.front().cost; }
  for (std::size_t n = 1; n < ladder.size(); ++n) {
    const Place& a = ladder[n - 1];
    const Place& b = ladder[n];
    if (b.error <= error) { return between(error, a.error, b.error, a.cost, b.cost); }
  }
  return nothing;
}

double error_on(const std::vector<Place>& ladder, double cost) {
  if (cost < ladder.front().cost) { return nothing; }
  for (std::size_t n = 1; n < ladder.size(); ++n) {
    const Place& a = ladder[n - 1];
    const Place& b = ladder[n];
    if (b.cost >= cost) { return between(cost, a.cost, b.cost, a.error, b.error); }
  }
  return ladder.back().error;
}

/// Least over the ladders, those that have none left out.
template <class Value>
double least(std::span<const Effort> efforts, double at, Value&& value) {
  double best = nothing;
  for (const std::vector<Place>& ladder : ladders_of(efforts)) {
    best = std::fmin(best, value(ladder, std::log10(at)));
  }
  return best;
}

}  // namespace

double cost_at(std::span<const Effort> efforts, double error) {
  return std::pow(10.0, least(efforts, error, cost_on));
}

double digits_at(std::span<const Effort> efforts, double cost) { return -least(efforts, cost, error_on); }

}  // namespace palpate::bench

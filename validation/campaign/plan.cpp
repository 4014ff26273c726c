// SPDX-License-Identifier: MIT

#include "validation/campaign/plan.hpp"

#include <charconv>
#include <cmath>
#include <gsl/gsl_qrng.h>
#include <limits>
#include <memory>

#include "model/problem/input_error.hpp"
#include "validation/random.hpp"

namespace palpate::campaign {

Shard parse_shard(std::string_view text, std::string_view from) {
  Shard shard;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, shard.index);
  const bool slash = first.ec == std::errc{} && first.ptr != end && *first.ptr == '/';
  const auto second =
      slash ? std::from_chars(first.ptr + 1, end, shard.count) : std::from_chars_result{end, {}};
  const bool whole = slash && second.ec == std::errc{} && second.ptr == end;
  constexpr std::size_t most = 1'000'000;
  if (whole && shard.index >= 1 && shard.index <= shard.count && shard.count <= most) {
    return shard;
  }
  throw InputError(std::string(from) + " " + std::string(text) +
                   ": not a shard; i/N with i from 1 to N, such as 2/3");
}

std::string array_expression(std::span<const std::size_t> numbers) {
  std::string text;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    std::size_t last = n;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) { ++last; }
    text += (text.empty() ? "" : ",") + std::to_string(numbers[n]);
    if (last > n) { text += "-" + std::to_string(numbers[last]); }
    n = last;
  }
  return text;
}

double Parameter::at(double share) const {
  const double low = range.at(0);
  const double high = range.at(1);
  if (scale == Scale::linear) { return low + (high - low) * share; }
  return low * std::pow(high / low, share);
}

namespace {

std::vector<double> grid_values(const Parameter& parameter) {
  if (!parameter.values.empty()) { return parameter.values; }
  std::vector<double> values;
  for (int n = 0; n < parameter.count; ++n) {
    values.push_back(parameter.at(static_cast<double>(n) / (parameter.count - 1)));
  }
  return values;
}

/// Returns the product of the values. The last parameter varies fastest.
std::vector<std::vector<double>> grid(const std::vector<Parameter>& parameters) {
  std::vector<std::vector<double>> rows{{}};
  for (const Parameter& parameter : parameters) {
    std::vector<std::vector<double>> longer;
    for (const std::vector<double>& row : rows) {
      for (const double value : grid_values(parameter)) {
        longer.push_back(row);
        longer.back().push_back(value);
      }
    }
    rows = std::move(longer);
  }
  return rows;
}

std::vector<std::vector<double>> latin_hypercube(const Design& design) {
  Random random(design.seed);
  const auto count = static_cast<std::size_t>(design.samples);
  std::vector<std::vector<double>> rows(count);
  for (const Parameter& parameter : design.parameters) {
    std::vector<double> shares;
    for (std::size_t n = 0; n < count; ++n) {
      shares.push_back((static_cast<double>(n) + random(0.0, 1.0)) / static_cast<double>(count));
    }
    random.shuffle(shares);
    for (std::size_t n = 0; n < count; ++n) { rows[n].push_back(parameter.at(shares[n])); }
  }
  return rows;
}

/// Returns the first points of the Sobol sequence in the unit cube.
std::vector<std::vector<double>> sobol_points(std::size_t count, std::size_t dimensions) {
  const std::unique_ptr<gsl_qrng, decltype(&gsl_qrng_free)> generator(
      gsl_qrng_alloc(gsl_qrng_sobol, static_cast<unsigned>(dimensions)), gsl_qrng_free);
  std::vector<std::vector<double>> points(count, std::vector<double>(dimensions));
  for (std::vector<double>& point : points) { gsl_qrng_get(generator.get(), point.data()); }
  return points;
}

std::vector<std::vector<double>> sobol(const Design& design) {
  std::vector<std::vector<double>> rows =
      sobol_points(static_cast<std::size_t>(design.samples), design.parameters.size());
  for (std::vector<double>& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) { row[k] = design.parameters[k].at(row[k]); }
  }
  return rows;
}

std::vector<std::vector<double>> saltelli(const Design& design) {
  const std::size_t k = design.parameters.size();
  std::vector<std::vector<double>> rows;
  for (const auto& point : sobol_points(static_cast<std::size_t>(design.samples), 2 * k)) {
    std::vector<double> a(k);
    std::vector<double> b(k);
    for (std::size_t n = 0; n < k; ++n) {
      a[n] = design.parameters[n].at(point[n]);
      b[n] = design.parameters[n].at(point[k + n]);
    }
    rows.push_back(a);
    rows.push_back(b);
    for (std::size_t n = 0; n < k; ++n) {
      rows.push_back(a);
      rows.back()[n] = b[n];
    }
  }
  return rows;
}

}  // namespace

std::size_t row_count(const Design& design) {
  const auto samples = static_cast<std::size_t>(design.samples);
  if (design.method == Method::saltelli) { return samples * (design.parameters.size() + 2); }
  if (design.method != Method::grid) { return samples; }
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  std::size_t count = 1;
  for (const Parameter& parameter : design.parameters) {
    const std::size_t values = parameter.values.empty() ? static_cast<std::size_t>(parameter.count)
                                                        : parameter.values.size();
    count = values > 0 && count > most / values ? most : count * values;
  }
  return count;
}

std::vector<std::vector<double>> rows_of(const Design& design) {
  switch (design.method) {
    case Method::grid: return grid(design.parameters);
    case Method::latin_hypercube: return latin_hypercube(design);
    case Method::sobol: return sobol(design);
    case Method::saltelli: return saltelli(design);
  }
  return {};
}

}  // namespace palpate::campaign

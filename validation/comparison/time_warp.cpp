// SPDX-License-Identifier: MIT
#include "validation/comparison/time_warp.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace palpate::comparison {

namespace {

enum class From : std::uint8_t { first_before, second_before, both_before };

/// Column c of row i stands for sample j = i + c - (radius - 1) of the second trace.
struct Band {
  std::size_t length = 0;
  std::size_t radius = 1;
  std::vector<From> from{};

  [[nodiscard]] std::size_t width() const { return 2 * radius - 1; }
  [[nodiscard]] std::size_t column(std::size_t i, std::size_t j) const { return j + radius - 1 - i; }
  [[nodiscard]] From& at(std::size_t i, std::size_t j) { return from[i * width() + column(i, j)]; }
};

/// One row of least sums; `above` is the row before, one column further right for the same j.
void add_row(std::span<const double> first, std::span<const double> second, std::size_t i, Band& band,
             const std::vector<double>& above, std::vector<double>& row) {
  constexpr double none = std::numeric_limits<double>::infinity();
  std::ranges::fill(row, none);
  const std::size_t begin = i >= band.radius - 1 ? i - (band.radius - 1) : 0;
  const std::size_t end = std::min(band.length, i + band.radius);
  double left = none;
  for (std::size_t j = begin; j < end; ++j) {
    const std::size_t c = band.column(i, j);
    const double d = first[i] - second[j];
    double least = i > 0 ? above[c + 1] : none;
    From from = From::first_before;
    if (left < least) { least = left, from = From::second_before; }
    const double diagonal = i > 0 && j > 0 ? above[c] : none;
    if (diagonal < least) { least = diagonal, from = From::both_before; }
    left = (i == 0 && j == 0 ? 0.0 : least) + d * d;
    row[c] = left;
    band.at(i, j) = from;
  }
}

}  // namespace

WarpSums warp(std::span<const double> first, std::span<const double> second, std::size_t radius) {
  const std::size_t length = std::min(first.size(), second.size());
  if (length == 0) { return {}; }
  Band band{.length = length, .radius = std::clamp<std::size_t>(radius, 1, length)};
  band.from.resize(length * band.width());
  std::vector<double> above(band.width() + 1, std::numeric_limits<double>::infinity());
  std::vector<double> row = above;
  for (std::size_t i = 0; i < length; ++i) {
    add_row(first, second, i, band, above, row);
    std::swap(above, row);
  }
  WarpSums sums;
  std::size_t i = length - 1;
  std::size_t j = length - 1;
  while (true) {
    sums.difference += std::abs(first[i] - second[j]);
    sums.second += std::abs(second[j]);
    ++sums.length;
    if (i == 0 && j == 0) { return sums; }
    const From from = band.at(i, j);
    if (from != From::second_before) { --i; }
    if (from != From::first_before) { --j; }
  }
}

}  // namespace palpate::comparison

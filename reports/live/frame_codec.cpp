// SPDX-License-Identifier: MIT

#include "reports/live/frame_codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace palpate::live {

namespace {

constexpr double most = 32767.0;
constexpr std::uint64_t odd = 0x9E3779B97F4A7C15U;  // 2^64 / golden ratio

void append_number(std::uint32_t value, std::string& bytes) {
  while (value >= 0x80U) {
    bytes += static_cast<char>(value | 0x80U);
    value >>= 7U;
  }
  bytes += static_cast<char>(value);
}

/// Reads a number of at most 5 bytes at `place`. Returns false at the end of the bytes.
bool take_number(std::string_view bytes, std::size_t& place, std::uint32_t& value) {
  value = 0;
  for (unsigned shift = 0; shift < 35 && place < bytes.size(); shift += 7) {
    const auto byte = static_cast<std::uint8_t>(bytes[place++]);
    value |= (byte & 0x7FU) << shift;
    if (byte < 0x80U) { return true; }
  }
  return false;
}

}  // namespace

/// Each step is a bijection of the sum for a given value, and of the value for a given sum.
std::uint64_t checksum(std::span<const double> values, std::uint64_t begin) noexcept {
  std::uint64_t sum = begin;
  for (const double value : values) {
    sum = (std::rotl(sum, 23) ^ std::bit_cast<std::uint64_t>(value)) * odd;
  }
  return sum;
}

Quantiser::Quantiser(std::vector<int> nodes, const NodeVectors& rest, double range)
    : nodes_(std::move(nodes)), rest_(rest(Eigen::all, nodes_)), step_(range / most) {}

void Quantiser::quantise(const NodeVectors& position, std::vector<std::int16_t>& values) const {
  values.resize(size());
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double moved =
          (position(axis, nodes_[n]) - rest_(axis, static_cast<Eigen::Index>(n))) / step_;
      const double shown = std::isnan(moved) ? 0.0 : std::clamp(moved, -most, most);
      values[3 * n + static_cast<std::size_t>(axis)] =
          static_cast<std::int16_t>(std::lround(shown));
    }
  }
}

void append_changes(std::span<const std::int16_t> values, std::span<const std::int16_t> before,
                    std::string& bytes) {
  std::uint32_t zeros = 0;
  const auto end_zeros = [&] {
    if (zeros == 0) { return; }
    bytes += '\0';
    append_number(zeros - 1, bytes);
    zeros = 0;
  };
  for (std::size_t n = 0; n < values.size(); ++n) {
    const int change = values[n] - (before.empty() ? 0 : before[n]);
    if (change == 0) {
      ++zeros;
      continue;
    }
    end_zeros();
    append_number(change > 0 ? 2U * static_cast<std::uint32_t>(change)
                             : 2U * static_cast<std::uint32_t>(-change) + 1U,
                  bytes);
  }
  end_zeros();
}

bool add_changes(std::string_view bytes, std::span<std::int16_t> values) {
  std::size_t place = 0;
  std::size_t n = 0;
  while (place < bytes.size()) {
    std::uint32_t number = 0;
    if (!take_number(bytes, place, number)) { return false; }
    if (number == 0) {
      std::uint32_t further = 0;
      if (!take_number(bytes, place, further) || further >= values.size() - n) { return false; }
      n += further + 1;
      continue;
    }
    if (n >= values.size()) { return false; }
    const auto size = static_cast<std::int32_t>(number >> 1U);
    values[n] = static_cast<std::int16_t>(values[n] + ((number & 1U) == 0 ? size : -size));
    ++n;
  }
  return n == values.size();
}

}  // namespace palpate::live

// SPDX-License-Identifier: MIT
#pragma once
/// Frames of a live run on their way to a page: quantised displacements, their differences as
/// bytes, and the checksum of a snapshot.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate::live {

/// Checksum of numbers: any change of one bit changes it.
std::uint64_t checksum(std::span<const double> values, std::uint64_t begin = 0) noexcept;

/// Displacements of selected nodes as multiples of a step.
class Quantiser {
 public:
  /// `nodes` are the selected nodes of a network with undeformed positions `rest`; a displacement
  /// of `range` [m] or more is shown as `range`.
  Quantiser(std::vector<int> nodes, const NodeVectors& rest, double range);

  [[nodiscard]] double step() const { return step_; }  ///< [m]
  [[nodiscard]] std::size_t size() const { return 3 * nodes_.size(); }
  /// Writes three values for each selected node. A coordinate that is not a number becomes 0.
  void quantise(const NodeVectors& position, std::vector<std::int16_t>& values) const;

 private:
  std::vector<int> nodes_;
  NodeVectors rest_;
  double step_;
};

/// Appends the differences of values and earlier values: each as a variable-length integer of 7
/// bits a byte, sign in the lowest bit; 0 is followed by the number of further zeros. `before` is
/// empty for a keyframe, which is a difference from zeros.
void append_changes(std::span<const std::int16_t> values, std::span<const std::int16_t> before,
                    std::string& bytes);

/// Adds such differences to `values`. Returns false if the bytes do not contain exactly as many.
bool add_changes(std::string_view bytes, std::span<std::int16_t> values);

}  // namespace palpate::live

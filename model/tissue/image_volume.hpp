// SPDX-License-Identifier: MIT
#pragma once
/// Stack of image slices in memory, independent of the file format.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/tissue/grid.hpp"

namespace palpate {

/// Image whose pixels are stored along x (a row of a slice), then y (down its columns), then z
/// (slice by slice).
struct ImageVolume {
  std::string format{};  ///< "DICOM series", "NIfTI", "PNG slices"
  std::array<int, 3> count{0, 0, 0};
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< between pixel centres [m]
  std::vector<float> value{};              ///< in units of the scanner; larger is brighter
  /// Directions of x, y and z as columns in the patient frame: x to the left, y to the back, z to
  /// the head (LPS). Empty if the file does not specify it.
  std::optional<Eigen::Matrix3d> orientation{};
  Eigen::Vector3d origin{0.0, 0.0,
                         0.0};  ///< centre of the first pixel in that frame [m]; 0 without it

  [[nodiscard]] std::size_t index(int i, int j, int l) const { return grid_index(count, i, j, l); }
  [[nodiscard]] float at(int i, int j, int l) const { return value[index(i, j, l)]; }
};

}  // namespace palpate

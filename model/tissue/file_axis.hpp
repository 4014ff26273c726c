// SPDX-License-Identifier: MIT
#pragma once
/// Mapping from the axes of a mesh or image file to the tissue frame.

#include <Eigen/Core>
#include <array>

namespace palpate {

/// Direction of a file that points into the tissue. For a mesh, x, y and z are its own axes. For an
/// image, x runs along the rows, y down the columns and z across the slices. The anatomical
/// directions are for images with a known patient orientation.
enum class FileAxis {
  x_plus,
  x_minus,
  y_plus,
  y_minus,
  z_plus,
  z_minus,
  left,
  right,
  anterior,
  posterior,
  superior,
  inferior
};

/// Signed permutation of axes: axis n of the tissue is sign[n] times axis from[n] of the file.
struct AxisMap {
  std::array<int, 3> from{0, 1, 2};
  std::array<int, 3> sign{1, 1, 1};

  [[nodiscard]] Eigen::Matrix3d matrix() const {  ///< tissue = matrix * file
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    for (int n = 0; n < 3; ++n) {
      const auto at = static_cast<std::size_t>(n);
      m(n, from[at]) = sign[at];
    }
    return m;
  }
};

/// Returns the right-handed map whose z is the file direction `inward`, one of the first six. For
/// z, x and y keep their axes. Otherwise x and y take the axes that follow in the cycle x, y, z; x
/// is reversed if z points backwards.
inline AxisMap axis_map(FileAxis inward) {
  const int axis = static_cast<int>(inward) / 2;
  const int sign = static_cast<int>(inward) % 2 == 0 ? 1 : -1;
  return {{(axis + 1) % 3, (axis + 2) % 3, axis}, {sign, 1, sign}};
}

}  // namespace palpate

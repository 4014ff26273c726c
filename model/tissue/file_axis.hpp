// SPDX-License-Identifier: MIT
#pragma once
/// Which way a file's axes lie in the tissue frame: meshes and images come in frames of their own.

#include <Eigen/Core>
#include <array>

namespace palpate {

/// The direction of a file that points into the tissue. x, y and z are a mesh's own axes; of an
/// image x runs along its rows, y down its columns and z across its slices. The others are for
/// images that know how the patient lay.
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

/// A signed permutation: axis n of the tissue is sign[n] times axis from[n] of the file.
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

/// The right-handed map whose z is the file's `inward` (one of the first six). z keeps x and y; x
/// and y take the axes that follow in the circle x, y, z, and x turns round where z points
/// backwards.
inline AxisMap axis_map(FileAxis inward) {
  const int axis = static_cast<int>(inward) / 2;
  const int sign = static_cast<int>(inward) % 2 == 0 ? 1 : -1;
  return {{(axis + 1) % 3, (axis + 2) % 3, axis}, {sign, 1, sign}};
}

}  // namespace palpate

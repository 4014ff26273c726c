// SPDX-License-Identifier: MIT
#include "model/dynamics/voxelise.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A place across the rows, in units of a cell's 2^-n; products of two differences fit 64 bits.
struct Across {
  std::int64_t y = 0;
  std::int64_t z = 0;
};

std::int64_t turn(const Across& a, const Across& b, const Across& c) {
  return (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
}

/// Points on an edge belong to one of the two faces beside it: to the one that goes along it this way.
bool takes_edge(const Across& from, const Across& to) { return to.z > from.z || (to.z == from.z && to.y < from.y); }

struct Crossing {
  std::size_t row = 0;
  double x = 0.0;  ///< [m]
  int winding = 0;
};

class Scan {
 public:
  Scan(const TriangleSurface& surface, const BoxGrid& grid) : surface_(surface), grid_(grid) {
    constexpr int most_bits = 29;
    const int cells = std::max(grid.count[1], grid.count[2]);
    for (int bits = most_bits; (std::int64_t{cells} << shift_) < (std::int64_t{1} << (bits - 1)); ++shift_) {}
    across_.reserve(static_cast<std::size_t>(surface.vertex.cols()));
    for (Eigen::Index i = 0; i < surface.vertex.cols(); ++i) {
      const Vector3d cell = (surface.vertex.col(i) - grid.low).cwiseQuotient(grid.size);
      across_.push_back({std::llround(std::ldexp(cell.y(), shift_)), std::llround(std::ldexp(cell.z(), shift_))});
    }
  }

  std::vector<std::uint8_t> run() {
    for (int f = 0; f < static_cast<int>(surface_.triangle.size()); ++f) { add_face(f); }
    std::ranges::sort(crossings_, {}, [](const Crossing& c) { return std::pair(c.row, c.x); });
    std::vector<std::uint8_t> inside(grid_.box_count(), 0);
    for (std::span<const Crossing> left(crossings_); !left.empty();) {
      const auto other = std::ranges::find_if(left, [&](const Crossing& c) { return c.row != left.front().row; });
      const auto count = static_cast<std::size_t>(other - left.begin());
      fill_row(left.first(count), inside);
      left = left.subspan(count);
    }
    return inside;
  }

 private:
  /// First cell of a row of cells whose centre is at `place` or after it.
  [[nodiscard]] int first_centre(std::int64_t place) const {
    const std::int64_t half = std::int64_t{1} << (shift_ - 1);
    return static_cast<int>((place + half - 1) >> shift_);
  }
  [[nodiscard]] Across centre(int j, int l) const {
    const std::int64_t half = std::int64_t{1} << (shift_ - 1);
    return {(std::int64_t{j} << shift_) + half, (std::int64_t{l} << shift_) + half};
  }

  void add_face(int face) {
    const auto& t = surface_.triangle[static_cast<std::size_t>(face)];
    std::array<int, 3> v = t;
    const auto at = [&](int n) { return across_[static_cast<std::size_t>(v[static_cast<std::size_t>(n)])]; };
    const std::int64_t area = turn(at(0), at(1), at(2));
    if (area == 0) { return; }  // seen from its edge, which its neighbours answer for
    if (area < 0) { std::swap(v[1], v[2]); }
    const auto [y_low, y_high] = std::minmax({at(0).y, at(1).y, at(2).y});
    const auto [z_low, z_high] = std::minmax({at(0).z, at(1).z, at(2).z});
    const int j_end = std::min(first_centre(y_high + 1), grid_.count[1]);
    const int l_end = std::min(first_centre(z_high + 1), grid_.count[2]);
    for (int l = std::max(first_centre(z_low), 0); l < l_end; ++l) {
      for (int j = std::max(first_centre(y_low), 0); j < j_end; ++j) { add_crossing(v, j, l, area > 0 ? -1 : 1); }
    }
  }

  void add_crossing(const std::array<int, 3>& v, int j, int l, int winding) {
    const Across p = centre(j, l);
    double x = 0.0;
    double total = 0.0;
    for (std::size_t n = 0; n < 3; ++n) {
      const Across& a = across_[static_cast<std::size_t>(v[(n + 1) % 3])];
      const Across& b = across_[static_cast<std::size_t>(v[(n + 2) % 3])];
      const std::int64_t side = turn(a, b, p);
      if (side < 0 || (side == 0 && !takes_edge(a, b))) { return; }
      x += static_cast<double>(side) * surface_.vertex(0, v[n]);
      total += static_cast<double>(side);
    }
    const auto row =
        static_cast<std::size_t>(l) * static_cast<std::size_t>(grid_.count[1]) + static_cast<std::size_t>(j);
    crossings_.push_back({row, x / total, winding});
  }

  void fill_row(std::span<const Crossing> row, std::vector<std::uint8_t>& inside) const {
    const std::size_t first = row.front().row * static_cast<std::size_t>(grid_.count[0]);
    int winding = 0;
    int i_begin = 0;
    for (const Crossing& crossing : row) {
      const int i_end = std::clamp(cell_after(crossing.x), 0, grid_.count[0]);
      for (int i = i_begin; winding > 0 && i < i_end; ++i) { inside[first + static_cast<std::size_t>(i)] = 1; }
      winding += crossing.winding;
      i_begin = i_end;
    }
  }
  [[nodiscard]] int cell_after(double x) const {  ///< first with its centre at x or after it
    return static_cast<int>(std::ceil((x - grid_.low.x()) / grid_.size.x() - 0.5));
  }

  const TriangleSurface& surface_;
  const BoxGrid& grid_;
  int shift_ = 1;
  std::vector<Across> across_{};
  std::vector<Crossing> crossings_{};
};

/// Grows from `seed` over 26 neighbours; marks what it reaches with 0 in `left`.
std::size_t grow(const BoxGrid& grid, std::size_t seed, std::vector<std::uint8_t>& left) {
  std::vector<std::size_t> front{seed};
  left[seed] = 0;
  std::size_t reached = 0;
  while (!front.empty()) {
    const std::size_t at = front.back();
    front.pop_back();
    ++reached;
    const auto nx = static_cast<std::size_t>(grid.count[0]);
    const auto ny = static_cast<std::size_t>(grid.count[1]);
    const int i = static_cast<int>(at % nx);
    const int j = static_cast<int>(at / nx % ny);
    const int l = static_cast<int>(at / (nx * ny));
    for (int n = 0; n < 27; ++n) {
      const int ni = i + n % 3 - 1;
      const int nj = j + n / 3 % 3 - 1;
      const int nl = l + n / 9 - 1;
      if (!grid.holds(ni, nj, nl) || left[grid.index(ni, nj, nl)] == 0) { continue; }
      left[grid.index(ni, nj, nl)] = 0;
      front.push_back(grid.index(ni, nj, nl));
    }
  }
  return reached;
}

}  // namespace

BoxGrid cubes_around(const Vector3d& low, const Vector3d& high, double edge) {
  const Eigen::Array3d first = (low / edge).array().floor();
  const Eigen::Array3d last = (high / edge).array().ceil();
  BoxGrid grid{.low = edge * first.matrix(), .size = Vector3d::Constant(edge)};
  for (int n = 0; n < 3; ++n) {
    grid.count[static_cast<std::size_t>(n)] = std::max(1, static_cast<int>(last(n) - first(n)));
  }
  return grid;
}

VoxelBody voxelise(const TriangleSurface& surface, const BoxGrid& grid) {
  VoxelBody body{.inside = Scan(surface, grid).run()};
  std::vector<std::uint8_t> left = body.inside;
  for (std::size_t seed = 0; seed < left.size(); ++seed) {
    if (left[seed] == 0) { continue; }
    body.voxel_count += grow(grid, seed, left);
    ++body.parts;
  }
  body.volume = static_cast<double>(body.voxel_count) * grid.volume();
  return body;
}

SolidMoments moments_of(const VoxelBody& body, const BoxGrid& grid) {
  SolidMoments solid{.volume = body.volume};
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (int l = 0; l < grid.count[2]; ++l) {
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        if (body.inside[grid.index(i, j, l)] == 0) { continue; }
        const Vector3d at = grid.size.cwiseProduct(Vector3d(i + 0.5, j + 0.5, l + 0.5));
        first += at;
        second += at * at.transpose();
      }
    }
  }
  if (body.voxel_count == 0) { return solid; }
  const auto count = static_cast<double>(body.voxel_count);
  const Vector3d mean = first / count;
  const Matrix3d own = (grid.size.cwiseAbs2() / 12.0).asDiagonal();
  second = body.volume * (second / count - mean * mean.transpose() + own);
  solid.centroid = grid.low + mean;
  solid.inertia = second.trace() * Matrix3d::Identity() - second;
  return solid;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/tissue/voxel_tissue.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "model/problem/rules.hpp"
#include "model/tissue/lattice.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

/// Position across the rows in units of 2^-n cells; products of two differences fit in 64 bits.
struct Across {
  std::int64_t y = 0;
  std::int64_t z = 0;
};

std::int64_t turn(const Across& a, const Across& b, const Across& c) {
  return (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
}

/// Returns true if a point on this edge belongs to the face. Of the two faces at an edge, one
/// traverses it in this direction.
bool takes_edge(const Across& from, const Across& to) {
  return to.z > from.z || (to.z == from.z && to.y < from.y);
}

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
    for (int bits = most_bits; (std::int64_t{cells} << shift_) < (std::int64_t{1} << (bits - 1));
         ++shift_) {}
    across_.reserve(static_cast<std::size_t>(surface.vertex.cols()));
    for (Eigen::Index i = 0; i < surface.vertex.cols(); ++i) {
      const Vector3d cell = (surface.vertex.col(i) - grid.low).cwiseQuotient(grid.size);
      across_.push_back(
          {std::llround(std::ldexp(cell.y(), shift_)), std::llround(std::ldexp(cell.z(), shift_))});
    }
  }

  std::vector<std::uint8_t> run() {
    for (int f = 0; f < static_cast<int>(surface_.triangle.size()); ++f) { add_face(f); }
    std::ranges::sort(crossings_, {}, [](const Crossing& c) { return std::pair(c.row, c.x); });
    std::vector<std::uint8_t> inside(grid_.box_count(), 0);
    for (std::span<const Crossing> left(crossings_); !left.empty();) {
      const auto other =
          std::ranges::find_if(left, [&](const Crossing& c) { return c.row != left.front().row; });
      const auto count = static_cast<std::size_t>(other - left.begin());
      fill_row(left.first(count), inside);
      left = left.subspan(count);
    }
    return inside;
  }

 private:
  /// Returns the first cell of a row whose centre is at or after `place`.
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
    const auto at = [&](int n) {
      return across_[static_cast<std::size_t>(v[static_cast<std::size_t>(n)])];
    };
    const std::int64_t area = turn(at(0), at(1), at(2));
    if (area == 0) { return; }  // parallel to the row; the neighbouring faces count
    if (area < 0) { std::swap(v[1], v[2]); }
    const auto [y_low, y_high] = std::minmax({at(0).y, at(1).y, at(2).y});
    const auto [z_low, z_high] = std::minmax({at(0).z, at(1).z, at(2).z});
    const int j_end = std::min(first_centre(y_high + 1), grid_.count[1]);
    const int l_end = std::min(first_centre(z_high + 1), grid_.count[2]);
    for (int l = std::max(first_centre(z_low), 0); l < l_end; ++l) {
      for (int j = std::max(first_centre(y_low), 0); j < j_end; ++j) {
        add_crossing(v, j, l, area > 0 ? -1 : 1);
      }
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
    const auto row = static_cast<std::size_t>(l) * static_cast<std::size_t>(grid_.count[1]) +
                     static_cast<std::size_t>(j);
    crossings_.push_back({row, x / total, winding});
  }

  void fill_row(std::span<const Crossing> row, std::vector<std::uint8_t>& inside) const {
    const std::size_t first = row.front().row * static_cast<std::size_t>(grid_.count[0]);
    int winding = 0;
    int i_begin = 0;
    for (const Crossing& crossing : row) {
      const int i_end = std::clamp(cell_after(crossing.x), 0, grid_.count[0]);
      for (int i = i_begin; winding > 0 && i < i_end; ++i) {
        inside[first + static_cast<std::size_t>(i)] = 1;
      }
      winding += crossing.winding;
      i_begin = i_end;
    }
  }
  [[nodiscard]] int cell_after(double x) const {  ///< first cell with its centre at or after x
    return static_cast<int>(std::ceil((x - grid_.low.x()) / grid_.size.x() - 0.5));
  }

  const TriangleSurface& surface_;
  const BoxGrid& grid_;
  int shift_ = 1;
  std::vector<Across> across_{};
  std::vector<Crossing> crossings_{};
};

/// Finds the cells connected to `seed` over 26 neighbours and sets them to 0 in `left`. Returns
/// their number.
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

namespace {

constexpr double slack = 1e-9;  // of a position, in units of a box

std::uint16_t material_at(const VoxelTissue& tissue, const Vector3d& point) {
  const Vector3d cell = (point - tissue.boxes.low).cwiseQuotient(tissue.boxes.size);
  const auto i = static_cast<int>(std::floor(cell.x()));
  const auto j = static_cast<int>(std::floor(cell.y()));
  const auto l = static_cast<int>(std::floor(cell.z()));
  return tissue.boxes.holds(i, j, l) ? tissue.material[tissue.boxes.index(i, j, l)]
                                     : std::uint16_t{0};
}

/// Returns the sorted depths at which the line passes from one box to the next, from `first` to the
/// far side of the grid.
std::vector<double> wall_depths(const BoxGrid& grid, const Vector3d& origin, const Vector3d& n,
                                double first) {
  std::vector<double> depths{first};
  const Vector3d high =
      grid.low + grid.size.cwiseProduct(Vector3d(grid.count[0], grid.count[1], grid.count[2]));
  const double last = (high.z() - origin.z()) / n.z();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(n(axis)) < 1e-12) { continue; }
    for (int wall = 0; wall <= grid.count[static_cast<std::size_t>(axis)]; ++wall) {
      const double depth = (grid.low(axis) + wall * grid.size(axis) - origin(axis)) / n(axis);
      if (depth > first && depth <= last) { depths.push_back(depth); }
    }
  }
  std::ranges::sort(depths);
  return depths;
}

struct Run {
  double begin = 0.0;
  double end = 0.0;
  std::uint16_t material = 0;
};

PathInterval interval_of(const VoxelTissue& tissue, const std::vector<Material>& materials,
                         const Run& run) {
  PathInterval interval{.begin = run.begin, .end = run.end, .label = "gap"};
  if (run.material == 0) { return interval; }
  const std::string& name = tissue.materials[run.material - 1U];
  const Material* found = find_material(materials, name);
  return found == nullptr ? interval : interval_in(*found, name, run.begin, run.end);
}

/// Merges the gap at a steep skin, where nodes next to the line support it before its own box is
/// tissue.
void join_first_gap(const BoxGrid& grid, std::vector<PathInterval>& intervals) {
  if (intervals.size() < 2 || intervals[0].label != "gap" ||
      intervals[1].role == TissueRole::bone) {
    return;
  }
  if (intervals[0].end - intervals[0].begin > 2.0 * grid.size.z()) { return; }
  intervals[1].begin = intervals[0].begin;
  intervals.erase(intervals.begin());
}

}  // namespace

std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue,
                                          const std::vector<Material>& materials,
                                          const Vector3d& origin, const Vector3d& direction,
                                          double first) {
  // A line along a wall of boxes is shifted into the box of greater coordinates.
  const Vector3d from = origin + slack * tissue.boxes.size.cwiseProduct(Vector3d(1.0, 1.0, 0.0));
  const std::vector<double> depths = wall_depths(tissue.boxes, from, direction, first);
  std::vector<Run> runs;
  for (std::size_t n = 0; n + 1 < depths.size(); ++n) {
    const double middle = 0.5 * (depths[n] + depths[n + 1]);
    const std::uint16_t material = material_at(tissue, from + middle * direction);
    if (!runs.empty() && runs.back().material == material) {
      runs.back().end = depths[n + 1];
    } else {
      runs.push_back({depths[n], depths[n + 1], material});
    }
  }
  std::vector<PathInterval> intervals;
  for (const Run& run : runs) {
    PathInterval next = interval_of(tissue, materials, run);
    const bool thin = run.end - run.begin < tissue.thinnest && next.role != TissueRole::bone;
    if (!intervals.empty() && (thin || intervals.back().label == next.label)) {
      intervals.back().end = run.end;
    } else {
      intervals.push_back(std::move(next));
    }
  }
  join_first_gap(tissue.boxes, intervals);
  if (intervals.empty()) { intervals.push_back({.begin = first, .label = "gap"}); }
  intervals.back().end = std::numeric_limits<double>::infinity();
  return intervals;
}

namespace {

constexpr double most_boxes = 1e8;  // limit for the box around all bodies

class MeshVoxels {
 public:
  MeshVoxels(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
             const std::vector<Material>& materials, std::vector<Violation>& broken)
      : bodies_(bodies), settings_(settings), materials_(materials), broken_(broken) {}

  VoxelTissue run() {
    check_surfaces();
    check_surround();
    if (!broken_.empty() || !lay_grid()) { return {}; }
    fill_surround();
    fill_bodies();
    if (!broken_.empty()) { return {}; }
    tissue_.materials = materials_.names();
    number_nodes();
    make_network();
    return std::move(tissue_);
  }

 private:
  void check_surfaces() {
    if (bodies_.empty()) {
      broken_.push_back({"tissue.mesh.files", "is missing; at least one file is needed"});
    }
    for (const MeshBody& body : bodies_) {
      if (const auto defect = surface_defect(body.surface)) {
        broken_.push_back({body.key + ".path", body.name + ": " + *defect});
      }
    }
  }

  void check_surround() {
    if (!settings_.surround) { return; }
    const Surround& s = *settings_.surround;
    if ((s.max - s.min).minCoeff() > 0.0) { return; }
    broken_.push_back(
        {"tissue.mesh.surround.max",
         "is not above min along x, y and z; must be the opposite corner of the box"});
  }

  bool lay_grid() {
    Eigen::AlignedBox3d bounds;
    for (const MeshBody& body : bodies_) {
      bounds.extend(body.surface.vertex.rowwise().minCoeff());
      bounds.extend(body.surface.vertex.rowwise().maxCoeff());
    }
    if (settings_.surround) {
      bounds.extend(settings_.surround->min).extend(settings_.surround->max);
    }
    const Vector3d sizes = bounds.sizes();
    const double boxes = (sizes / settings_.voxel).array().ceil().max(1.0).prod();
    if (!(boxes <= most_boxes)) {
      broken_.push_back(
          {"tissue.mesh.voxel", number_in_words(settings_.voxel) + " m; makes " +
                                    number_in_words(boxes) + " voxels around the bodies of " +
                                    number_in_words(sizes.maxCoeff()) + " m; at most 1e8"});
      return false;
    }
    tissue_.boxes = cubes_around(bounds.min(), bounds.max(), settings_.voxel);
    tissue_.material.assign(tissue_.boxes.box_count(), 0);
    owner_.assign(tissue_.boxes.box_count(), -1);
    return true;
  }

  void fill_surround() {
    if (!settings_.surround) { return; }
    const Surround& s = *settings_.surround;
    const std::uint16_t code =
        materials_.code_of(s.material, "tissue.mesh.surround.material", broken_);
    const BoxGrid& grid = tissue_.boxes;
    for_each_place(grid.count, [&](int i, int j, int l) {
      const Vector3d centre =
          grid.low + grid.size.cwiseProduct(Vector3d(i + 0.5, j + 0.5, l + 0.5));
      const bool inside = (centre - s.min).minCoeff() > 0.0 && (s.max - centre).minCoeff() > 0.0;
      if (inside) { tissue_.material[grid.index(i, j, l)] = code; }
    });
  }

  void fill_bodies() {
    std::vector<std::size_t> order(bodies_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t n) { return bodies_[n].priority; });
    tissue_.bodies.resize(bodies_.size());
    for (const std::size_t n : order) { fill_body(n); }
    for (const int owner : owner_) {
      if (owner >= 0) { ++tissue_.bodies[static_cast<std::size_t>(owner)].kept_cells; }
    }
  }

  void fill_body(std::size_t n) {
    const MeshBody& body = bodies_[n];
    const std::uint16_t code = materials_.code_of(body.material, body.key + ".material", broken_);
    const VoxelBody voxels = voxelise(body.surface, tissue_.boxes);
    tissue_.bodies[n] = {.name = body.name,
                         .material = body.material,
                         .surface_volume = moments_of(body.surface).volume,
                         .voxel_volume = voxels.volume,
                         .parts = voxels.parts};
    if (voxels.voxel_count == 0) {
      broken_.push_back({"tissue.mesh.voxel", number_in_words(settings_.voxel) +
                                                  " m; no voxel's centre is inside " + body.name +
                                                  ", which is thinner; must be smaller"});
    }
    for (std::size_t box = 0; box < voxels.inside.size(); ++box) {
      if (voxels.inside[box] == 0) { continue; }
      tissue_.material[box] = code;
      owner_[box] = static_cast<int>(n);
    }
  }

  void number_nodes() {
    const BoxGrid& boxes = tissue_.boxes;
    NodeGrid& nodes = tissue_.nodes;
    nodes.first = boxes.low;
    nodes.spacing = boxes.size;
    nodes.count = {boxes.count[0] + 1, boxes.count[1] + 1, boxes.count[2] + 1};
    nodes.node.assign(nodes.index(0, 0, nodes.count[2]), -1);
    for_each_place(boxes.count, [&](int i, int j, int l) {
      if (tissue_.material[boxes.index(i, j, l)] == 0) { return; }
      for_each_corner(i, j, l, [&](int a, int b, int c) { nodes.node[nodes.index(a, b, c)] = 0; });
    });
    palpate::number_nodes(nodes);
  }

  void make_network() {
    const BoxGrid& boxes = tissue_.boxes;
    tissue_.network = grid_network(tissue_.nodes, settings_.connectivity,
                                   [&](int i, int j, int l, int, int) -> const CellMaterial* {
                                     const std::uint16_t code =
                                         tissue_.material[boxes.index(i, j, l)];
                                     return code == 0 ? nullptr : &materials_.cell(code);
                                   });
    for_each_place(boxes.count, [&](int i, int j, int l) {
      const std::size_t box = boxes.index(i, j, l);
      const bool held = owner_[box] >= 0 && bodies_[static_cast<std::size_t>(owner_[box])].fixed;
      if (!held && !materials_.bone(tissue_.material[box])) { return; }
      for_each_corner(i, j, l, [&](int a, int b, int c) {
        tissue_.network.fixed[static_cast<std::size_t>(tissue_.nodes.at(a, b, c))] = 1;
      });
    });
  }

  const std::vector<MeshBody>& bodies_;
  const MeshSettings& settings_;
  VoxelMaterials materials_;
  std::vector<Violation>& broken_;
  VoxelTissue tissue_{};
  std::vector<int> owner_{};  ///< body that owns the box; -1: none
};

}  // namespace

void place_in_tissue(TriangleSurface& surface, double scale, FileAxis inward,
                     const Vector3d& origin) {
  surface.vertex = axis_map(inward).matrix() * ((scale * surface.vertex).colwise() - origin);
}

VoxelTissue mesh_tissue(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
                        const std::vector<Material>& materials, std::vector<Violation>& broken) {
  return MeshVoxels(bodies, settings, materials, broken).run();
}

}  // namespace palpate

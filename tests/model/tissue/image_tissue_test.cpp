// SPDX-License-Identifier: MIT

#include "model/tissue/image_tissue.hpp"

#include <cmath>

#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Vector2d;
using Eigen::Vector3d;

const std::vector<Material> materials{
    {.name = "soft",
     .youngs_modulus = 2e3,
     .density = 900.0,
     .damping_ratio = 0.5,
     .cutting_force = 1.0},
    {.name = "stiff",
     .youngs_modulus = 2e6,
     .density = 1100.0,
     .damping_ratio = 0.5,
     .cutting_force = 5.0},
    {.name = "vertebra-bone", .youngs_modulus = 1e9, .density = 1900.0}};

/// Dark pixels are stiff and bright pixels soft, linear in log E between 0 and 1.
const std::vector<LookupPoint> falling{{0.0, "stiff"}, {1.0, "soft"}};

ImageVolume image_of(std::array<int, 3> count, const Vector3d& spacing, auto value) {
  ImageVolume image{.format = "test", .count = count, .spacing = spacing};
  for (int l = 0; l < count[2]; ++l) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        image.value.push_back(static_cast<float>(value(i, j, l)));
      }
    }
  }
  return image;
}

VoxelTissue build(const ImageVolume& image, const ImageSettings& settings,
                  const ImageVolume* labels = nullptr, const Vector2d& entry = Vector2d::Zero()) {
  std::vector<Violation> broken;
  VoxelTissue tissue = image_tissue(image, labels, settings, materials, entry, broken);
  for (const Violation& v : broken) { std::printf("%s: %s\n", v.key.c_str(), v.message.c_str()); }
  REQUIRE(broken.empty());
  return tissue;
}

std::string refusal(const ImageVolume& image, const ImageSettings& settings) {
  std::vector<Violation> broken;
  image_tissue(image, nullptr, settings, materials, Vector2d::Zero(), broken);
  return broken.empty() ? "" : broken.front().key + ": " + broken.front().message;
}

TEST("nodes lie at the pixels' own spacing, x fastest, centred, from z = 0 inwards") {
  const Vector3d spacing(0.5e-3, 0.7e-3, 0.9e-3);
  const VoxelTissue tissue = build(image_of({7, 5, 4}, spacing, [](int i, int, int) { return i; }),
                                   {.percentiles = {0.0, 100.0}, .lookup = falling});
  CHECK(tissue.network.node_count() == 140);
  for (const auto& [i, j, l] : {std::array{0, 0, 0}, std::array{6, 4, 3}, std::array{2, 3, 1}}) {
    const Vector3d expected = spacing.cwiseProduct(Vector3d(i - 3.0, j - 2.0, l));
    CHECK_NEAR(Vector3d(tissue.network.rest_position.col((l * 5 + j) * 7 + i)), expected, 1e-15);
  }
}

TEST("a spring's modulus is the mean of its nodes', each from the mean of 3 x 3 pixels") {
  // Brightness is linear along y: the mean of three pixels is the middle one, the mean at an edge
  // is that of two.
  const int ny = 11;
  const ImageVolume image =
      image_of({4, ny, 3}, Vector3d::Constant(1e-3), [](int, int j, int) { return 10.0 * j; });
  const VoxelTissue tissue = build(image, {.percentiles = {0.0, 100.0}, .lookup = falling});
  const auto modulus = [&](int j) {
    const double mean = j == 0 ? 5.0 : j == ny - 1 ? 10.0 * (ny - 1) - 5.0 : 10.0 * j;
    return 2e6 * std::pow(1e-3, mean / (10.0 * (ny - 1)));
  };
  const BoxBonds bonds = box_bonds(Vector3d::Constant(1e-3), 26);
  for (const Spring& s : tissue.network.springs) {
    const int ja = s.a / 4 % ny;
    const int jb = s.b / 4 % ny;
    const Vector3d away =
        tissue.network.rest_position.col(s.b) - tissue.network.rest_position.col(s.a);
    // All cells of a bond are inside the block; on a face, edge or corner only a half or a quarter.
    double share = 1.0;
    const Eigen::Array3i at(s.a % 4, ja, s.a / (4 * ny));
    for (int axis = 0; axis < 3; ++axis) {
      const bool edge = at(axis) == 0 || at(axis) == Eigen::Array3i(3, ny - 1, 2)(axis);
      share *= edge && std::abs(away(axis)) < 1e-9 ? 0.5 : 1.0;
    }
    const int axes = static_cast<int>((away.array().abs() > 1e-9).count());
    const double unit = bonds.stiffness[axes == 1 ? 0 : axes == 2 ? 3 : 12];
    const double expected = share * unit * 0.5 * (modulus(ja) + modulus(jb));
    // Intensities are kept in single precision, and E is exponential in them.
    CHECK_NEAR(s.stiffness / expected, 1.0, 1e-5);
  }
}

TEST("percentiles, not the brightest pixel, make the scale") {
  ImageVolume image =
      image_of({11, 11, 2}, Vector3d::Constant(1e-3), [](int i, int, int) { return 100.0 + i; });
  image.value[5] = 1e6F;  // a hot pixel
  const ImageSettings settings{.percentiles = {10.0, 90.0}, .lookup = falling};
  const VoxelTissue tissue = build(image, settings);
  // Ranks 24.1 and 216.9 of 242 sorted values, 22 of each brightness: 101 and 109.
  CHECK_NEAR(tissue.image->range, Vector2d(101.0, 109.0), 1e-4);
  CHECK_NEAR(double(tissue.intensity[5 * 11 + 5]), 0.5, 1e-6);
  CHECK(tissue.intensity[5 * 11 + 10] == 1.0F);
  // Units of another scanner have no effect.
  ImageVolume other = image;
  for (float& v : other.value) { v = 3.0F * v + 500.0F; }
  const VoxelTissue same = build(other, settings);
  for (std::size_t s = 0; s < same.network.springs.size(); ++s) {
    CHECK_NEAR(same.network.springs[s].stiffness / tissue.network.springs[s].stiffness, 1.0, 1e-3);
  }
}

TEST("strides, a region and a spacing of one's own choose the nodes") {
  const ImageVolume image = image_of({21, 17, 9}, {0.5e-3, 0.5e-3, 1e-3},
                                     [](int i, int j, int l) { return i + 3 * j + 7 * l; });
  const VoxelTissue strided = build(image, {.stride = 4, .slice_stride = 2, .lookup = falling});
  CHECK(strided.nodes.count == (std::array{6, 5, 5}));
  CHECK_NEAR(strided.nodes.spacing, Vector3d(2e-3, 2e-3, 2e-3), 1e-15);
  const ImageRegion region{{2e-3, 1e-3, 1e-3}, {4.4e-3, 5e-3, 4e-3}};
  const VoxelTissue part = build(image, {.region = region, .lookup = falling});
  CHECK(part.nodes.count == (std::array{5, 9, 4}));
  const VoxelTissue even =
      build(image, {.node_spacing = 1.25e-3, .percentiles = {0.0, 100.0}, .lookup = falling});
  CHECK(even.nodes.count == (std::array{9, 7, 7}));
  // Interpolation of a linear image is exact: node (4, 3, 2) is at pixel (10, 7.5, 2.5).
  CHECK_NEAR(double(even.intensity[(2 * 7 + 3) * 9 + 4]),
             (10.0 + 3.0 * 7.5 + 7.0 * 2.5) / (20.0 + 48.0 + 56.0), 1e-6);
}

TEST("the image's axis that points inwards becomes z, by its name or by the patient's") {
  ImageVolume image = image_of({5, 4, 3}, {1e-3, 2e-3, 3e-3},
                               [](int i, int j, int l) { return i + 10 * j + 100 * l; });
  const VoxelTissue turned =
      build(image, {.inward = FileAxis::x_minus, .percentiles = {0.0, 100.0}, .lookup = falling});
  CHECK(turned.nodes.count == (std::array{4, 3, 5}));
  CHECK_NEAR(turned.nodes.spacing, Vector3d(2e-3, 3e-3, 1e-3), 0.0);
  // z = 0 is the last pixel of a row; x is opposite to y of the image.
  const auto at = [&](int i, int j, int l) {
    return turned.intensity[turned.nodes.index(i, j, l)];
  };
  CHECK(at(0, 0, 0) > at(0, 0, 1));
  CHECK(at(0, 0, 0) > at(1, 0, 0));
  // Rows point to the patient's back, columns to the head, slices to the left.
  image.orientation.emplace() << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const VoxelTissue anterior =
      build(image, {.inward = FileAxis::anterior, .percentiles = {0.0, 100.0}, .lookup = falling});
  CHECK(anterior.intensity == turned.intensity);
  ImageVolume blind = image;
  blind.orientation.reset();
  CHECK_CONTAINS(refusal(blind, {.inward = FileAxis::anterior, .lookup = falling}),
                 "does not say how the patient lay");
}

TEST("a mirrored image is not taken for the other side of the patient") {
  ImageVolume image =
      image_of({4, 3, 3}, Vector3d::Constant(1e-3), [](int i, int, int) { return i; });
  image.orientation.emplace() << -1, 0, 0, 0, 1, 0, 0, 0, 1;
  const VoxelTissue mirrored = build(image, {.percentiles = {0.0, 100.0}, .lookup = falling});
  CHECK(mirrored.intensity.front() > mirrored.intensity[3]);
}

TEST("labels set the material, and bone among them never moves") {
  const ImageVolume image =
      image_of({4, 4, 6}, Vector3d::Constant(1e-3), [](int i, int, int) { return i; });
  const ImageVolume labels = image_of({4, 4, 6}, Vector3d::Constant(1e-3), [](int, int, int l) {
    return l >= 4 ? 76 : l == 3 ? 9 : 0;
  });
  const ImageSettings settings{.lookup = falling,
                               .materials = {{7, "vertebra-bone"}, {76, "vertebra-bone"}}};
  const VoxelTissue tissue = build(image, settings, &labels);
  CHECK(tissue.image->unused_labels == std::vector{7});
  CHECK(tissue.image->labelled_nodes == 32);
  CHECK(std::ranges::count(tissue.network.fixed, 1) == 32);
  CHECK(tissue.network.fixed.back() == 1);
  CHECK(tissue.network.fixed.front() == 0);
}

TEST("air before the skin is no tissue, darkness inside is, and z = 0 is the skin at the entry") {
  // Skin at slice 2 for x < 4 and at slice 3 from there on; a dark ligament at slice 6.
  const auto value = [](int i, int, int l) {
    return l < (i < 4 ? 2 : 3) ? 0.0 : l == 6 ? 2.0 : 100.0;
  };
  const ImageVolume image = image_of({8, 9, 12}, Vector3d::Constant(1e-3), value);
  const ImageSettings settings{.percentiles = {0.0, 100.0}, .air = 0.2, .lookup = falling};
  const VoxelTissue tissue = build(image, settings, nullptr, {-3e-3, 0.0});
  // Means of 3 x 3 pixels within a slice: the step of the skin is smeared by one pixel, at i = 3
  // and 4 of slice 2.
  CHECK_NEAR(*skin_depth(tissue.nodes, {-3e-3, 0.0}), 0.0, 1e-15);
  CHECK_NEAR(*skin_depth(tissue.nodes, {3e-3, 0.0}), 1e-3, 1e-15);
  CHECK(tissue.nodes.at(0, 0, 6) >= 0);
  CHECK_NEAR(tissue.nodes.first.z(), -2e-3, 1e-15);
  CHECK_CONTAINS(
      refusal(image_of({4, 4, 4}, Vector3d::Constant(1e-3), [](int i, int, int) { return i == 0; }),
              {.percentiles = {0.0, 100.0}, .air = 1.0, .lookup = falling}),
      "must leave some tissue");
}

TEST("noise in air is no tissue, and a gap in the skin lets no air in") {
  // Nodes every three pixels: 6 x 6 x 8, skin at slice 3; node (3, 3) is bright in slice 0, node
  // (1, 1) dark throughout.
  const auto value = [](int i, int j, int l) {
    const bool noise = (i + 1) / 3 == 3 && (j + 1) / 3 == 3 && l == 0;
    const bool gap = (i + 1) / 3 == 1 && (j + 1) / 3 == 1;
    return noise || (l >= 3 && !gap) ? 100.0 : 0.0;
  };
  const ImageSettings settings{
      .stride = 3, .percentiles = {0.0, 100.0}, .air = 0.5, .lookup = falling};
  const VoxelTissue tissue =
      build(image_of({18, 18, 8}, Vector3d::Constant(1e-3), value), settings);
  CHECK(tissue.nodes.at(3, 3, 0) < 0);
  CHECK(tissue.nodes.at(3, 3, 2) < 0);
  CHECK(tissue.nodes.at(1, 1, 2) < 0);
  CHECK(tissue.nodes.at(1, 1, 3) >= 0);
  CHECK(tissue.nodes.at(1, 1, 7) >= 0);
  CHECK_NEAR(double(std::ranges::count_if(tissue.nodes.node, [](int n) { return n >= 0; })),
             6.0 * 6.0 * 5.0, 0.0);
}

TEST("a needle reads its layers from the volume") {
  const auto value = [](int, int, int l) { return l < 10 ? 100.0 : l < 14 ? 0.0 : 100.0; };
  Scene scene;
  scene.materials = materials;
  scene.tissue.source = Source::mri;
  scene.tissue.voxels =
      std::make_shared<const VoxelTissue>(build(image_of({6, 6, 20}, {1e-3, 1e-3, 2e-3}, value),
                                                {.percentiles = {0.0, 100.0}, .lookup = falling}));
  scene.needle = Needle{.entry = {0.2e-3, -0.3e-3}};
  const NeedlePath path(scene, build_network(scene));
  const auto& intervals = path.intervals();
  CHECK(intervals.size() == 3);
  CHECK(intervals[0].label == "soft");
  CHECK(intervals[1].label == "stiff");
  CHECK(intervals[2].label == "soft");
  // Boxes are centred on pixels: slice 10 begins at 9.5 spacings.
  CHECK_NEAR(intervals[1].begin, 9.5 * 2e-3, 1e-12);
  CHECK_NEAR(intervals[1].end, 13.5 * 2e-3, 1e-12);
  CHECK_NEAR(intervals[1].cutting_force, 5.0, 0.0);
}

TEST("lookups are monotone with the stated ends, and the paper's is the inverse of that for T2") {
  std::vector<Violation> broken;
  std::vector<Material> library = materials;
  library.push_back({.name = "subcutaneous-fat", .youngs_modulus = 2.4e3});
  library.push_back({.name = "muscle", .youngs_modulus = 55.7e3});
  library.push_back({.name = "ligamentum-flavum", .youngs_modulus = 15e6});
  for (const Weighting weighting : {Weighting::t1, Weighting::t2, Weighting::literal}) {
    const Lookup lookup(lookup_points(weighting), library, weighting == Weighting::literal, broken);
    CHECK(broken.empty());
    const double sign = weighting == Weighting::literal ? 1.0 : -1.0;
    for (int n = 0; n < 1000; ++n) {
      const double change =
          lookup.youngs_modulus((n + 1) / 1000.0) - lookup.youngs_modulus(n / 1000.0);
      CHECK(sign * change >= 0.0);
    }
    CHECK_NEAR(lookup.softest(), 2.4e3, 0.0);
    CHECK_NEAR(lookup.stiffest(), 15e6, 0.0);
    CHECK(lookup.material(1.0) == (sign > 0.0 ? "ligamentum-flavum" : "subcutaneous-fat"));
  }
}

TEST("what cannot become tissue is refused with its key") {
  const ImageVolume image =
      image_of({4, 4, 4}, Vector3d::Constant(1e-3), [](int i, int, int) { return i; });
  CHECK_CONTAINS(refusal(image, {.lookup = {{0.5, "stiff"}, {0.5, "soft"}}}),
                 "tissue.mri.lookup[1].intensity: 0.5; must be above");
  CHECK_CONTAINS(refusal(image, {.lookup = {{0.1, "stiff"}, {0.5, "soft"}, {0.9, "stiff"}}}),
                 "rise and fall");
  CHECK_CONTAINS(refusal(image, {.lookup = {{0.1, "wood"}}}), "unknown material \"wood\"");
  CHECK_CONTAINS(refusal(image, {.stride = 9, .lookup = falling}), "one node along x");
  CHECK_CONTAINS(
      refusal(image, {.region = ImageRegion{{0.1, 0, 0}, {0.2, 1, 1}}, .lookup = falling}),
      "no pixel of the image lies in it along x");
  const ImageVolume flat =
      image_of({4, 4, 4}, Vector3d::Constant(1e-3), [](int, int, int) { return 7; });
  CHECK_CONTAINS(refusal(flat, {.lookup = falling}), "must have contrast");
}

}  // namespace PALPATE_FILE

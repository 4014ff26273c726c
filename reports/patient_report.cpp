// SPDX-License-Identifier: MIT
#include "reports/patient_report.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/image_lookup.hpp"
#include "model/dynamics/voxel_tissue.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

constexpr double mm = 1e3;
constexpr double cm3 = 1e6;

std::string by(const Eigen::Vector3d& v, double scale, std::string_view unit) {
  return short_number(scale * v.x(), 3) + " x " + short_number(scale * v.y(), 3) + " x " +
         short_number(scale * v.z(), 3) + std::string(unit);
}

void add_image_facts(const ImageFacts& image, const NodeGrid& nodes, std::vector<Fact>& facts) {
  facts.push_back({"image", image.format,
                   std::to_string(image.pixels[0]) + " x " + std::to_string(image.pixels[1]) + " x " +
                       std::to_string(image.pixels[2]) + " pixels of " + by(image.spacing, mm, " mm")});
  facts.push_back({"nodes apart", by(nodes.spacing, mm, " mm"),
                   "across, across and along z; " + std::to_string(image.labelled_nodes) + " nodes by label"});
  facts.push_back({"lookup", image.weighting,
                   "intensities from " + short_number(image.range.x(), 4) + " (0) to " +
                       short_number(image.range.y(), 4) + " (1)"});
  const bool isotropic = (image.youngs_moduli.array() - 1.0).abs().maxCoeff() < 1e-6;
  if (!isotropic) {
    facts.push_back({"moduli of the grid", by(image.youngs_moduli, 1.0, " of E"),
                     "along x, y and z: springs that pull cannot make boxes of this shape isotropic"});
  }
}

void add_body_facts(const BodyFacts& body, std::vector<Fact>& facts) {
  facts.push_back({body.name, short_number(cm3 * body.voxel_volume, 4) + " cm3 of voxels",
                   body.material + "; its surface holds " + short_number(cm3 * body.surface_volume, 4) + " cm3; " +
                       std::to_string(body.parts) + (body.parts == 1 ? " part; " : " parts; ") +
                       std::to_string(body.kept_cells) + " voxels kept"});
}

void add_layers(const Scene& scene, std::vector<Fact>& facts) {
  const NeedlePath path = tool_path(scene, scene.tissue.voxels->network);
  std::string layers;
  for (const PathInterval& interval : path.intervals()) {
    const std::string end = std::isfinite(interval.end) ? short_number(mm * interval.end, 4) + " mm" : "the end";
    layers += (layers.empty() ? "" : ", ") + interval.label + " to " + end;
  }
  facts.push_back({"layers on the needle's line", layers, "along it, from the skin"});
}

/// The plane of nodes through the tool, across y: x and z of its nodes in millimetres, brightness row by row.
struct Slice {
  std::vector<double> x{};
  std::vector<double> z{};
  std::vector<double> intensity{};
};

Slice slice_through(const VoxelTissue& tissue, double y) {
  const NodeGrid& grid = tissue.nodes;
  const double row = std::round((y - grid.first.y()) / grid.spacing.y());
  const int j = static_cast<int>(std::clamp(row, 0.0, grid.count[1] - 1.0));
  Slice slice;
  for (int i = 0; i < grid.count[0]; ++i) { slice.x.push_back(mm * grid.place(i, j, 0).x()); }
  for (int l = 0; l < grid.count[2]; ++l) {
    slice.z.push_back(mm * grid.place(0, j, l).z());
    for (int i = 0; i < grid.count[0]; ++i) {
      slice.intensity.push_back(static_cast<double>(tissue.intensity[grid.index(i, j, l)]));
    }
  }
  return slice;
}

Figure figure_of(const Slice& slice, const std::string& id, const std::string& title, const std::string& caption,
                 const std::string& label, const auto& value) {
  HeatMap map{.label = label, .x = slice.x, .y = slice.z};
  std::ranges::transform(slice.intensity, std::back_inserter(map.z), value);
  return {.id = id,
          .title = title,
          .caption = caption,
          .x = {.label = "x (mm)"},
          .y = {.label = "z, into the tissue (mm)"},
          .heat_map = std::move(map),
          .square = true};
}

}  // namespace

std::vector<Fact> patient_facts(const Scene& scene) {
  std::vector<Fact> facts;
  if (!scene.tissue.voxels) { return facts; }
  const VoxelTissue& tissue = *scene.tissue.voxels;
  if (tissue.image) { add_image_facts(*tissue.image, tissue.nodes, facts); }
  for (const BodyFacts& body : tissue.bodies) { add_body_facts(body, facts); }
  if (scene.needle) { add_layers(scene, facts); }
  return facts;
}

std::vector<Figure> lookup_figures(const Scene& scene) {
  if (!scene.tissue.voxels || !scene.tissue.voxels->image) { return {}; }
  const Slice slice = slice_through(*scene.tissue.voxels, scene.needle ? scene.needle->entry.y() : 0.0);
  std::vector<Figure> figures{figure_of(slice, "slice", "Plane through the image",
                                        "Brightness of the nodes, scaled by the percentiles.", "brightness (1)",
                                        [](double intensity) { return intensity; })};
  for (const Weighting weighting : {Weighting::t2, Weighting::t1, Weighting::literal}) {
    std::vector<Violation> broken;
    const bool literal = weighting == Weighting::literal;
    const Lookup lookup(lookup_points(weighting), scene.materials, literal, broken);
    if (!broken.empty()) { continue; }  // the scene has no materials of those names
    const std::string name = name_of(weighting);
    figures.push_back(figure_of(
        slice,
        "lookup-" + std::string(literal                      ? "literal"
                                : weighting == Weighting::t1 ? "t1"
                                                             : "t2"),
        "The same plane by the " + name + " lookup",
        literal ? "Young's modulus where bright means stiff, as in the paper. Labels do not show here."
                : "Young's modulus where the image is taken for " + name + "-weighted. Labels do not show here.",
        "log10 of E in Pa (1)", [&](double intensity) { return std::log10(lookup.youngs_modulus(intensity)); }));
  }
  return figures;
}

}  // namespace palpate

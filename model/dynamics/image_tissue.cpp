// SPDX-License-Identifier: MIT
#include "model/dynamics/image_tissue.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "model/dynamics/grid_network.hpp"
#include "model/dynamics/voxel_materials.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

class ImageNodes {
 public:
  ImageNodes(ImageSamples samples, const ImageSettings& settings, const std::vector<Material>& materials,
             std::vector<Violation>& broken)
      : samples_(std::move(samples)),
        settings_(settings),
        lookup_(settings.lookup.empty() ? lookup_points(settings.weighting) : settings.lookup, materials,
                settings.weighting == Weighting::literal, broken),
        materials_(materials),
        broken_(broken) {}

  VoxelTissue run(const Eigen::Vector2d& entry) {
    if (!broken_.empty()) { return {}; }
    lay_grid();
    leave_out_air();
    name_materials();
    if (!broken_.empty()) { return {}; }
    number_nodes();
    put_skin_at_zero(entry);
    make_network();
    tissue_.materials = materials_.names();
    tissue_.intensity = std::move(samples_.intensity);
    return std::move(tissue_);
  }

 private:
  void lay_grid() {
    NodeGrid& nodes = tissue_.nodes;
    nodes.count = samples_.count;
    nodes.spacing = samples_.spacing;
    const Vector3d steps(nodes.count[0] - 1, nodes.count[1] - 1, 0.0);
    nodes.first = -0.5 * nodes.spacing.cwiseProduct(steps);
    nodes.node.assign(samples_.intensity.size(), 0);
    tissue_.thinnest = 1.5 * nodes.spacing.z();
  }

  [[nodiscard]] bool labelled(std::size_t place) const {
    return !samples_.label.empty() && settings_.materials.contains(samples_.label[place]);
  }

  [[nodiscard]] bool dark(std::size_t place) const {
    return static_cast<double>(samples_.intensity[place]) < *settings_.air && !labelled(place);
  }

  /// What is dark before the first bright node of its line into the tissue. Darkness behind stays: ligament,
  /// fascia and cortical bone are dark as air.
  void leave_out_air() {
    if (!settings_.air) { return; }
    const NodeGrid& grid = tissue_.nodes;
    Eigen::ArrayXXi skin(grid.count[0], grid.count[1]);
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        int& l = skin(i, j) = 0;
        while (l < grid.count[2] && dark(grid.index(i, j, l))) { ++l; }
      }
    }
    bool all = true;
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        const int depth = without_outlier(skin, i, j);
        for (int l = 0; l < depth; ++l) {
          const std::size_t place = grid.index(i, j, l);
          if (!labelled(place)) { tissue_.nodes.node[place] = -1; }
        }
        all = all && depth == grid.count[2];
      }
    }
    if (all) { broken_.push_back({"tissue.mri.air", "all of the region is darker; must leave some tissue"}); }
  }

  /// Noise in air and gaps in the skin are a line wide: one that ends more than two nodes from the median of
  /// itself and its neighbours takes that.
  static int without_outlier(const Eigen::ArrayXXi& skin, int i, int j) {
    std::vector<int> around;
    for (int b = std::max(j - 1, 0); b <= std::min<int>(j + 1, static_cast<int>(skin.cols()) - 1); ++b) {
      for (int a = std::max(i - 1, 0); a <= std::min<int>(i + 1, static_cast<int>(skin.rows()) - 1); ++a) {
        around.push_back(skin(a, b));
      }
    }
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::ranges::nth_element(around, middle);
    return std::abs(skin(i, j) - *middle) > 2 ? *middle : skin(i, j);
  }

  void name_materials() {
    std::map<int, std::uint16_t> of_label;
    for (const auto& [label, name] : settings_.materials) {
      const std::string key = "tissue.mri.materials." + std::to_string(label);
      of_label[label] = materials_.code_of(name, key, broken_);
    }
    if (!broken_.empty()) { return; }
    tissue_.material.assign(samples_.intensity.size(), 0);
    modulus_.assign(samples_.intensity.size(), 0.0);
    std::size_t count = 0;
    for (std::size_t place = 0; place < tissue_.material.size(); ++place) {
      if (tissue_.nodes.node[place] < 0) { continue; }
      const auto intensity = static_cast<double>(samples_.intensity[place]);
      const bool by_label = labelled(place);
      tissue_.material[place] = by_label ? of_label[samples_.label[place]]
                                         : materials_.code_of(lookup_.material(intensity), "tissue.mri", broken_);
      modulus_[place] =
          by_label ? materials_.cell(tissue_.material[place]).youngs_modulus : lookup_.youngs_modulus(intensity);
      count += by_label ? 1U : 0U;
    }
    tissue_.image.emplace().labelled_nodes = count;
  }

  void number_nodes() {
    for (std::size_t place = 0; place < tissue_.nodes.node.size(); ++place) {
      if (tissue_.nodes.node[place] < 0) { continue; }
      tissue_.nodes.node[place] = static_cast<int>(place_of_.size());
      place_of_.push_back(place);
    }
  }

  void put_skin_at_zero(const Eigen::Vector2d& entry) {
    if (const auto skin = skin_depth(tissue_.nodes, entry)) { tissue_.nodes.first.z() -= *skin; }
    tissue_.boxes = {.low = tissue_.nodes.first - 0.5 * tissue_.nodes.spacing,
                     .size = tissue_.nodes.spacing,
                     .count = tissue_.nodes.count};
  }

  /// The mean of both nodes, whichever cell it is.
  const CellMaterial* between(int a, int b) {
    const std::size_t first = place_of_[static_cast<std::size_t>(a)];
    const std::size_t second = place_of_[static_cast<std::size_t>(b)];
    const CellMaterial& m = materials_.cell(tissue_.material[first]);
    const CellMaterial& n = materials_.cell(tissue_.material[second]);
    bond_ = {.youngs_modulus = 0.5 * (modulus_[first] + modulus_[second]),
             .density = 0.5 * (m.density + n.density),
             .damping_ratio = 0.5 * (m.damping_ratio + n.damping_ratio)};
    if (m.viscosity && n.viscosity) { bond_.viscosity = 0.5 * (*m.viscosity + *n.viscosity); }
    return &bond_;
  }

  void make_network() {
    tissue_.network = grid_network(tissue_.nodes, settings_.connectivity,
                                   [&](int, int, int, int a, int b) { return between(a, b); });
    for (std::size_t node = 0; node < place_of_.size(); ++node) {
      if (materials_.bone(tissue_.material[place_of_[node]])) { tissue_.network.fixed[node] = 1; }
    }
    ImageFacts& facts = *tissue_.image;
    facts.range = samples_.range;
    facts.youngs_moduli = box_bonds(tissue_.nodes.spacing, settings_.connectivity).youngs_moduli();
    facts.weighting = settings_.lookup.empty() ? name_of(settings_.weighting) : "own lookup";
  }

  ImageSamples samples_;
  const ImageSettings& settings_;
  Lookup lookup_;
  VoxelMaterials materials_;
  std::vector<Violation>& broken_;
  VoxelTissue tissue_{};
  std::vector<double> modulus_{};        ///< E per place [Pa]
  std::vector<std::size_t> place_of_{};  ///< of each node of the network
  CellMaterial bond_{};
};

}  // namespace

VoxelTissue image_tissue(const ImageVolume& image, const ImageVolume* labels, const ImageSettings& settings,
                         const std::vector<Material>& materials, const Eigen::Vector2d& entry,
                         std::vector<Violation>& broken) {
  ImageSamples samples = sample_image(image, labels, settings, broken);
  VoxelTissue tissue = ImageNodes(std::move(samples), settings, materials, broken).run(entry);
  if (!tissue.image) { return tissue; }
  tissue.image->format = image.format;
  tissue.image->pixels = image.count;
  tissue.image->spacing = image.spacing;
  return tissue;
}

}  // namespace palpate

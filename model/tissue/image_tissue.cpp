// SPDX-License-Identifier: MIT

#include "model/tissue/image_tissue.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "model/problem/rules.hpp"
#include "model/tissue/lattice.hpp"

namespace palpate {

std::vector<LookupPoint> lookup_points(Weighting weighting) {
  const std::string fat = "subcutaneous-fat";
  const std::string muscle = "muscle";
  const std::string ligament = "ligamentum-flavum";
  switch (weighting) {
    case Weighting::t1: return {{0.15, ligament}, {0.45, muscle}, {0.90, fat}};
    case Weighting::t2: return {{0.08, ligament}, {0.35, muscle}, {0.70, fat}};
    case Weighting::literal: return {{0.0, fat}, {1.0, ligament}};
  }
  return {};
}

std::string name_of(Weighting weighting) {
  return weighting == Weighting::t1 ? "T1" : weighting == Weighting::t2 ? "T2" : "literal";
}

Lookup::Lookup(const std::vector<LookupPoint>& points, const std::vector<Material>& materials,
               bool linear, std::vector<Violation>& broken)
    : points_(points), linear_(linear) {
  int rises = 0;
  int falls = 0;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    const Material* found = find_material(materials, points_[n].material);
    if (found == nullptr) {
      broken.push_back({at("tissue.mri.lookup", n, "material"),
                        unknown_material(points_[n].material, materials)});
      return;
    }
    modulus_.push_back(found->youngs_modulus);
    if (n == 0) { continue; }
    if (!(points_[n].intensity > points_[n - 1].intensity)) {
      broken.push_back({at("tissue.mri.lookup", n, "intensity"),
                        number_in_words(points_[n].intensity) + "; must be above that before it"});
    }
    (modulus_[n] > modulus_[n - 1] ? rises : falls) += modulus_[n] == modulus_[n - 1] ? 0 : 1;
  }
  if (rises > 0 && falls > 0) {
    broken.push_back({"tissue.mri.lookup",
                      "its moduli rise and fall; must only rise or only fall with intensity"});
  }
}

double Lookup::youngs_modulus(double intensity) const {
  const auto after = std::ranges::upper_bound(points_, intensity, {}, &LookupPoint::intensity);
  if (after == points_.begin()) { return modulus_.front(); }
  if (after == points_.end()) { return modulus_.back(); }
  const auto n = static_cast<std::size_t>(after - points_.begin());
  const double share =
      (intensity - points_[n - 1].intensity) / (points_[n].intensity - points_[n - 1].intensity);
  if (linear_) { return (1.0 - share) * modulus_[n - 1] + share * modulus_[n]; }
  return modulus_[n - 1] * std::pow(modulus_[n] / modulus_[n - 1], share);
}

const std::string& Lookup::material(double intensity) const {
  const double modulus = std::log(youngs_modulus(intensity));
  std::size_t nearest = 0;
  for (std::size_t n = 1; n < points_.size(); ++n) {
    const bool nearer =
        std::abs(std::log(modulus_[n]) - modulus) < std::abs(std::log(modulus_[nearest]) - modulus);
    if (nearer) { nearest = n; }
  }
  return points_[nearest].material;
}

double Lookup::softest() const { return *std::ranges::min_element(modulus_); }
double Lookup::stiffest() const { return *std::ranges::max_element(modulus_); }

namespace {

using Eigen::Vector3d;

constexpr double most_image_nodes = 2e7;
constexpr double rounding = 1e-6;  // of a position, in pixels

/// First and last pixel of the region along each axis of the image.
struct PixelRange {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
};

PixelRange range_of(const ImageVolume& image, const ImageSettings& settings,
                    std::vector<Violation>& broken) {
  PixelRange range{.last = {image.count[0] - 1, image.count[1] - 1, image.count[2] - 1}};
  if (!settings.region) { return range; }
  for (std::size_t n = 0; n < 3; ++n) {
    const auto axis = static_cast<Eigen::Index>(n);
    const double low = std::ceil(settings.region->min(axis) / image.spacing(axis) - rounding);
    const double high = std::floor(settings.region->max(axis) / image.spacing(axis) + rounding);
    range.first[n] = static_cast<int>(std::clamp(low, 0.0, double(image.count[n])));
    range.last[n] = static_cast<int>(std::clamp(high, -1.0, double(image.count[n] - 1)));
    if (range.last[n] >= range.first[n]) { continue; }
    broken.push_back({"tissue.mri.region",
                      "no pixel of the image lies in it along " +
                          std::string(1, static_cast<char>('x' + n)) + ", which goes from 0 to " +
                          number_in_words((image.count[n] - 1) * image.spacing(axis)) + " m"});
  }
  return range;
}

/// Returns the node positions along one axis of the image, in pixels.
std::vector<double> places_along(const ImageVolume& image, const ImageSettings& settings,
                                 const PixelRange& range, std::size_t axis) {
  const double spacing = image.spacing(static_cast<Eigen::Index>(axis));
  const double step = settings.node_spacing ? *settings.node_spacing / spacing
                      : axis == 2           ? double(settings.slice_stride)
                                            : double(settings.stride);
  const double length = range.last[axis] - range.first[axis];
  const auto count = static_cast<int>(std::floor(length / step + rounding)) + 1;
  std::vector<double> places;
  for (int n = 0; n < count; ++n) { places.push_back(range.first[axis] + n * step); }
  return places;
}

/// Returns the image axis closest to the direction `wanted`.
std::optional<FileAxis> image_axis(FileAxis wanted, const ImageVolume& image) {
  if (wanted < FileAxis::left) { return wanted; }
  if (!image.orientation) { return {}; }
  Vector3d way = Vector3d::Zero();  // in the patient frame
  const int n = static_cast<int>(wanted) - static_cast<int>(FileAxis::left);
  constexpr std::array<double, 6> sign{1.0, -1.0, -1.0,
                                       1.0, 1.0,  -1.0};  // left, right, anterior, ...
  way(n / 2) = sign[static_cast<std::size_t>(n)];
  const Vector3d along = image.orientation->transpose() * way;
  Eigen::Index axis = 0;
  along.cwiseAbs().maxCoeff(&axis);
  return static_cast<FileAxis>(2 * axis + (along(axis) > 0.0 ? 0 : 1));
}

/// Returns the axis map. For a mirrored image x is reversed, so that left remains left.
AxisMap map_of(FileAxis inward, const ImageVolume& image) {
  AxisMap map = axis_map(inward);
  const bool mirrored = image.orientation && image.orientation->determinant() < 0.0;
  if (mirrored) { map.sign[0] = -map.sign[0]; }
  return map;
}

/// Calls visit(a, b) for the column (i, j) and its eight neighbours in a grid, first index fastest.
template <class Visit> void for_each_beside(const GridCount& count, int i, int j, Visit visit) {
  for_each_between({std::max(i - 1, 0), std::max(j - 1, 0), 0},
                   {std::min(i + 1, count[0] - 1), std::min(j + 1, count[1] - 1), 0},
                   [&](int a, int b, int) { visit(a, b); });
}

class Sampler {
 public:
  explicit Sampler(const ImageVolume& image) : image_(image) {}

  /// Returns the mean of the 3 x 3 pixels around a pixel.
  [[nodiscard]] double mean(int i, int j, int l) const {
    double sum = 0.0;
    int pixels = 0;
    for_each_beside(image_.count, i, j, [&](int x, int y) {
      sum += static_cast<double>(image_.at(x, y, l));
      ++pixels;
    });
    return sum / pixels;
  }

  [[nodiscard]] double mean(const Vector3d& at) const {
    std::array<int, 3> low{};
    Vector3d share;
    for (std::size_t n = 0; n < 3; ++n) {
      const auto axis = static_cast<Eigen::Index>(n);
      low[n] =
          std::clamp(static_cast<int>(std::floor(at(axis) + rounding)), 0, image_.count[n] - 1);
      share(axis) = at(axis) - low[n] > rounding ? at(axis) - low[n] : 0.0;
    }
    double value = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> step{corner & 1, (corner >> 1) & 1, corner >> 2};
      double weight = 1.0;
      for (std::size_t n = 0; n < 3; ++n) {
        const double s = share(static_cast<Eigen::Index>(n));
        weight *= step[n] == 1 ? s : 1.0 - s;
      }
      if (weight > 0.0) {
        value += weight * mean(low[0] + step[0], low[1] + step[1], low[2] + step[2]);
      }
    }
    return value;
  }

 private:
  const ImageVolume& image_;
};

Eigen::Vector2d range_of_percentiles(const ImageVolume& image, const PixelRange& range,
                                     const Eigen::Vector2d& percentiles) {
  std::vector<float> values;
  for (int l = range.first[2]; l <= range.last[2]; ++l) {
    for (int j = range.first[1]; j <= range.last[1]; ++j) {
      const auto row = image.value.begin() + static_cast<std::ptrdiff_t>(image.index(0, j, l));
      values.insert(values.end(), row + range.first[0], row + range.last[0] + 1);
    }
  }
  const double low = percentile(values, percentiles.x());
  return {low, percentile(values, percentiles.y())};
}

/// Node positions along the axes of the image, and the map of these axes to the tissue frame.
struct SamplePlaces {
  std::array<std::vector<double>, 3> along{};
  AxisMap map{};
};

void fill(const ImageVolume& image, const ImageVolume* labels, const SamplePlaces& places,
          ImageSamples& samples) {
  const Sampler sampler(image);
  const double scale = 1.0 / (samples.range.y() - samples.range.x());
  for_each_place(samples.count, [&](int i, int j, int l) {
    const std::array<int, 3> node{i, j, l};
    Vector3d at;
    for (std::size_t n = 0; n < 3; ++n) {
      const auto axis = static_cast<std::size_t>(places.map.from[n]);
      const auto& along = places.along[axis];
      const auto step = static_cast<std::size_t>(node[n]);
      at(static_cast<Eigen::Index>(axis)) =
          places.map.sign[n] > 0 ? along[step] : along[along.size() - 1 - step];
    }
    const double intensity = (sampler.mean(at) - samples.range.x()) * scale;
    samples.intensity.push_back(static_cast<float>(std::clamp(intensity, 0.0, 1.0)));
    if (labels == nullptr) { return; }
    const Eigen::Vector3i pixel = at.array().round().cast<int>();
    samples.label.push_back(
        static_cast<int>(std::lround(labels->at(pixel.x(), pixel.y(), pixel.z()))));
  });
}

}  // namespace

double percentile(std::vector<float>& values, double percent) {
  const double place = percent / 100.0 * static_cast<double>(values.size() - 1);
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::ranges::nth_element(values, low);
  const double share = place - std::floor(place);
  if (share == 0.0) { return static_cast<double>(*low); }
  const double next = static_cast<double>(*std::ranges::min_element(low + 1, values.end()));
  return (1.0 - share) * static_cast<double>(*low) + share * next;
}

ImageSamples sample_image(const ImageVolume& image, const ImageVolume* labels,
                          const ImageSettings& settings, std::vector<Violation>& broken) {
  ImageSamples samples;
  const std::optional<FileAxis> inward = image_axis(settings.inward, image);
  if (!inward) {
    broken.push_back({"tissue.mri.inward",
                      "this image does not say how the patient lay; must be one of "
                      "\"+x\", \"-x\", \"+y\", \"-y\", \"+z\" and \"-z\""});
    return samples;
  }
  const PixelRange range = range_of(image, settings, broken);
  if (!broken.empty()) { return samples; }
  SamplePlaces places{.map = map_of(*inward, image)};
  double nodes = 1.0;
  for (std::size_t n = 0; n < 3; ++n) { places.along[n] = places_along(image, settings, range, n); }
  for (std::size_t n = 0; n < 3; ++n) {
    const auto axis = static_cast<std::size_t>(places.map.from[n]);
    samples.count[n] = static_cast<int>(places.along[axis].size());
    const auto file_axis = static_cast<Eigen::Index>(axis);
    samples.spacing(static_cast<Eigen::Index>(n)) = settings.node_spacing.value_or(
        image.spacing(file_axis) * (axis == 2 ? settings.slice_stride : settings.stride));
    nodes *= samples.count[n];
    if (samples.count[n] >= 2) { continue; }
    broken.push_back({"tissue.mri.region", "leaves one node along " +
                                               std::string(1, static_cast<char>('x' + axis)) +
                                               " of the image; at least two along each axis"});
  }
  if (nodes > most_image_nodes) {
    broken.push_back(
        {"tissue.mri.stride",
         number_in_words(nodes) + " nodes; at most 2e7, by stride, node_spacing or region"});
  }
  if (!broken.empty()) { return samples; }
  samples.range = range_of_percentiles(image, range, settings.percentiles);
  if (!(samples.range.y() > samples.range.x())) {
    broken.push_back({"tissue.mri.percentiles", "the intensities there are " +
                                                    number_in_words(samples.range.x()) + " and " +
                                                    number_in_words(samples.range.y()) +
                                                    "; the image must have contrast between them"});
    return samples;
  }
  fill(image, labels, places, samples);
  return samples;
}

namespace {

class ImageNodes {
 public:
  ImageNodes(ImageSamples samples, const ImageSettings& settings,
             const std::vector<Material>& materials, std::vector<Violation>& broken)
      : samples_(std::move(samples)),
        settings_(settings),
        lookup_(settings.lookup.empty() ? lookup_points(settings.weighting) : settings.lookup,
                materials, settings.weighting == Weighting::literal, broken),
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

  /// Removes dark nodes in front of the first bright node of their line into the tissue. Dark nodes
  /// behind it remain: ligament, fascia and cortical bone are as dark as air.
  void leave_out_air() {
    if (!settings_.air) { return; }
    const NodeGrid& grid = tissue_.nodes;
    Eigen::ArrayXXi skin(grid.count[0], grid.count[1]);
    for_each_column(grid.count, [&](int i, int j) {
      int& l = skin(i, j) = 0;
      while (l < grid.count[2] && dark(grid.index(i, j, l))) { ++l; }
    });
    bool all = true;
    for_each_column(grid.count, [&](int i, int j) {
      const int depth = without_outlier(skin, i, j);
      for (int l = 0; l < depth; ++l) {
        const std::size_t place = grid.index(i, j, l);
        if (!labelled(place)) { tissue_.nodes.node[place] = -1; }
      }
      all = all && depth == grid.count[2];
    });
    if (all) {
      broken_.push_back({"tissue.mri.air", "all of the region is darker; must leave some tissue"});
    }
  }

  /// Returns the skin index without outliers. Noise in air and gaps in the skin are one line wide:
  /// an index more than two nodes from the median of itself and its neighbours is replaced by the
  /// median.
  [[nodiscard]] int without_outlier(const Eigen::ArrayXXi& skin, int i, int j) const {
    std::vector<int> around;
    for_each_beside(tissue_.nodes.count, i, j, [&](int a, int b) { around.push_back(skin(a, b)); });
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
    std::set<int> used;
    for (std::size_t place = 0; place < tissue_.material.size(); ++place) {
      if (tissue_.nodes.node[place] < 0) { continue; }
      const auto intensity = static_cast<double>(samples_.intensity[place]);
      const bool by_label = labelled(place);
      tissue_.material[place] =
          by_label ? of_label[samples_.label[place]]
                   : materials_.code_of(lookup_.material(intensity), "tissue.mri", broken_);
      modulus_[place] = by_label ? materials_.cell(tissue_.material[place]).youngs_modulus
                                 : lookup_.youngs_modulus(intensity);
      count += by_label ? 1U : 0U;
      if (by_label) { used.insert(samples_.label[place]); }
    }
    ImageFacts& facts = tissue_.image.emplace();
    facts.labelled_nodes = count;
    for (const auto& [label, name] : settings_.materials) {
      if (!used.contains(label)) { facts.unused_labels.push_back(label); }
    }
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

  /// Returns the mean material of both nodes, the same for every cell.
  const CellMaterial* between(int a, int b) {
    const std::size_t first = place_of_[static_cast<std::size_t>(a)];
    const std::size_t second = place_of_[static_cast<std::size_t>(b)];
    MaterialMean mean;
    for (const std::size_t place : {first, second}) {
      CellMaterial material = materials_.cell(tissue_.material[place]);
      material.youngs_modulus = modulus_[place];
      mean.add(0.5, material);
    }
    bond_ = mean.mean();
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
  std::vector<double> modulus_{};        ///< E per grid point [Pa]
  std::vector<std::size_t> place_of_{};  ///< grid point of each node of the network
  CellMaterial bond_{};
};

}  // namespace

VoxelTissue image_tissue(const ImageVolume& image, const ImageVolume* labels,
                         const ImageSettings& settings, const std::vector<Material>& materials,
                         const Eigen::Vector2d& entry, std::vector<Violation>& broken) {
  ImageSamples samples = sample_image(image, labels, settings, broken);
  VoxelTissue tissue = ImageNodes(std::move(samples), settings, materials, broken).run(entry);
  if (!tissue.image) { return tissue; }
  tissue.image->format = image.format;
  tissue.image->pixels = image.count;
  tissue.image->spacing = image.spacing;
  return tissue;
}

}  // namespace palpate

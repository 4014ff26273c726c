// SPDX-License-Identifier: MIT
#include "model/dynamics/image_samples.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "model/dynamics/rules.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double most_image_nodes = 2e7;
constexpr double rounding = 1e-6;  // of a place, in pixels

/// First and last pixel of the region along each axis of the image.
struct PixelRange {
  std::array<int, 3> first{};
  std::array<int, 3> last{};
};

PixelRange range_of(const ImageVolume& image, const ImageSettings& settings, std::vector<Violation>& broken) {
  PixelRange range{.last = {image.count[0] - 1, image.count[1] - 1, image.count[2] - 1}};
  if (!settings.region) { return range; }
  for (std::size_t n = 0; n < 3; ++n) {
    const auto axis = static_cast<Eigen::Index>(n);
    const double low = std::ceil(settings.region->min(axis) / image.spacing(axis) - rounding);
    const double high = std::floor(settings.region->max(axis) / image.spacing(axis) + rounding);
    range.first[n] = static_cast<int>(std::clamp(low, 0.0, double(image.count[n])));
    range.last[n] = static_cast<int>(std::clamp(high, -1.0, double(image.count[n] - 1)));
    if (range.last[n] >= range.first[n]) { continue; }
    broken.push_back({"tissue.mri.region", "no pixel of the image lies in it along " +
                                               std::string(1, static_cast<char>('x' + n)) +
                                               ", which goes from 0 to " +
                                               number_in_words((image.count[n] - 1) * image.spacing(axis)) + " m"});
  }
  return range;
}

/// Places of nodes along one axis of the image, in pixels.
std::vector<double> places_along(const ImageVolume& image, const ImageSettings& settings, const PixelRange& range,
                                 std::size_t axis) {
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

/// The axis of the image that points most nearly the way that `wanted` names.
std::optional<FileAxis> image_axis(FileAxis wanted, const ImageVolume& image) {
  if (wanted < FileAxis::left) { return wanted; }
  if (!image.orientation) { return {}; }
  Vector3d way = Vector3d::Zero();  // in the patient's frame
  const int n = static_cast<int>(wanted) - static_cast<int>(FileAxis::left);
  constexpr std::array<double, 6> sign{1.0, -1.0, -1.0, 1.0, 1.0, -1.0};  // left, right, anterior, ...
  way(n / 2) = sign[static_cast<std::size_t>(n)];
  const Vector3d along = image.orientation->transpose() * way;
  Eigen::Index axis = 0;
  along.cwiseAbs().maxCoeff(&axis);
  return static_cast<FileAxis>(2 * axis + (along(axis) > 0.0 ? 0 : 1));
}

/// A mirrored image has its x turned round, so that left stays left.
AxisMap map_of(FileAxis inward, const ImageVolume& image) {
  AxisMap map = axis_map(inward);
  const bool mirrored = image.orientation && image.orientation->determinant() < 0.0;
  if (mirrored) { map.sign[0] = -map.sign[0]; }
  return map;
}

class Sampler {
 public:
  explicit Sampler(const ImageVolume& image) : image_(image) {}

  /// Mean of the 3 x 3 pixels around a pixel.
  [[nodiscard]] double mean(int i, int j, int l) const {
    double sum = 0.0;
    int pixels = 0;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 1, image_.count[1] - 1); ++y) {
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, image_.count[0] - 1); ++x, ++pixels) {
        sum += static_cast<double>(image_.at(x, y, l));
      }
    }
    return sum / pixels;
  }

  [[nodiscard]] double mean(const Vector3d& at) const {
    std::array<int, 3> low{};
    Vector3d share;
    for (std::size_t n = 0; n < 3; ++n) {
      const auto axis = static_cast<Eigen::Index>(n);
      low[n] = std::clamp(static_cast<int>(std::floor(at(axis) + rounding)), 0, image_.count[n] - 1);
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
      if (weight > 0.0) { value += weight * mean(low[0] + step[0], low[1] + step[1], low[2] + step[2]); }
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

/// Places of nodes along the axes of the image, and how those lie in the tissue.
struct SamplePlaces {
  std::array<std::vector<double>, 3> along{};
  AxisMap map{};
};

void fill(const ImageVolume& image, const ImageVolume* labels, const SamplePlaces& places, ImageSamples& samples) {
  const Sampler sampler(image);
  const double scale = 1.0 / (samples.range.y() - samples.range.x());
  for (int l = 0; l < samples.count[2]; ++l) {
    for (int j = 0; j < samples.count[1]; ++j) {
      for (int i = 0; i < samples.count[0]; ++i) {
        const std::array<int, 3> node{i, j, l};
        Vector3d at;
        for (std::size_t n = 0; n < 3; ++n) {
          const auto axis = static_cast<std::size_t>(places.map.from[n]);
          const auto& along = places.along[axis];
          const auto step = static_cast<std::size_t>(node[n]);
          at(static_cast<Eigen::Index>(axis)) = places.map.sign[n] > 0 ? along[step] : along[along.size() - 1 - step];
        }
        const double intensity = (sampler.mean(at) - samples.range.x()) * scale;
        samples.intensity.push_back(static_cast<float>(std::clamp(intensity, 0.0, 1.0)));
        if (labels == nullptr) { continue; }
        const Eigen::Vector3i pixel = at.array().round().cast<int>();
        samples.label.push_back(static_cast<int>(std::lround(labels->at(pixel.x(), pixel.y(), pixel.z()))));
      }
    }
  }
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

ImageSamples sample_image(const ImageVolume& image, const ImageVolume* labels, const ImageSettings& settings,
                          std::vector<Violation>& broken) {
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
    broken.push_back({"tissue.mri.region", "leaves one node along " + std::string(1, static_cast<char>('x' + axis)) +
                                               " of the image; at least two along each axis"});
  }
  if (nodes > most_image_nodes) {
    broken.push_back(
        {"tissue.mri.stride", number_in_words(nodes) + " nodes; at most 2e7, by stride, node_spacing or region"});
  }
  if (!broken.empty()) { return samples; }
  samples.range = range_of_percentiles(image, range, settings.percentiles);
  if (!(samples.range.y() > samples.range.x())) {
    broken.push_back({"tissue.mri.percentiles", "the intensities there are " + number_in_words(samples.range.x()) +
                                                    " and " + number_in_words(samples.range.y()) +
                                                    "; the image must have contrast between them"});
    return samples;
  }
  fill(image, labels, places, samples);
  return samples;
}

}  // namespace palpate

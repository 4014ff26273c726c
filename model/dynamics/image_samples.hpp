// SPDX-License-Identifier: MIT
#pragma once
/// An image at the places of a grid of nodes in the tissue frame (model/EQUATIONS.md, "Image to stiffness").

#include <map>
#include <optional>

#include "model/dynamics/file_axis.hpp"
#include "model/dynamics/image_lookup.hpp"
#include "model/dynamics/image_volume.hpp"

namespace palpate {

struct ImageRegion {
  Eigen::Vector3d min{0.0, 0.0, 0.0};  ///< from the centre of the first pixel along x, y, z of the image [m]
  Eigen::Vector3d max{0.0, 0.0, 0.0};  ///< [m]
};

struct ImageSettings {
  Weighting weighting = Weighting::t2;
  int stride = 1;                          ///< pixels between nodes within a slice
  int slice_stride = 1;                    ///< slices between nodes
  std::optional<double> node_spacing{};    ///< [m] in all three directions, instead of strides
  FileAxis inward = FileAxis::z_plus;      ///< of the image; points into the tissue
  std::optional<ImageRegion> region{};     ///< empty: the whole image
  Eigen::Vector2d percentiles{1.0, 99.0};  ///< of the region's pixels that stand for 0 and 1 [%]
  std::optional<double> air{};             ///< darker than this [0 to 1] before the skin: no tissue
  int connectivity = 26;
  std::vector<LookupPoint> lookup{};       ///< instead of the weighting's own
  std::map<int, std::string> materials{};  ///< of label values; others follow the lookup
};

/// Values at nodes, x of the tissue frame fastest.
struct ImageSamples {
  std::array<int, 3> count{0, 0, 0};
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m], tissue frame
  Eigen::Vector2d range{0.0, 0.0};         ///< intensities of the percentiles
  std::vector<float> intensity{};          ///< 0 to 1
  std::vector<int> label{};                ///< empty without labels
};

/// Intensity is the mean of the 3 x 3 pixels of the slice around the node's place (of those there are at an
/// edge), between pixels by linear interpolation, and scaled by the percentiles; a label is that of the
/// nearest pixel. What forbids it goes to `broken`, and then the samples are of no use.
ImageSamples sample_image(const ImageVolume& image, const ImageVolume* labels, const ImageSettings& settings,
                          std::vector<Violation>& broken);

/// Percentile [%] with linear interpolation between the values in order; `values` are reordered.
double percentile(std::vector<float>& values, double percent);

}  // namespace palpate

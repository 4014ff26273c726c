// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of image brightness to Young's modulus (model/EQUATIONS.md, "Image to stiffness").

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/tissue/file_axis.hpp"
#include "model/tissue/image_volume.hpp"
#include "model/tissue/scene_check.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

/// Table from brightness to tissue. `literal` is the rule of the paper: bright = stiff.
enum class Weighting { t1, t2, literal };

/// Brightness [0 to 1] that is mapped to a material.
struct LookupPoint {
  double intensity = 0.0;
  std::string material{};
};

std::vector<LookupPoint> lookup_points(Weighting weighting);

/// Returns the name used in scene files, e.g. "T2".
std::string name_of(Weighting weighting);

/// Monotone curve through the moduli of the points, linear in log E, or in E if `linear`, and
/// constant before the first and after the last point.
class Lookup {
 public:
  /// Adds a violation to `broken` if the curve is not monotone; it must not be used then.
  Lookup(const std::vector<LookupPoint>& points, const std::vector<Material>& materials,
         bool linear, std::vector<Violation>& broken);

  [[nodiscard]] double youngs_modulus(double intensity) const;  ///< [Pa]
  /// Returns the material of the point with the nearest modulus, by ratio.
  [[nodiscard]] const std::string& material(double intensity) const;
  [[nodiscard]] double softest() const;   ///< [Pa]
  [[nodiscard]] double stiffest() const;  ///< [Pa]

 private:
  std::vector<LookupPoint> points_;
  std::vector<double> modulus_{};  ///< [Pa]
  bool linear_ = false;
};

struct ImageRegion {
  Eigen::Vector3d min{0.0, 0.0, 0.0};  ///< in the image, from the centre of the first pixel [m]
  Eigen::Vector3d max{0.0, 0.0, 0.0};  ///< [m]
};

struct ImageSettings {
  Weighting weighting = Weighting::t2;
  int stride = 1;                          ///< pixels between nodes within a slice
  int slice_stride = 1;                    ///< slices between nodes
  std::optional<double> node_spacing{};    ///< in all three directions, replaces the strides [m]
  FileAxis inward = FileAxis::z_plus;      ///< direction of the image that points into the tissue
  std::optional<ImageRegion> region{};     ///< empty: the whole image
  Eigen::Vector2d percentiles{1.0, 99.0};  ///< of the pixels, that map to intensity 0 and 1 [%]
  std::optional<double> air{};  ///< darker pixels in front of the skin are not tissue [0 to 1]
  int connectivity = 26;
  std::vector<LookupPoint> lookup{};       ///< replaces the points of the weighting
  std::map<int, std::string> materials{};  ///< of label values; others use the lookup
};

/// Values at the nodes; x of the tissue frame varies fastest.
struct ImageSamples {
  std::array<int, 3> count{0, 0, 0};
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m], tissue frame
  Eigen::Vector2d range{0.0, 0.0};         ///< raw values at the percentiles
  std::vector<float> intensity{};          ///< 0 to 1
  std::vector<int> label{};                ///< empty without labels
};

/// Samples an image. The intensity of a node is the mean of the 3 x 3 pixels of the slice around
/// it, interpolated between pixels and scaled by the percentiles; its label is that of the nearest
/// pixel. Adds violations to `broken` if it cannot be sampled; the result must not be used then.
ImageSamples sample_image(const ImageVolume& image, const ImageVolume* labels,
                          const ImageSettings& settings, std::vector<Violation>& broken);

/// Returns a percentile [%] with linear interpolation between the sorted values. Reorders `values`.
double percentile(std::vector<float>& values, double percent);

/// Builds the tissue: one node per sample, with springs from its brightness. `labels` may be null;
/// otherwise it has the shape of the image. z = 0 is the first tissue below `entry` (x and y,
/// centred on the grid [m]). Adds violations to `broken` if the input is not valid; the result must
/// not be used then.
VoxelTissue image_tissue(const ImageVolume& image, const ImageVolume* labels,
                         const ImageSettings& settings, const std::vector<Material>& materials,
                         const Eigen::Vector2d& entry, std::vector<Violation>& broken);

}  // namespace palpate

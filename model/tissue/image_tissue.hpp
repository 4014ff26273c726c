// SPDX-License-Identifier: MIT
#pragma once
/// From brightness to Young's modulus (model/EQUATIONS.md, "Image to stiffness").

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "model/tissue/file_axis.hpp"
#include "model/tissue/image_volume.hpp"
#include "model/tissue/scene_check.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

/// What kind of image it is: which brightness means which tissue. `literal` is the paper's rule,
/// bright = stiff.
enum class Weighting { t1, t2, literal };

/// Brightness [0 to 1] at which the tissue is taken for a material.
struct LookupPoint {
  double intensity = 0.0;
  std::string material{};
};

/// Points of a weighting, by names of the shipped library.
std::vector<LookupPoint> lookup_points(Weighting weighting);

/// Name as in scene files, "T2".
std::string name_of(Weighting weighting);

/// A monotone curve through the points' moduli: constant before the first and after the last, and
/// between two straight in the logarithm of E, or in E itself where `linear`.
class Lookup {
 public:
  /// Points in order of intensity; what forbids a monotone curve goes to `broken`, and then it is
  /// of no use.
  Lookup(const std::vector<LookupPoint>& points, const std::vector<Material>& materials,
         bool linear, std::vector<Violation>& broken);

  [[nodiscard]] double youngs_modulus(double intensity) const;  ///< [Pa]
  /// The point whose modulus is nearest, by ratio.
  [[nodiscard]] const std::string& material(double intensity) const;
  [[nodiscard]] double softest() const;   ///< [Pa]
  [[nodiscard]] double stiffest() const;  ///< [Pa]

 private:
  std::vector<LookupPoint> points_;
  std::vector<double> modulus_{};  ///< [Pa]
  bool linear_ = false;
};

// An image at the places of a grid of nodes in the tissue frame (model/EQUATIONS.md, "Image to
// stiffness").

struct ImageRegion {
  Eigen::Vector3d min{0.0, 0.0,
                      0.0};  ///< from the centre of the first pixel along x, y, z of the image [m]
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

/// Intensity is the mean of the 3 x 3 pixels of the slice around the node's place (of those there
/// are at an edge), between pixels by linear interpolation, and scaled by the percentiles; a label
/// is that of the nearest pixel. What forbids it goes to `broken`, and then the samples are of no
/// use.
ImageSamples sample_image(const ImageVolume& image, const ImageVolume* labels,
                          const ImageSettings& settings, std::vector<Violation>& broken);

/// Percentile [%] with linear interpolation between the values in order; `values` are reordered.
double percentile(std::vector<float>& values, double percent);

// Tissue from an image: a node per sample, springs by its brightness (model/EQUATIONS.md, "Image to
// stiffness").

/// `labels` may be null; they have the shape of the image. z = 0 is the first tissue beneath
/// `entry` (x and y, centred on the grid [m]). What forbids it goes to `broken`, and then the
/// tissue is of no use.
VoxelTissue image_tissue(const ImageVolume& image, const ImageVolume* labels,
                         const ImageSettings& settings, const std::vector<Material>& materials,
                         const Eigen::Vector2d& entry, std::vector<Violation>& broken);

}  // namespace palpate

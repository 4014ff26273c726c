// SPDX-License-Identifier: MIT
#pragma once
/// Tissue from an image: a node per sample, springs by its brightness (model/EQUATIONS.md, "Image to stiffness").

#include "model/dynamics/image_samples.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

/// `labels` may be null; they have the shape of the image. z = 0 is the first tissue beneath `entry` (x and y,
/// centred on the grid [m]). What forbids it goes to `broken`, and then the tissue is of no use.
VoxelTissue image_tissue(const ImageVolume& image, const ImageVolume* labels, const ImageSettings& settings,
                         const std::vector<Material>& materials, const Eigen::Vector2d& entry,
                         std::vector<Violation>& broken);

}  // namespace palpate

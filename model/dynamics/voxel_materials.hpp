// SPDX-License-Identifier: MIT
#pragma once
/// The materials of a tissue of voxels, each named once.

#include <algorithm>
#include <string>
#include <vector>

#include "model/dynamics/bond_sum.hpp"
#include "model/dynamics/scene_check.hpp"

namespace palpate {

class VoxelMaterials {
 public:
  explicit VoxelMaterials(const std::vector<Material>& known) : known_(known) {}

  /// Code of a material for VoxelTissue::material; 0, with a violation of `key`, for one that is unknown.
  std::uint16_t code_of(const std::string& name, const std::string& key, std::vector<Violation>& broken) {
    const auto used = std::ranges::find(names_, name);
    if (used != names_.end()) { return static_cast<std::uint16_t>(used - names_.begin() + 1); }
    const auto found = std::ranges::find(known_, name, &Material::name);
    if (found == known_.end()) {
      broken.push_back({key, unknown_material(name, known_)});
      return 0;
    }
    names_.push_back(name);
    cells_.push_back({found->youngs_modulus, found->density, found->damping_ratio, found->viscosity});
    bone_.push_back(role_of(*found) == TissueRole::bone);
    return static_cast<std::uint16_t>(names_.size());
  }
  [[nodiscard]] const CellMaterial& cell(std::uint16_t code) const { return cells_[code - 1U]; }
  [[nodiscard]] bool bone(std::uint16_t code) const { return code != 0 && bone_[code - 1U]; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  const std::vector<Material>& known_;
  std::vector<std::string> names_{};
  std::vector<CellMaterial> cells_{};
  std::vector<bool> bone_{};
};

}  // namespace palpate

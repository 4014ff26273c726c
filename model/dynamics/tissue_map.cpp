// SPDX-License-Identifier: MIT
#include "model/dynamics/tissue_map.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>

#include "model/dynamics/skin.hpp"
#include "model/dynamics/tissue_grid.hpp"

namespace palpate {

namespace {

constexpr double on_surface = 1e-9;  // what counts as on a surface [m]

const Material& material_named(const Scene& scene, std::string_view name) {
  const auto found = std::ranges::find(scene.materials, name, &Material::name);
  if (found == scene.materials.end()) {
    throw std::invalid_argument("no material " +
                                std::string(name));  // check_scene refuses it first
  }
  return *found;
}

bool is_bone(const Material& material) { return role_of(material) == TissueRole::bone; }

CellMaterial cell_of(const Material& m) {
  return {m.youngs_modulus, m.density, m.damping_ratio, m.viscosity};
}

/// Calls visit(material, upper end, lower end); below the last layer that layer goes on.
template <class Visit>
void for_each_layer(const Scene& scene, Visit visit) {
  double begin = 0.0;
  const auto& layers = scene.tissue.layers;
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const double end = n + 1 == layers.size() ? std::numeric_limits<double>::infinity()
                                              : begin + layers[n].thickness;
    visit(material_named(scene, layers[n].material), begin, end);
    begin = end;
  }
}

/// Materials met in a cell: the softer ones as one, and the last bone.
struct Mixture {
  std::optional<CellMaterial> soft{};
  const Material* bone = nullptr;
};

/// Mean by their share of the layers between top and bottom that are not bone.
Mixture layered_mixture(const Scene& scene, double top, double bottom) {
  Mixture mixture;
  double bone_share = 0.0;
  CellMaterial mean;
  double viscosity = 0.0;
  double viscosity_share = 0.0;
  for_each_layer(scene, [&](const Material& m, double begin, double end) {
    const double share = (std::min(bottom, end) - std::max(top, begin)) / (bottom - top);
    if (share <= 0.0) { return; }
    if (is_bone(m)) {
      bone_share += share;
      mixture.bone = &m;
      return;
    }
    mean.youngs_modulus += share * m.youngs_modulus;
    mean.density += share * m.density;
    mean.damping_ratio += share * m.damping_ratio;
    viscosity += share * m.viscosity.value_or(0.0);
    viscosity_share += m.viscosity ? share : 0.0;
  });
  const double rest = 1.0 - bone_share;
  if (rest * (bottom - top) <= on_surface) { return mixture; }
  mixture.bone = nullptr;
  if (viscosity_share > 0.5 * rest) { mean.viscosity = viscosity / viscosity_share; }
  if (bone_share > 0.0) {
    mean.youngs_modulus /= rest;
    mean.density /= rest;
    mean.damping_ratio /= rest;
  }
  mixture.soft = mean;
  return mixture;
}

/// Softer inclusion at a corner that is not in bone, for a cell that lies in a layer of bone.
const Material* inclusion_beside_bone(const Scene& scene, const Cell& cell) {
  const Material* found = nullptr;
  for (int n = 0; n < 8; ++n) {
    for (const Inclusion& body : scene.tissue.inclusions) {
      const Material& m = material_named(scene, body.material);
      if (!is_bone(m) && contains(body, cell.corner(n))) { found = &m; }
    }
  }
  return found;
}

bool all_in_bone(const Scene& scene, const Cell& cell) {
  for (int n = 0; n < 8; ++n) {
    if (!in_bone(scene, cell.corner(n))) { return false; }
  }
  return true;
}

}  // namespace

bool contains(const Inclusion& body, const Eigen::Vector3d& point, double margin) {
  const Eigen::Vector3d away = point - body.centre;
  if (body.shape == Inclusion::Shape::sphere) {
    return away.norm() <= 0.5 * body.size.x() + margin;
  }
  return (away.cwiseAbs() - 0.5 * body.size).maxCoeff() <= margin;
}

double depth_in_layers(const Scene& scene, const Eigen::Vector3d& point) {
  return layers_follow_skin(scene) ? scene.tissue.skin->depth(point) : point.z();
}

std::size_t layer_at(const std::vector<Layer>& layers, double depth) {
  std::size_t n = 0;
  for (double end = layers[0].thickness; n + 1 < layers.size() && depth >= end; end += layers[n].thickness) { ++n; }
  return n;
}

CellMaterial cell_material(const Scene& scene, const Cell& cell) {
  const Tissue& tissue = scene.tissue;
  Mixture mixture;
  if (layers_follow_skin(scene)) {
    const double middle = tissue.skin->distance(cell.centre());  // only cells beneath the skin are asked for
    mixture = layered_mixture(scene, std::max(0.0, middle - 0.5 * cell.size), middle + 0.5 * cell.size);
  } else if (tissue.source == Source::layers) {
    mixture = layered_mixture(scene, cell.low.z(), cell.bottom);
  } else {
    mixture.soft = cell_of(material_named(scene, tissue.lattice.material));
  }
  for (const Inclusion& body : tissue.inclusions) {
    if (!contains(body, cell.centre())) { continue; }
    const Material& m = material_named(scene, body.material);
    mixture.bone = is_bone(m) ? &m : nullptr;
    if (mixture.bone == nullptr) { mixture.soft = cell_of(m); }
  }
  if (mixture.bone == nullptr) { return *mixture.soft; }
  if (all_in_bone(scene, cell)) { return cell_of(*mixture.bone); }
  if (mixture.soft) { return *mixture.soft; }
  const Material* beside = inclusion_beside_bone(scene, cell);
  return cell_of(beside != nullptr ? *beside : *mixture.bone);
}

bool in_bone(const Scene& scene, const Eigen::Vector3d& point) {
  bool bone = false;
  const double depth = depth_in_layers(scene, point);
  for_each_layer(scene, [&](const Material& m, double top, double bottom) {
    const bool here = depth >= top - on_surface && depth <= bottom + on_surface;
    bone = bone || (here && is_bone(m));
  });
  for (const Inclusion& body : scene.tissue.inclusions) {
    const bool hard = is_bone(material_named(scene, body.material));
    if (contains(body, point, hard ? on_surface : -on_surface)) { bone = hard; }
  }
  return bone;
}

bool has_bone(const Scene& scene) {
  const auto hard = [&](const auto& part) { return is_bone(material_named(scene, part.material)); };
  return std::ranges::any_of(scene.tissue.layers, hard) ||
         std::ranges::any_of(scene.tissue.inclusions, hard);
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include "model/problem/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate {

namespace {

constexpr int thickest_gauge = 14;
/// Outer diameters of gauges 14 to 27 [m]: inches of the Stubs needle scale, rounded to 1 um.
constexpr std::array diameters{2.108e-3, 1.829e-3, 1.651e-3, 1.473e-3, 1.270e-3,
                               1.067e-3, 0.908e-3, 0.819e-3, 0.718e-3, 0.641e-3,
                               0.565e-3, 0.514e-3, 0.464e-3, 0.413e-3};

bool names(const Material& material, std::string_view part) {
  return material.name.find(part) != std::string::npos;
}

}  // namespace

std::optional<double> diameter_of_gauge(int gauge) {
  constexpr int thinnest_gauge = thickest_gauge + static_cast<int>(diameters.size()) - 1;
  if (gauge < thickest_gauge || gauge > thinnest_gauge) { return {}; }
  const int index = gauge - thickest_gauge;
  return diameters[static_cast<std::size_t>(index)];
}

Syringe air_syringe() {
  constexpr double thinner = 55.0;  // water 1.0e-3 Pa s, air 1.8e-5 Pa s
  Syringe air;
  air.compliance = 1.0e-10;  // 10 ml at 101 kPa
  air.thumb_flow *= thinner;
  air.tissue_resistance /= thinner;
  air.epidural_resistance /= thinner;
  air.open_resistance /= thinner;
  return air;
}

MaterialLaw law_of(const Material& material) {
  return {.stiffening = material.stiffening.value_or(Stiffening{}),
          .branches = material.relaxation};
}

TissueRole role_of(const Material& material) {
  if (material.role) { return *material.role; }
  if (names(material, "epidural")) { return TissueRole::epidural_space; }
  if (names(material, "dura")) { return TissueRole::dura; }
  if (names(material, "bone")) { return TissueRole::bone; }
  return TissueRole::tissue;
}

const Material* find_material(const std::vector<Material>& materials, std::string_view name) {
  const auto found = std::ranges::find(materials, name, &Material::name);
  return found == materials.end() ? nullptr : &*found;
}

std::vector<int> face_nodes(const NodeVectors& rest_position, Face face) {
  const int axis = static_cast<int>(face) / 2;
  const bool maximum = static_cast<int>(face) % 2 == 1;
  std::vector<int> nodes;
  if (rest_position.cols() == 0) { return nodes; }
  const double extent =
      (rest_position.rowwise().maxCoeff() - rest_position.rowwise().minCoeff()).maxCoeff();
  const auto row = rest_position.row(axis);
  const double extreme = maximum ? row.maxCoeff() : row.minCoeff();
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    if (std::abs(row(i) - extreme) <= 1e-6 * extent) { nodes.push_back(static_cast<int>(i)); }
  }
  return nodes;
}

std::vector<Load> resolve_loads(const Scene& scene, const SpringNetwork& network) {
  std::vector<Load> loads = scene.loads;
  for (Load& load : loads) {
    if (load.face) { load.nodes = face_nodes(network.rest_position, *load.face); }
    load.face.reset();
  }
  return loads;
}

int record_node(const Record& record, const SpringNetwork& network) {
  if (const int* node = std::get_if<int>(&record.where)) { return *node; }
  Eigen::Index nearest = 0;
  (network.rest_position.colwise() - std::get<Eigen::Vector3d>(record.where))
      .colwise()
      .squaredNorm()
      .minCoeff(&nearest);
  return static_cast<int>(nearest);
}

Eigen::Vector2d Probe::centre(double t) const noexcept {
  if (!path) { return entry; }
  const auto after = std::ranges::upper_bound(*path, t, {}, [](const auto& p) { return p.x(); });
  if (after == path->begin()) { return path->front().tail<2>(); }
  if (after == path->end()) { return path->back().tail<2>(); }
  const Eigen::Vector3d& a = *(after - 1);
  const double share = (t - a.x()) / (after->x() - a.x());
  return a.tail<2>() + share * (after->tail<2>() - a.tail<2>());
}

}  // namespace palpate

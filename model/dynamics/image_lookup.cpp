// SPDX-License-Identifier: MIT
#include "model/dynamics/image_lookup.hpp"

#include <algorithm>
#include <cmath>

#include "model/dynamics/rules.hpp"

namespace palpate {

std::vector<LookupPoint> lookup_points(Weighting weighting) {
  const std::string fat = "subcutaneous-fat";
  const std::string muscle = "muscle";
  const std::string ligament = "ligamentum-flavum";
  switch (weighting) {
    case Weighting::t1:
      return {{0.15, ligament}, {0.45, muscle}, {0.90, fat}};
    case Weighting::t2:
      return {{0.08, ligament}, {0.35, muscle}, {0.70, fat}};
    case Weighting::literal:
      return {{0.0, fat}, {1.0, ligament}};
  }
  return {};
}

std::string name_of(Weighting weighting) {
  return weighting == Weighting::t1 ? "T1" : weighting == Weighting::t2 ? "T2" : "literal";
}

Lookup::Lookup(const std::vector<LookupPoint>& points, const std::vector<Material>& materials, bool linear,
               std::vector<Violation>& broken)
    : points_(points), linear_(linear) {
  int rises = 0;
  int falls = 0;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    const auto found = std::ranges::find(materials, points_[n].material, &Material::name);
    if (found == materials.end()) {
      broken.push_back({at("tissue.mri.lookup", n, "material"), unknown_material(points_[n].material, materials)});
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
    broken.push_back({"tissue.mri.lookup", "its moduli rise and fall; must only rise or only fall with intensity"});
  }
}

double Lookup::youngs_modulus(double intensity) const {
  const auto after = std::ranges::upper_bound(points_, intensity, {}, &LookupPoint::intensity);
  if (after == points_.begin()) { return modulus_.front(); }
  if (after == points_.end()) { return modulus_.back(); }
  const auto n = static_cast<std::size_t>(after - points_.begin());
  const double share = (intensity - points_[n - 1].intensity) / (points_[n].intensity - points_[n - 1].intensity);
  if (linear_) { return (1.0 - share) * modulus_[n - 1] + share * modulus_[n]; }
  return modulus_[n - 1] * std::pow(modulus_[n] / modulus_[n - 1], share);
}

const std::string& Lookup::material(double intensity) const {
  const double modulus = std::log(youngs_modulus(intensity));
  std::size_t nearest = 0;
  for (std::size_t n = 1; n < points_.size(); ++n) {
    const bool nearer = std::abs(std::log(modulus_[n]) - modulus) < std::abs(std::log(modulus_[nearest]) - modulus);
    if (nearer) { nearest = n; }
  }
  return points_[nearest].material;
}

double Lookup::softest() const { return *std::ranges::min_element(modulus_); }
double Lookup::stiffest() const { return *std::ranges::max_element(modulus_); }

}  // namespace palpate

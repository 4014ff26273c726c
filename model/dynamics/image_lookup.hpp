// SPDX-License-Identifier: MIT
#pragma once
/// From brightness to Young's modulus (model/EQUATIONS.md, "Image to stiffness").

#include <string>
#include <vector>

#include "model/dynamics/scene_check.hpp"

namespace palpate {

/// What kind of image it is: which brightness means which tissue. `literal` is the paper's rule, bright = stiff.
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

/// A monotone curve through the points' moduli: constant before the first and after the last, and between
/// two straight in the logarithm of E, or in E itself where `linear`.
class Lookup {
 public:
  /// Points in order of intensity; what forbids a monotone curve goes to `broken`, and then it is of no use.
  Lookup(const std::vector<LookupPoint>& points, const std::vector<Material>& materials, bool linear,
         std::vector<Violation>& broken);

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

}  // namespace palpate

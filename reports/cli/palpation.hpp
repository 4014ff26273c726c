// SPDX-License-Identifier: MIT
#pragma once
/// The palpation map of `palpate run`, where a scene's probe asks for one.

#include <optional>
#include <string>
#include <vector>

#include "reports/cli/loaded_scene.hpp"
#include "validation/outcome.hpp"

namespace palpate::cli {

struct Palpation {
  std::optional<Figure> figure{};      ///< empty: not asked for, or the warning says why there is none
  std::vector<std::string> warnings{};
  std::string csv{};                   ///< x_m,y_m,stiffness_n_per_m; a row per site, x fastest
};

Palpation palpate_skin(const LoadedScene& loaded);

}  // namespace palpate::cli

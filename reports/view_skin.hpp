// SPDX-License-Identifier: MIT
#pragma once
/// The surface of a scene's skin as its 3-D view shows it.

#include <optional>
#include <string>
#include <vector>

#include "reports/view.hpp"

namespace palpate {

inline constexpr std::size_t most_faces_shown = 60'000;

/// Faces around the tissue, half its length on every side, their vertices carried by its nodes. Nothing without a
/// skin, or where there are more of them than can be shown; `notes` says so.
std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes);

}  // namespace palpate

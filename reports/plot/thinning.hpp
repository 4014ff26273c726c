// SPDX-License-Identifier: MIT
#pragma once
/// Reduction of long series to the samples that a picture needs. Data files keep all samples.

#include <functional>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Position of a sample in the picture [px]; not finite if the sample cannot be drawn.
struct Pixel {
  double x = 0.0;
  double y = 0.0;
};
using Projection = std::function<Pixel(double x, double y)>;

/// Returns sample indices in ascending order; every gap (samples that cannot be drawn) is included
/// once. For a curve with increasing x, the first, smallest, largest and last sample of every pixel
/// column are kept, so no spike is lost. Other paths keep samples that move by half a pixel; points
/// keep samples that earlier points do not cover.
std::vector<std::size_t> thinned(const Series& series, const Projection& project);

}  // namespace palpate

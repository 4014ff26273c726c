// SPDX-License-Identifier: MIT
#pragma once
/// Which samples of a long series a picture needs. Data files keep them all.

#include <functional>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Where a sample lies in the picture, in pixels; not finite where it cannot be drawn.
struct Pixel {
  double x = 0.0;
  double y = 0.0;
};
using Projection = std::function<Pixel(double x, double y)>;

/// Indices in order, and with them every gap (a sample that cannot be drawn) once.
/// A curve over rising x keeps the first, least, greatest and last sample of every pixel column, so
/// no spike is lost. Any other path keeps what moves by half a pixel, points what no earlier point
/// covers.
std::vector<std::size_t> thinned(const Series& series, const Projection& project);

}  // namespace palpate

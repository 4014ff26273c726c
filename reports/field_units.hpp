// SPDX-License-Identifier: MIT
#pragma once
/// Axes in the prefix that people would choose: "displacement (mm)" up to 0.9, not "(m)" up to
/// 0.0009.

#include "validation/outcome.hpp"

namespace palpate {

/// A copy whose linear axes in metres, seconds, newtons, pascals, joules, metres per second or
/// watts are scaled where their numbers would have many zeros. Data files keep SI.
Figure in_field_units(Figure figure);

}  // namespace palpate

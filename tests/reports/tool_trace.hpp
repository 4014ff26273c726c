// SPDX-License-Identifier: MIT
#pragma once
/// A needle through skin, ligament and epidural space and back out, made by hand: 1 mm a tick.

#include <cmath>

#include "model/dynamics/pressure_units.hpp"
#include "model/dynamics/trace.hpp"

namespace sample {

using namespace palpate;

inline std::string layer_at(double depth_mm) {
  return depth_mm <= 0.0  ? ""
         : depth_mm < 3.0 ? "skin"
         : depth_mm < 7.0 ? "ligament"
                          : "epidural <space>";
}

/// Depths 0, 0, 1, ..., 10, 9, ..., 0 mm; cutting 2 N in the skin and 5 N in the ligament while it
/// advances, friction 0.5 N per mm with the sign of the motion.
inline Trace needle_trace() {
  Trace trace;
  Column depth{"tool.depth_m", "m", {}};
  Column force{"tool.force_n", "N", {}};
  Column cutting{"tool.cutting_n", "N", {}};
  Column friction{"tool.friction_n", "N", {}};
  Column stiffness{"tool.stiffness_n", "N", {}};
  Column pressure{"syringe.pressure_pa", "Pa", {}};
  Column lateral{"tool.lateral_n", "N", {}};
  TextColumn layer{"tool.layer", {}};
  for (int n = 0; n <= 21; ++n) {
    const double mm = n < 1 ? 0.0 : n <= 11 ? n - 1.0 : 21.0 - n;
    const bool advances = n > 1 && n <= 11;
    const std::string where = layer_at(mm);
    const double cut = !advances ? 0.0 : where == "skin" ? 2.0 : where == "ligament" ? 5.0 : 0.0;
    trace.time.push_back(0.1 * n);
    depth.values.push_back(1e-3 * mm);
    cutting.values.push_back(cut);
    friction.values.push_back((advances ? 0.5 : -0.5) * mm);
    stiffness.values.push_back(0.0);
    force.values.push_back(cut + friction.values.back());
    pressure.values.push_back(where.starts_with("epidural") ? pascals_per_mmhg : 200.0 * pascals_per_mmhg);
    lateral.values.push_back(1e-9);
    layer.values.push_back(where);
  }
  trace.columns = {depth, force, cutting, friction, stiffness, pressure, lateral};
  trace.text_columns = {layer, {"tool.event", std::vector<std::string>(22)}};
  trace.events = {{0.2, "contact", "skin"},
                  {0.4, "puncture", "ligament"},
                  {0.8, "loss-of-resistance", "epidural <space>"},
                  {2.1, "withdrawn", "skin"}};
  return trace;
}

/// The same motion of a blunt tool.
inline Trace probe_trace() {
  Trace trace = needle_trace();
  std::erase_if(trace.columns, [](const Column& c) { return c.name.starts_with("syringe"); });
  for (Column& column : trace.columns) {
    const bool part = column.name == "tool.cutting_n" || column.name == "tool.friction_n";
    if (part) { column.values.assign(column.values.size(), 0.0); }
  }
  return trace;
}

}  // namespace sample

// SPDX-License-Identifier: MIT
#pragma once
/// What a run through the emulated Falcon shows: facts, and figures from the trace alone.

#include <vector>

#include "model/dynamics/trace.hpp"
#include "reports/html_page.hpp"
#include "validation/falcon_loop.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Empty without columns of a device.
std::vector<Figure> falcon_figures(const Trace& trace);

/// What the motors can pull with where the insertion starts, across and along the needle.
Figure force_reach_figure(const FalconFacts& facts);

std::vector<Fact> falcon_fact_list(const FalconFacts& facts);

}  // namespace palpate

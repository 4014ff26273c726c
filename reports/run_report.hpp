// SPDX-License-Identifier: MIT
#pragma once
/// What a run through the emulated Falcon shows: facts, and figures from the trace alone.

#include <optional>
#include <string>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/trace.hpp"
#include "reports/html/html_page.hpp"
#include "reports/view/view.hpp"
#include "validation/outcome.hpp"
#include "validation/subject/falcon_loop.hpp"

namespace palpate {

/// Empty without columns of a device.
std::vector<Figure> falcon_figures(const Trace& trace);

/// What the motors can pull with where the insertion starts, across and along the needle.
Figure force_reach_figure(const FalconFacts& facts);

std::vector<Fact> falcon_fact_list(const FalconFacts& facts);

// What a run's page says of tissue that came from a patient's files.

/// What was read and what became of it, and the layers on the needle's line; nothing for other
/// tissues.
std::vector<Fact> patient_facts(const Scene& scene);

/// Of an image: one plane through it, along the needle, as brightness and as the modulus that each
/// lookup makes of it. Nothing for other tissues.
std::vector<Figure> lookup_figures(const Scene& scene);

// report.html of one run: what was simulated, how it went, and its traces, as pictures and as
// plots to zoom into.

struct RunReport {
  std::string title{};
  bool held = true;       ///< false: the banner is red
  std::string verdict{};  ///< one line
  std::string detail{};   ///< one sentence under it
  std::vector<Fact> facts{};
  std::vector<Figure> tool_figures{};  ///< after those of the trace
  std::vector<std::string> skipped{};
  std::vector<std::string> warnings{};
  std::optional<View> view{};  ///< the run in three dimensions
  std::vector<Fact> provenance{};
  std::string command{};
};

std::string to_html(const RunReport& report, const Trace& trace);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Report of a run with the emulated Falcon: facts, and figures computed from the trace.

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

/// Figures of the device columns; empty if the trace has none.
std::vector<Figure> falcon_figures(const Trace& trace);

/// Figure of the largest motor forces at the insertion point, across and along the needle.
Figure force_reach_figure(const FalconFacts& facts);

std::vector<Fact> falcon_fact_list(const FalconFacts& facts);

/// Facts about the imported data and the layers along the needle path; empty for other tissues.
std::vector<Fact> patient_facts(const Scene& scene);

/// Figures of one image plane along the needle: brightness, and the modulus given by each lookup
/// table. Empty for tissues without an image.
std::vector<Figure> lookup_figures(const Scene& scene);

// report.html of one run: scene, outcome and traces, as pictures and as interactive plots.

struct RunReport {
  std::string title{};
  bool held = true;       ///< false: red banner
  std::string verdict{};  ///< verdict in one line
  std::string detail{};   ///< one sentence below the verdict
  /// Differences from the last run in the same folder; absent if there was none.
  std::optional<std::vector<std::string>> changes{};
  std::vector<Fact> facts{};
  std::vector<Figure> tool_figures{};  ///< figures shown after those of the trace
  std::vector<std::string> skipped{};
  std::vector<Fact> trust{};  ///< estimated error of each source
  std::vector<std::string> warnings{};
  std::optional<View> view{};  ///< the run in three dimensions
  bool interactive = true;     ///< false: pictures of the view alone
  std::vector<Fact> provenance{};
  std::string command{};
};

std::string to_html(const RunReport& report, const Trace& trace);

}  // namespace palpate

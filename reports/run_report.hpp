// SPDX-License-Identifier: MIT
#pragma once
/// report.html of one run: what was simulated, how it went, and its traces, as pictures and as
/// plots to zoom into.

#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/trace.hpp"
#include "reports/html_page.hpp"
#include "reports/view.hpp"
#include "validation/outcome.hpp"

namespace palpate {

struct RunReport {
  std::string title{};
  bool held = true;       ///< false: the banner is red
  std::string verdict{};  ///< one line
  std::string detail{};   ///< one sentence under it
  std::vector<Fact> facts{};
  std::vector<Figure> tool_figures{};  ///< after those of the trace
  std::vector<std::string> skipped{};
  std::vector<std::string> warnings{};
  std::optional<View> view{};   ///< the run in three dimensions
  std::vector<Fact> provenance{};
  std::string command{};
};

std::string to_html(const RunReport& report, const Trace& trace);

}  // namespace palpate

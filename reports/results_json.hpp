// SPDX-License-Identifier: MIT
#pragma once
/// results.json (docs/formats.md): what was found, and which data set of which trace file every
/// figure draws. The numbers of figures are in the trace files, not here.

#include <string>

#include "reports/results.hpp"

namespace palpate {

/// Same data, same bytes. What varies from run to run stands only in "seconds", "timings",
/// "provenance" and in tables and figures marked "timing".
std::string to_json(const Results& results);

/// The reverse; figures come without their numbers (figure_data.hpp adds them). `name` is used in
/// messages. Throws InputError.
Results results_from_json(const std::string& text, const std::string& name);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// results.xml: JUnit as CI servers read it, with every quantity as a property of its case.

#include <string>

#include "reports/results.hpp"

namespace palpate {

std::string to_junit(const Results& results);

}  // namespace palpate

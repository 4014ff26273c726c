// SPDX-License-Identifier: MIT

#include "reports/cli/tolerance_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/problems.hpp"
#include "model/problem/input_error.hpp"
#include "reports/html/html_page.hpp"
#include "validation/comparison/comparison.hpp"

namespace palpate {

using namespace comparison;

namespace {

struct WrittenUnit {
  std::string_view name;
  std::string_view si;
  double factor;
};
constexpr std::array written_units{WrittenUnit{"mmHg", "Pa", pascals_per_mmhg},
                                   WrittenUnit{"kPa", "Pa", 1e3},
                                   WrittenUnit{"Pa", "Pa", 1.0},
                                   WrittenUnit{"mmHg/s", "Pa/s", pascals_per_mmhg},
                                   WrittenUnit{"kPa/s", "Pa/s", 1e3},
                                   WrittenUnit{"Pa/s", "Pa/s", 1.0},
                                   WrittenUnit{"N", "N", 1.0},
                                   WrittenUnit{"N/s", "N/s", 1.0},
                                   WrittenUnit{"ms", "s", 1e-3},
                                   WrittenUnit{"s", "s", 1.0},
                                   WrittenUnit{"mm", "m", 1e-3},
                                   WrittenUnit{"m", "m", 1.0}};

constexpr const char* allowed_forms =
    "must be such as peak=15%, plateau=7mmHg, slope_before=30%+5mmHg/s or drop_time=x2";

Feature feature_named(const std::string& name, const std::string& text) {
  if (name == comparison::name_of(Feature::loss_of_resistance)) {
    throw InputError("--tolerance " + text + ": " + name + " is found or not, which has no width");
  }
  std::vector<std::string_view> known;
  for (std::size_t n = 1; n < feature_count; ++n) {
    known.push_back(comparison::name_of(static_cast<Feature>(n)));
    if (known.back() == name) { return static_cast<Feature>(n); }
  }
  const std::string_view nearest = io::nearest_word(name, known);
  throw InputError(
      "--tolerance " + text + ": no feature with a width is called \"" + name + "\"; " +
      (nearest.empty() ? std::string(allowed_forms) : "did you mean " + std::string(nearest)));
}

/// Splits a text into a number and the unit after it.
struct Written {
  double number = 0.0;
  std::string unit{};
};

Written split(const std::string& part, const std::string& text) {
  const std::size_t end = part.find_first_not_of("0123456789.eE-+");
  Written written{.unit = end == std::string::npos ? "" : part.substr(end)};
  const bool number = io::parse_number(part.substr(0, end), written.number);
  if (!number || !std::isfinite(written.number) || written.number < 0.0) {
    throw InputError("--tolerance " + text + ": \"" + part + "\"; " + allowed_forms);
  }
  return written;
}

void add_width(const Written& written, const std::string& text, QuantityKind quantity,
               Tolerance& tolerance) {
  if (written.unit == "%") {
    tolerance.relative += 0.01 * written.number;
    return;
  }
  const std::string si = comparison::unit_of(tolerance.feature, unit_of(quantity));
  const auto unit = std::ranges::find_if(written_units, [&](const WrittenUnit& one) {
    return one.name == written.unit && one.si == si;
  });
  const bool bare = written.unit.empty() && si == "1";
  if (!bare && unit == written_units.end()) {
    throw InputError("--tolerance " + text + ": unit \"" + written.unit +
                     "\"; must be % or a unit of " + si);
  }
  tolerance.absolute += written.number * (bare ? 1.0 : unit->factor);
}

}  // namespace

Tolerance tolerance_from(const std::string& text, QuantityKind quantity) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals + 1 == text.size()) {
    throw InputError("--tolerance " + text + "; " + allowed_forms);
  }
  Tolerance tolerance{.feature = feature_named(text.substr(0, equals), text),
                      .origin = "the command line"};
  std::string rest = text.substr(equals + 1);
  if (rest.front() == 'x') {
    tolerance.factor = split(rest.substr(1), text).number;
    if (tolerance.factor > 1.0 && split(rest.substr(1), text).unit.empty()) { return tolerance; }
    throw InputError("--tolerance " + text + "; a factor must be a number > 1");
  }
  while (!rest.empty()) {
    const std::size_t plus = std::min(rest.find('+'), rest.size());
    add_width(split(rest.substr(0, plus), text), text, quantity, tolerance);
    rest.erase(0, std::min(plus + 1, rest.size()));
  }
  return tolerance;
}

std::string tolerance_help(QuantityKind quantity) {
  std::string help;
  for (const Tolerance& one : default_tolerances(quantity)) {
    if (one.feature == Feature::loss_of_resistance) { continue; }
    const FieldUnit field = field_unit(comparison::unit_of(one.feature, unit_of(quantity)));
    std::string value = one.factor > 1.0 ? "x" + plain_number(one.factor) : "";
    if (one.relative > 0.0) { value = plain_number(100.0 * one.relative, 3) + "%"; }
    if (one.absolute > 0.0) {
      value += (value.empty() ? "" : "+") + plain_number(field.factor * one.absolute, 3) +
               (field.name == "1" ? "" : field.name);
    }
    help += "  " + std::string(comparison::name_of(one.feature)) + "=" + value + "\n";
  }
  return help;
}

}  // namespace palpate

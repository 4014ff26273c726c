// SPDX-License-Identifier: MIT

#include "validation/number_text.hpp"

#include <cstdlib>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("a short number has few digits, a typographic minus and no letter") {
  CHECK(short_number(0.00123449) == "0.001234");
  CHECK((short_number(-1.2345e-7) == "−1.234\u202f×\u202f10⁻⁷" ||
         short_number(-1.2345e-7) == "−1.235\u202f×\u202f10⁻⁷"));
  CHECK(short_number(1e-9) == "10⁻⁹");
  CHECK(short_number(125000.0) == "125\u202f000");
  CHECK(short_number(2400.0) == "2400");
  CHECK(short_number(48163.2) == "48\u202f160");
  CHECK(short_number(1234.5, 2) == "1200");
  CHECK(short_number(99.96, 2) == "100");
  CHECK(short_number(-463.7) == "−463.7");
  CHECK(short_number(1.5e6) == "1.5\u202f×\u202f10⁶");
  CHECK(short_number(std::nan("")) == "not a number");
  CHECK(short_number(-INFINITY) == "−∞");
}

TEST("an exact number reads back as the same double; others have distinguishing digits") {
  for (const double value : {0.1, 1.0 / 3.0, 5e-324, 1.7976931348623157e308, -0.0}) {
    CHECK(std::strtod(exact_number(value).c_str(), nullptr) == value);
  }
  CHECK(digits_apart(1.0, 2.0) == 4);
  CHECK(digits_apart(1.0, 1.000001) == 7);
  CHECK(digits_apart(1.0, 1.0) == 4);
  CHECK(digits_apart(1.0, std::nextafter(1.0, 2.0)) == 17);
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT
#include "reports/field_units.hpp"

#include "tests/check.hpp"

using namespace palpate;

namespace {

Figure with_y(const std::string& label, double largest) {
  return {.x = {.label = "time (s)"},
          .y = {.label = label},
          .series = {{.x = {0.0, 1.0}, .y = {0.0, largest}}}};
}

}  // namespace

TEST("a displacement of a millimetre is drawn in millimetres and means the same") {
  const Figure figure = in_field_units(with_y("displacement (m)", 9e-4));
  CHECK(figure.y.label == "displacement (mm)");
  CHECK_NEAR(figure.series[0].y[1], 0.9, 1e-15);  // one rounding
  CHECK(figure.x.label == "time (s)" && figure.series[0].x[1] == 1.0);
}

TEST("each size has its prefix, and unknown or logarithmic axes have none") {
  CHECK(in_field_units(with_y("p (Pa)", 2.5e4)).y.label == "p (kPa)");
  CHECK(in_field_units(with_y("p (Pa)", 2.5e3)).y.label == "p (Pa)");
  CHECK(in_field_units(with_y("f (N)", 3e-7)).y.label == "f (µN)");
  CHECK(in_field_units(with_y("t (s)", 1e5)).y.label == "t (s)");
  CHECK(in_field_units(with_y("n (1)", 1e-5)).y.label == "n (1)");
  CHECK(in_field_units(with_y("x", 1e-5)).y.label == "x");
  Figure logarithmic = with_y("e (m)", 1e-5);
  logarithmic.y.logarithmic = true;
  CHECK(in_field_units(logarithmic).y.label == "e (m)");
}

TEST("equal scales stay equal") {
  Figure figure{.x = {.label = "x (m)"},
                .y = {.label = "z (m)"},
                .series = {{.x = {0.0, 0.005}, .y = {0.0, 5e-6}}},
                .square = true};
  figure = in_field_units(figure);
  CHECK(figure.x.label == "x (mm)" && figure.y.label == "z (mm)");
}

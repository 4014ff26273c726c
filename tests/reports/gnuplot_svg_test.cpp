// SPDX-License-Identifier: MIT
#include "reports/gnuplot_svg.hpp"

#include "reports/svg_path.hpp"
#include "tests/check.hpp"

using namespace palpate;

TEST("a path keeps its points to a tenth, without drift") {
  SvgPath path;
  path.append("M10.00,20.00 L10.04,30.00 L10.08,40.00 L10.12,50.00 L11.12,50.00 ");
  CHECK(path.data() == "M10 20v10l.1 10v10h1");
  SvgPath gap;
  gap.append("M0.00,0.00 L1.00,-0.50 M3.00,3.00 L4.00,4.00 Z");
  CHECK(gap.data() == "M0 0l1-.5M3 3l1 1z");
}

TEST("strokes of one kind become one path, and series stay apart and in order") {
  const std::string svg = svg_for_page(
      "<svg viewBox=\"0 0 9 9\"><title>t</title><defs><path id='x' d='M1,1'/></defs>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   2)' d='M0,0 L1,0 '/></g>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   1)' d='M0,0 L2,0 '/></g>"
      "<g stroke-width=\"0.80\"><path stroke='rgb(  1,   2,   2)' d='M0,1 L1,1 '/></g>"
      "<g id=\"plot_plot_1\" ><title>s</title><g stroke-width=\"1.80\">"
      "<path stroke='rgb(  1,   2,  16)' d='M0,0 L3,0 '/></g></g></svg>",
      "label");
  CHECK(svg ==
        "<svg role=\"img\" viewBox=\"0 0 9 9\" aria-label=\"label\">"
        "<path class=\"l g\" stroke-width=\".8\" d=\"M0 0h1M0 1h1\"/>"
        "<path class=\"l k\" stroke-width=\".8\" d=\"M0 0h2\"/>"
        "<path class=\"l s0\" stroke-width=\"1.8\" d=\"M0 0h3\"/></svg>");
}

TEST("an exponent stays one, and a small tick label becomes one") {
  const auto text = [](const std::string& inner) {
    return svg_for_page(
        "<svg viewBox=\"0 0 9 9\"><g transform=\"translate(3.00,4.00)\" "
        "text-anchor=\"end\"><text>" +
            inner + "</text></g></svg>",
        "");
  };
  CHECK(text("<tspan font-family=\"sans-serif\" >10</tspan><tspan font-size=\"11.2\" "
             "dy=\"-7.00px\">−2</tspan>"
             "<tspan font-size=\"14.0\" dy=\"7.00\"></tspan>")
            .find("<text x=\"3\" y=\"4\" text-anchor=\"end\">10<tspan class=\"up\" "
                  "dy=\"-5\">−2</tspan></text>") != std::string::npos);
  CHECK(text("<tspan> −5e−05</tspan>")
            .find(">−5·10<tspan class=\"up\" dy=\"-5\">−5</tspan></text>") != std::string::npos);
}

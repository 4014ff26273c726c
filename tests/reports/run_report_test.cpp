// SPDX-License-Identifier: MIT
#include "reports/run_report.hpp"

#include <cmath>

#include "reports/trace_figures.hpp"
#include "tests/check.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

Trace moving_block() {
  Trace trace{.time = {0.0, 0.1, 0.2}};
  trace.columns = {{"tip</script>.x_m", "m", {1.0, 1.1, std::nan("")}},
                   {"tip</script>.y_m", "m", {0.0, 0.0, 0.0}},
                   {"tip</script>.fx_n", "N", {0.0, 1.0, 2.0}}};
  trace.events = {{0.1, "puncture", "skin <1>"}};
  NodeVectors rest(3, 27);
  for (int i = 0; i < 27; ++i) {
    rest.col(i) << 0.01 * (i % 3), 0.01 * (i / 3 % 3), 0.01 * (i / 9);
  }
  NodeVectors moved = rest;
  moved(2, 13) += 1e-4;
  trace.frame_time = {0.0, 0.2};
  trace.frames = {rest, moved};
  return trace;
}

}  // namespace

TEST("columns of one record and unit share a figure, and positions start at zero") {
  const std::vector<Figure> figures = figures_over_time(moving_block());
  CHECK(figures.size() == 2);
  CHECK(figures[0].series.size() == 2 && figures[0].series[0].y[0] == 0.0);
  CHECK_NEAR(figures[0].series[0].y[1], 0.1, 1e-15);  // rounding of a difference near one
  CHECK(figures[0].series[1].label == "y" && figures[1].series[0].label == "fx");
}

TEST("the snapshot shows the slice of the node that moved furthest, and says how much larger") {
  const auto figure = snapshot_figure(moving_block());
  CHECK(figure && figure->series.size() == 2 && figure->series[0].x.size() == 9);
  CHECK(figure && contains(figure->caption, "0.1 mm") &&
        contains(figure->caption, "10 times larger"));
  CHECK(figure && *figure->y.minimum > *figure->y.maximum);
}

TEST("a trace that never moved, or was cut short, has no snapshot and still a page") {
  Trace trace = moving_block();
  trace.frames[1] = trace.frames[0];
  CHECK(!snapshot_figure(trace));
  CHECK(contains(to_html(RunReport{.title = "empty"}, Trace{}), "empty"));
  trace.frames[1](0, 0) = std::nan("");
  CHECK(!snapshot_figure(trace));
}

TEST("the page makes no request, escapes what it shows and gives the same bytes twice") {
  const RunReport report{.title = "<run>",
                         .held = false,
                         .verdict = "Diverged at 0.1 s",
                         .facts = {{"nodes", "27", "<all>"}},
                         .skipped = {"no <needle>"},
                         .warnings = {"a </script> b"}};
  const std::string html = to_html(report, moving_block());
  for (const char* request :
       {"src=\"http", "href=\"http", "url(http", "@import", "sourceMappingURL", "<run>", "<all>",
        "<needle>", "tip</script>", "skin <1>"}) {
    CHECK(!contains(html, request));
  }
  CHECK(contains(html, "class=\"verdict fail\"") && contains(html, "new Dygraph"));
  CHECK(html == to_html(report, moving_block()));
}

// SPDX-License-Identifier: MIT
#include "reports/view_page.hpp"

#include <nlohmann/json.hpp>

#include "reports/view_encoding.hpp"
#include "reports/view_still.hpp"
#include "tests/check.hpp"
#include "tests/reports/view_sample.hpp"

using namespace palpate;

namespace {

std::size_t count_of(const std::string& text, std::string_view part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) { ++count; }
  return count;
}

}  // namespace

TEST("ten thousand nodes with their springs at sixty instants stay below 5 MB, library and pictures included") {
  const ViewSample sample = pressed_block({20, 20, 25}, 60);
  const auto view = sample.view();
  CHECK(view->rest.cols() == 10'000 && view->frames.size() == 60 && view->springs.size() > 100'000);
  CHECK(html_view(*view).size() + view_script().size() < 5'000'000);
}

TEST("where numbers are too many they get coarser and then fewer, and the page says so") {
  const auto view = pressed_block({8, 8, 8}, 40).view();
  const EncodedView whole = encode(*view);
  CHECK(whole.notes.empty());
  const EncodedView coarser = encode(*view, whole.numbers.size() * 9 / 10);
  CHECK(coarser.notes.size() == 1 && coarser.numbers.size() <= whole.numbers.size() * 9 / 10);
  const EncodedView fewer = encode(*view, whole.numbers.size() / 3);
  CHECK(fewer.notes.size() == 1 && fewer.notes[0].find("of 40 instants") != std::string::npos);
  const auto header = nlohmann::json::parse(fewer.header);
  CHECK(header["frames"].size() < 40 &&
        header["frames"][header["peak"].get<std::size_t>()]["reaction"] == view->frames[view->peak].reaction);
}

TEST("nothing in the page asks the network or ends a script") {
  ViewSample sample = pressed_block({3, 3, 3}, 2);
  sample.scene.tissue.lattice.material = "a </script><b>";
  const std::string html = html_view(*sample.view());
  for (const char* request : {"src=", "url(", "@import", "a </script>", "<b>a"}) {
    CHECK(html.find(request) == std::string::npos);
  }
  CHECK(html == html_view(*sample.view()));
}

TEST("a still picture paints what can be seen of the half behind the cut, and its key") {
  const auto view = pressed_block({6, 7, 5}, 3).view();
  const std::string rest = still_at_rest(*view);
  // Cells: 5 x 6 x 4, of which the 5 x 3 x 4 behind y = 0 are kept; sides towards +x, +y and -z are seen.
  const std::size_t sides = 3 * 4 + 5 * 4 + 5 * 3;
  CHECK(count_of(rest, "<path") == sides + 1);
  const std::string moved = still_at(*view, 2, 10.0);
  CHECK(count_of(moved, "<path") == sides + 40 && moved.find("nan") == std::string::npos);
  CHECK(moved.find("displacement") != std::string::npos);
}

TEST("of very many sides a still picture paints squares as one, and leaves none out") {
  const auto view = pressed_block({151, 121, 3}, 1).view();
  const std::string rest = still_at_rest(*view);
  // The upper sides of 150 x 60 cells behind y = 0 and two rows each of front and flank, as squares of 2 x 2.
  CHECK(count_of(rest, "<path") == (150 * 60 + 150 * 2 + 60 * 2) / 4 + 1);
}

// SPDX-License-Identifier: MIT
#include "reports/markup.hpp"

#include "tests/check.hpp"

using namespace palpate;

TEST("text cannot leave the place it is put into") {
  CHECK(escape_markup("<a b='c' d=\"e\"> & \x01") ==
        "&lt;a b=&#39;c&#39; d=&quot;e&quot;&gt; &amp; ?");
  CHECK(escape_markup("µ ω 10⁻³") == "µ ω 10⁻³");
  CHECK(escape_markup("a\xff\xc3") == "a\ufffd\ufffd");
}

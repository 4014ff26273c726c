// SPDX-License-Identifier: MIT
#include "reports/packed_bytes.hpp"

#include <array>
#include <zlib.h>

#include "tests/check.hpp"

using namespace palpate;

namespace {

std::vector<std::uint8_t> inflated(const std::string& packed) {
  std::vector<std::uint8_t> bytes(1U << 20U);
  uLongf size = bytes.size();
  const int code = uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size());
  bytes.resize(code == Z_OK ? size : 0);
  return bytes;
}

}  // namespace

TEST("base64 is that of RFC 4648, section 10") {
  const std::array<std::pair<const char*, const char*>, 7> vectors{{{"", ""},
                                                                    {"f", "Zg=="},
                                                                    {"fo", "Zm8="},
                                                                    {"foo", "Zm9v"},
                                                                    {"foob", "Zm9vYg=="},
                                                                    {"fooba", "Zm9vYmE="},
                                                                    {"foobar", "Zm9vYmFy"}}};
  for (const auto& [plain, coded] : vectors) { CHECK(base64(plain) == coded); }
  CHECK(base64(std::string("\xff\xfe\x00", 3)) == "//4A");
}

TEST("what is deflated comes back") {
  std::string text;
  for (int n = 0; n < 5000; ++n) { text += static_cast<char>(n * n % 251); }
  const std::vector<std::uint8_t> back = inflated(deflate(text));
  CHECK(std::string(back.begin(), back.end()) == text);
}

TEST("differences lie in planes of bytes, the lowest first, and may be negative") {
  PackedBytes packed;
  packed.add_differences(std::array<std::int64_t, 3>{258, 257, 600}, 16);
  packed.add_differences(std::array<std::int64_t, 1>{0x01020304}, 32);
  packed.add_changes(std::array<std::int16_t, 2>{-3, 5}, std::array<std::int16_t, 2>{-1, -300});
  packed.add_bytes(std::array<std::uint8_t, 1>{9});
  const std::vector<std::uint8_t> expected{2, 255, 87, 1, 255, 1, 4, 3, 2, 1, 254, 49, 255, 1, 9};
  CHECK(inflated(packed.deflated()) == expected);
}

// SPDX-License-Identifier: MIT

#include "reports/live/frame_codec.hpp"

#include <limits>

#include "tests/check.hpp"
#include "validation/random.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::live;

std::vector<std::int16_t> random_values(Random& random, std::size_t count, double zeros) {
  std::vector<std::int16_t> values(count);
  for (std::int16_t& value : values) {
    const bool is_zero = random(0.0, 1.0) < zeros;
    value = is_zero ? std::int16_t{0} : static_cast<std::int16_t>(random(-32767.0, 32767.0));
  }
  return values;
}

TEST("changes added to the values before give the values after, whatever they are") {
  Random random(1);
  for (const double zeros : {0.0, 0.5, 0.99, 1.0}) {
    for (const std::size_t count : {0U, 1U, 2U, 300U, 3000U}) {
      std::vector<std::int16_t> shown = random_values(random, count, zeros);
      const std::vector<std::int16_t> after = random_values(random, count, zeros);
      std::string bytes;
      append_changes(after, shown, bytes);
      CHECK(add_changes(bytes, shown));
      CHECK(shown == after);
    }
  }
}

TEST("the largest changes of 16 bits survive in both directions") {
  std::vector<std::int16_t> shown{-32767, 32767, 0};
  const std::vector<std::int16_t> after{32767, -32767, 0};
  std::string bytes;
  append_changes(after, shown, bytes);
  CHECK(add_changes(bytes, shown));
  CHECK(shown == after);
}

TEST("a keyframe gives the values from zeros, and a frame at rest takes a few bytes") {
  Random random(2);
  const std::vector<std::int16_t> values = random_values(random, 3000, 0.2);
  std::vector<std::int16_t> shown(values.size(), 0);
  std::string keyframe;
  append_changes(values, {}, keyframe);
  CHECK(add_changes(keyframe, shown));
  CHECK(shown == values);
  std::string rest;
  append_changes(values, values, rest);
  CHECK(rest.size() == 3);  // one zero, and 2999 further ones in two bytes of 7 bits
}

TEST("bytes of another length than the values are refused") {
  const std::vector<std::int16_t> values{1, 2, 3};
  std::string bytes;
  append_changes(values, {}, bytes);
  std::vector<std::int16_t> shorter(2), longer(4);
  CHECK(!add_changes(bytes, shorter));
  CHECK(!add_changes(bytes, longer));
  std::vector<std::int16_t> right(3);
  CHECK(!add_changes(bytes.substr(0, 2), right));
  const std::string long_run{'\0', '\x05'};  // six zeros
  CHECK(!add_changes(long_run, right));
  const std::string cut_number{'\x81'};
  CHECK(!add_changes(cut_number, right));
}

TEST("a quantised displacement is within half a step, and is clamped beyond the range") {
  NodeVectors rest = NodeVectors::Zero(3, 3);
  const Quantiser quantiser({0, 2}, rest, 0.1);
  NodeVectors moved = rest;
  moved.col(0) << 0.0123, -0.1, 0.2;
  moved.col(2) << std::numeric_limits<double>::quiet_NaN(), -5.0, 1e-7;
  std::vector<std::int16_t> values;
  quantiser.quantise(moved, values);
  REQUIRE(values.size() == 6);
  CHECK_NEAR(quantiser.step() * values[0], 0.0123, 0.5 * quantiser.step());
  CHECK(values[1] == -32767);
  CHECK(values[2] == 32767);
  CHECK(values[3] == 0);
  CHECK(values[4] == -32767);
  CHECK(values[5] == 0);
}

TEST("a checksum changes with every bit, with the order and with the begin") {
  const std::vector<double> numbers{1.0, 2.0, -3.5, 0.0};
  const std::uint64_t sum = checksum(numbers);
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    for (unsigned bit = 0; bit < 64; ++bit) {
      std::vector<double> other = numbers;
      other[n] = std::bit_cast<double>(std::bit_cast<std::uint64_t>(other[n]) ^ (1ULL << bit));
      CHECK(checksum(other) != sum);
    }
  }
  CHECK(checksum(std::vector<double>{2.0, 1.0, -3.5, 0.0}) != sum);
  CHECK(checksum(numbers, 1) != sum);
}

}  // namespace PALPATE_FILE

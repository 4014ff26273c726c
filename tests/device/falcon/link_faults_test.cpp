// SPDX-License-Identifier: MIT

#include "device/falcon/link_faults.hpp"

#include "tests/check.hpp"

namespace PALPATE_FILE {

using palpate::device::Seeded;

TEST("normal numbers have mean 0, variance 1 and the tails of twelve uniform ones") {
  constexpr double count = 100000;
  Seeded seeded(1);
  double sum = 0.0, squares = 0.0, fourths = 0.0, largest = 0.0;
  for (int n = 0; n < int(count); ++n) {
    const double x = seeded.normal();
    sum += x;
    squares += x * x;
    fourths += x * x * x * x;
    largest = std::fmax(largest, std::abs(x));
  }
  // Four standard errors: 1 of the mean, sqrt(1.9) of the square, below sqrt(96) of the fourth
  // power.
  const double error = 4.0 / std::sqrt(count);
  CHECK_NEAR(sum / count, 0.0, error);
  CHECK_NEAR(squares / count, 1.0, std::sqrt(1.9) * error);
  CHECK_NEAR(fourths / count, 2.9, std::sqrt(96.0) * error);  // 3 less 1.2 / 12 (Irwin-Hall)
  CHECK(largest < 6.0);
  CHECK(largest > 3.0);
}

TEST("a seed gives the same numbers, another one others") {
  const double first = Seeded(7).uniform(-2.0, 3.0);
  CHECK(first == Seeded(7).uniform(-2.0, 3.0));
  CHECK(first != Seeded(8).uniform(-2.0, 3.0));
  CHECK(first >= -2.0);
  CHECK(first < 3.0);
}

using namespace palpate::device::falcon;
using Kind = LinkFault::Kind;
using Direction = LinkFault::Direction;

constexpr int bytes_sent = 100000;

struct Heard {
  std::vector<std::uint8_t> bytes{};
  std::vector<double> times{};
  FaultCounts counts{};
  bool operator==(const Heard&) const = default;
};

/// Sends bytes 0, 1, 2 ... in writes of ten, one per millisecond, and reads every 0.1 ms.
Heard heard(const FaultScript& script, Direction direction = Direction::to_device) {
  FaultChannel channel(script, direction);
  Heard result;
  std::array<std::uint8_t, 64> buffer{};
  std::uint8_t next = 0;
  for (int n = 0; n < bytes_sent + 1000; ++n) {
    const double now = 1e-4 * n;
    if (n % 10 == 0 && n < bytes_sent) {
      std::array<std::uint8_t, 10> write{};
      for (std::uint8_t& byte : write) { byte = next++; }
      channel.send(write, now);
    }
    const std::size_t count = channel.receive(buffer, now);
    for (std::size_t i = 0; i < count; ++i) {
      result.bytes.push_back(buffer[i]);
      result.times.push_back(now);
    }
  }
  result.counts = channel.counts();
  return result;
}

/// Five standard deviations of a count of hits.
double spread(double probability) {
  return 5.0 * std::sqrt(bytes_sent * probability * (1.0 - probability));
}

FaultScript everything(std::uint64_t seed) {
  return {.seed = seed,
          .faults = {{.kind = Kind::drop, .probability = 0.02},
                     {.kind = Kind::duplicate, .probability = 0.03},
                     {.kind = Kind::corrupt, .probability = 0.01},
                     {.kind = Kind::latency, .probability = 0.3, .latency = 2e-3, .jitter = 3e-3},
                     {.kind = Kind::unplug, .start = 1.0, .end = 1.2}}};
}

/// Checks that all bytes arrive in order, with delays that fill the range from `least` to `most`
/// [s]. A range of zero must hold exactly.
void check_delays(const Heard& result, double least, double most) {
  REQUIRE(result.bytes.size() == bytes_sent);
  std::vector<double> delays;
  bool in_order = true;
  for (std::size_t n = 0; n < result.bytes.size(); ++n) {
    delays.push_back(result.times[n] - 1e-4 * static_cast<double>(n / 10 * 10));
    in_order = in_order && result.bytes[n] == static_cast<std::uint8_t>(n);
  }
  CHECK(in_order);
  const auto [shortest, longest] = std::ranges::minmax(delays);
  if (most == 0.0) {
    CHECK(shortest == 0.0);
    CHECK(longest == 0.0);
    return;
  }
  CHECK(shortest >= least - 1e-9);
  CHECK(shortest <= least + 0.5e-3);
  CHECK(longest <= most);
  CHECK(longest >= most - 0.6e-3);
}

TEST(
    "latency and jitter stay within their range and never change the order; without them is none") {
  const Heard clean = heard({});
  check_delays(clean, 0.0, 0.0);
  const Heard late = heard({.faults = {{.kind = Kind::latency, .latency = 5e-3, .jitter = 4e-3}}});
  check_delays(late, 5e-3, 9e-3 + 1e-4);  // read each 0.1 ms
}

TEST("one seed gives the same faults each time, another seed others") {
  CHECK(heard(everything(5)) == heard(everything(5)));
  CHECK(heard(everything(5)) != heard(everything(6)));
  CHECK(heard(everything(5)) != heard(everything(5), Direction::to_host));
}

TEST("the random numbers are those of the standard's generator, on every machine") {
  // The 10000th number of a default std::mt19937_64 is fixed by the C++ standard.
  palpate::device::Seeded random(std::mt19937_64::default_seed);
  for (int n = 0; n < 9999; ++n) { random.uniform(); }
  CHECK(random.uniform() == static_cast<double>(9981545732273789042ULL >> 11U) * 0x1p-53);
}

TEST("each kind hits the share of bytes that it was given") {
  for (const double probability : {0.01, 0.3}) {
    const auto counts = [&](Kind kind) {
      return heard({.faults = {{.kind = kind, .probability = probability}}});
    };
    const Heard dropped = counts(Kind::drop);
    CHECK_NEAR(double(dropped.counts.dropped), probability * bytes_sent, spread(probability));
    CHECK(static_cast<std::int64_t>(dropped.bytes.size()) == bytes_sent - dropped.counts.dropped);
    const Heard doubled = counts(Kind::duplicate);
    CHECK_NEAR(double(doubled.counts.duplicated), probability * bytes_sent, spread(probability));
    CHECK(static_cast<std::int64_t>(doubled.bytes.size()) ==
          bytes_sent + doubled.counts.duplicated);
    const Heard changed = counts(Kind::corrupt);
    std::int64_t different = 0;
    for (std::size_t n = 0; n < changed.bytes.size(); ++n) {
      different += changed.bytes[n] != static_cast<std::uint8_t>(n) ? 1 : 0;
    }
    CHECK_NEAR(double(different), probability * bytes_sent, spread(probability));
    CHECK(different == changed.counts.corrupted);  // a corrupted byte is never the same by chance
  }
}

TEST("a fault acts in its window, in its direction and nowhere else") {
  const FaultScript script{
      .faults = {
          {.kind = Kind::drop, .direction = Direction::to_device, .start = 2.0, .end = 2.5}}};
  // Writes at each millisecond from 2.000 to 2.499 s, ten bytes each.
  CHECK(heard(script).counts.dropped == 5000);
  CHECK(heard(script, Direction::to_host).counts.dropped == 0);
}

TEST("one fault's window does not shift what another does") {
  const LinkFault drop{.kind = Kind::drop, .probability = 0.05};
  const FaultScript early{.faults = {drop, {.kind = Kind::corrupt, .start = 0.0, .end = 1.0}}};
  const FaultScript late{.faults = {drop, {.kind = Kind::corrupt, .start = 5.0, .end = 6.0}}};
  CHECK(heard(early).times == heard(late).times);
}

TEST("whether a window happens is drawn from the seed, alike for both directions") {
  int happened = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const FaultScript script{
        .seed = seed,
        .faults = {{.kind = Kind::unplug, .probability = 0.25, .start = 0.0, .end = 1.0}}};
    const auto lost = [&](Direction direction) {
      FaultChannel channel(script, direction);
      channel.send(std::array<std::uint8_t, 1>{1}, 0.5);
      return channel.counts().unplugged == 1;
    };
    CHECK(lost(Direction::to_device) == lost(Direction::to_host));
    happened += lost(Direction::to_device) ? 1 : 0;
  }
  CHECK_NEAR(happened, 100.0, 5.0 * std::sqrt(400 * 0.25 * 0.75));
}

TEST("bytes that do not fit in the channel are counted as lost") {
  FaultChannel channel({.faults = {{.kind = Kind::latency, .latency = 1.0}}}, Direction::to_host);
  const std::vector<std::uint8_t> many(10000, 7);
  channel.send(many, 0.0);
  std::vector<std::uint8_t> into(20000);
  CHECK(channel.receive(into, 0.999) == 0);
  const std::size_t arrived = channel.receive(into, 1.0);
  CHECK(static_cast<std::int64_t>(arrived) + channel.counts().overflowed == 10000);
  CHECK(channel.counts().overflowed > 0);
}

}  // namespace PALPATE_FILE

// SPDX-License-Identifier: MIT

#include "device/pressure_link/frame.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::device::pressure_link {
namespace {

constexpr std::size_t checked_begin = 2;
constexpr std::size_t checked_bytes = 4;
constexpr unsigned over_range_bit = 1U;
constexpr unsigned battery_low_bit = 2U;

std::uint8_t low(unsigned value) noexcept { return static_cast<std::uint8_t>(value & 0xFFU); }
std::uint8_t high(unsigned value) noexcept { return low(value >> 8U); }

constexpr int sequence_numbers = 256;

}  // namespace

std::uint16_t checksum(std::span<const std::uint8_t> bytes) noexcept {
  constexpr unsigned polynomial = 0x1021;
  constexpr unsigned top = 0x8000;
  unsigned rest = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    rest ^= unsigned{byte} << 8U;
    for (int bit = 0; bit < 8; ++bit) {
      rest = ((rest & top) != 0 ? (rest << 1U) ^ polynomial : rest << 1U) & 0xFFFFU;
    }
  }
  return static_cast<std::uint16_t>(rest);
}

FrameBytes encode(const Frame& frame) noexcept {
  const unsigned status =
      (frame.over_range ? over_range_bit : 0U) | (frame.battery_low ? battery_low_bit : 0U);
  const auto pressure = static_cast<std::uint16_t>(frame.pressure);
  FrameBytes bytes{frame_begin[0],
                   frame_begin[1],
                   frame.sequence,
                   low(status),
                   low(pressure),
                   high(pressure),
                   0,
                   0};
  const std::uint16_t sum = checksum(std::span(bytes).subspan(checked_begin, checked_bytes));
  bytes[6] = low(sum);
  bytes[7] = high(sum);
  return bytes;
}

std::optional<Frame> decode(std::span<const std::uint8_t, frame_bytes> bytes) noexcept {
  if (!std::ranges::equal(bytes.first<2>(), frame_begin)) { return std::nullopt; }
  const std::uint16_t sum = checksum(bytes.subspan<checked_begin, checked_bytes>());
  if (bytes[6] != low(sum) || bytes[7] != high(sum)) { return std::nullopt; }
  const unsigned pressure = bytes[4] | (unsigned{bytes[5]} << 8U);
  return Frame{.sequence = bytes[2],
               .over_range = (bytes[3] & over_range_bit) != 0,
               .battery_low = (bytes[3] & battery_low_bit) != 0,
               .pressure = static_cast<std::int16_t>(static_cast<std::uint16_t>(pressure))};
}

bool FrameReader::may_begin_frame() const noexcept {
  return bytes_[0] == frame_begin[0] && (filled_ < 2 || bytes_[1] == frame_begin[1]);
}

void FrameReader::skip_one() noexcept {
  std::copy(bytes_.begin() + 1, bytes_.begin() + static_cast<std::ptrdiff_t>(filled_),
            bytes_.begin());
  --filled_;
  ++counts_.skipped_bytes;
  skipping_ = true;
}

void FrameReader::skip_to_beginning() noexcept {
  while (filled_ > 0 && !may_begin_frame()) { skip_one(); }
}

void FrameReader::end_skipping() noexcept {
  if (skipping_ && !began_) { ++counts_.bad_frames; }
  skipping_ = false;
  began_ = false;
}

std::optional<ReceivedFrame> FrameReader::take(std::uint8_t byte) noexcept {
  bytes_[filled_++] = byte;
  skip_to_beginning();
  if (filled_ < frame_bytes) { return std::nullopt; }
  if (const std::optional<Frame> frame = decode(bytes_)) {
    filled_ = 0;
    end_skipping();
    return accept(*frame);
  }
  ++counts_.bad_frames;
  began_ = true;
  skip_one();
  skip_to_beginning();
  return std::nullopt;
}

void FrameReader::finish() noexcept {
  while (filled_ > 0) { skip_one(); }
  end_skipping();
}

std::optional<ReceivedFrame> FrameReader::accept(const Frame& frame) noexcept {
  if (last_ == frame) {
    ++counts_.repeated;
    return std::nullopt;
  }
  const int step = last_ ? static_cast<std::uint8_t>(frame.sequence - last_->sequence - 1) : 0;
  last_ = frame;
  ++counts_.frames;
  counts_.missing += step;
  counts_.gaps += step > 0 ? 1 : 0;
  counts_.over_range += frame.over_range ? 1 : 0;
  counts_.battery_low += frame.battery_low ? 1 : 0;
  return ReceivedFrame{.frame = frame, .missing_before = step};
}

std::int64_t frames_since(const ReceivedFrame& received, double elapsed_s) noexcept {
  const int least = received.missing_before + 1;
  const double wraps = std::round((elapsed_s * frames_per_second - least) / sequence_numbers);
  return least + sequence_numbers * static_cast<std::int64_t>(std::fmax(wraps, 0.0));
}

}  // namespace palpate::device::pressure_link

// SPDX-License-Identifier: MIT
#pragma once
/// Frames of the pipe between Palpate and a subject (palpate_subject.h): bytes in and out.

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "validation/subject/palpate_subject.h"

namespace palpate {

static_assert(std::endian::native == std::endian::little, "frames are written as they are");

struct FrameHeader {
  std::uint32_t length = 0;
  std::uint16_t call = 0;
  std::uint16_t status = 0;
  std::uint64_t sequence = 0;
};
static_assert(sizeof(FrameHeader) == 16);

/// Payloads above this size are refused: a state of 20 million nodes.
constexpr std::uint32_t most_payload = 1U << 30U;

/// Payload under construction, kept between frames so that it allocates once.
class FrameWriter {
 public:
  void clear() { bytes_.clear(); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void add(const T& value) {
    const auto* first = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void add(const double* values, std::size_t count) {
    const auto* first = reinterpret_cast<const char*>(values);
    bytes_.insert(bytes_.end(), first, first + count * sizeof(double));
  }
  void add_text(std::string_view text) {
    add(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  [[nodiscard]] const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_{};
};

/// Reader of a payload. Throws std::length_error beyond its end.
class FrameReader {
 public:
  explicit FrameReader(const std::vector<char>& bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_trivially_copyable_v<T> T take() {
    T value;
    std::memcpy(&value, next(sizeof(T)), sizeof(T));
    return value;
  }
  void take(double* values, std::size_t count) {
    if (count > 0) { std::memcpy(values, next(count * sizeof(double)), count * sizeof(double)); }
  }
  std::string take_text() {
    const auto size = take<std::uint32_t>();
    return {next(size), size};
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  const char* next(std::size_t size) {
    if (size > left()) { throw std::length_error("the frame is too short"); }
    const char* first = bytes_.data() + at_;
    at_ += size;
    return first;
  }
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

}  // namespace palpate

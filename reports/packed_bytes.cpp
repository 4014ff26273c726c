// SPDX-License-Identifier: MIT
#include "reports/packed_bytes.hpp"

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <stdexcept>
#include <zlib.h>

namespace palpate {

namespace {

void add_planes(std::vector<std::uint8_t>& bytes, std::span<const std::uint64_t> values, int bits) {
  for (int shift = 0; shift < bits; shift += 8) {
    for (const std::uint64_t value : values) { bytes.push_back(static_cast<std::uint8_t>(value >> shift)); }
  }
}

}  // namespace

void PackedBytes::add_bytes(std::span<const std::uint8_t> values) {
  bytes_.insert(bytes_.end(), values.begin(), values.end());
}

void PackedBytes::add_differences(std::span<const std::int64_t> values, int bits) {
  std::vector<std::uint64_t> differences;
  std::int64_t before = 0;
  for (const std::int64_t value : values) {
    differences.push_back(static_cast<std::uint64_t>(value - before));
    before = value;
  }
  add_planes(bytes_, differences, bits);
}

void PackedBytes::add_changes(std::span<const std::int16_t> values, std::span<const std::int16_t> before) {
  std::vector<std::uint64_t> differences;
  for (std::size_t n = 0; n < values.size(); ++n) {
    differences.push_back(static_cast<std::uint64_t>(std::int64_t{values[n]} - std::int64_t{before[n]}));
  }
  add_planes(bytes_, differences, 16);
}

std::string PackedBytes::deflated() const {
  return deflate({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()});
}

std::string deflate(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_DEFAULT_COMPRESSION);
  if (code != Z_OK) { throw std::runtime_error("zlib could not deflate: code " + std::to_string(code)); }
  packed.resize(size);
  return packed;
}

std::string base64(std::string_view bytes) {
  using namespace boost::archive::iterators;
  using Digits = base64_from_binary<transform_width<const char*, 6, 8>>;
  std::string text(Digits(bytes.data()), Digits(bytes.data() + bytes.size()));
  text.append((4 - text.size() % 4) % 4, '=');
  return text;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Conversion between frames of the raw pressure link and a Recording, in memory.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

struct LinkRecording {
  Recording recording{};  ///< only time, pressure, sample_rate and defects are set
  device::pressure_link::ReaderCounts counts{};
};

/// Converts bytes of the link to a recording. Time starts at 0 and advances by one frame period per
/// sequence number, including missing ones. A gap of more than 256 frames appears shorter by
/// multiples of 256 (frame_reader.hpp). Reading stops when more than `most_samples` samples are
/// found.
LinkRecording recording_of_link(std::span<const std::uint8_t> bytes, std::size_t most_samples);

/// Returns frame number `place` for a pressure [Pa]; absent if the pressure is not finite. Values
/// outside the range of the frame are clamped and marked as over range.
std::optional<device::pressure_link::Frame> frame_of(double pressure, std::size_t place);

/// Returns the frames of a transducer that measures the recorded pressure: one per frame period
/// from the first sample, interpolated linearly and rounded to 0.1 mmHg. No frame is sent within
/// gaps or next to samples that are not finite.
using LinkFrames = std::vector<std::optional<device::pressure_link::Frame>>;
LinkFrames link_frames(const Recording& recording);

/// Returns the concatenated bytes of the frames.
std::vector<std::uint8_t> link_bytes(const LinkFrames& frames);

}  // namespace palpate

// SPDX-License-Identifier: MIT
#pragma once
/// Between the raw pressure link and a Recording, in memory.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

struct LinkRecording {
  Recording recording{};  ///< time, pressure, sample_rate and defects alone
  device::pressure_link::ReaderCounts counts{};
};

/// Time goes on by one frame period for each sequence number, missing ones too; it begins at 0.
/// A gap of more than 256 frames looks shorter by multiples of 256 (frame_reader.hpp).
/// `most_samples` [1]: reading stops once one more than these was found.
LinkRecording recording_of_link(std::span<const std::uint8_t> bytes, std::size_t most_samples);

/// What the link sends of a pressure [Pa], as frame number `place`; nothing of what is no number.
/// What the frame cannot hold is its largest or smallest value and marked as over range.
std::optional<device::pressure_link::Frame> frame_of(double pressure, std::size_t place);

/// What a transducer sends that follows the pressure: one place per frame period from the first
/// sample on, interpolated linearly between samples and rounded to 0.1 mmHg. Nothing is sent within
/// gaps of the recording and next to samples without a number.
using LinkFrames = std::vector<std::optional<device::pressure_link::Frame>>;
LinkFrames link_frames(const Recording& recording);

/// The bytes of the frames, one after the other.
std::vector<std::uint8_t> link_bytes(const LinkFrames& frames);

}  // namespace palpate

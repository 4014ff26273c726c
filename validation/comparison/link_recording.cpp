// SPDX-License-Identifier: MIT

#include "validation/comparison/link_recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

namespace link = device::pressure_link;

constexpr double pascals_per_count = 0.1 * pascals_per_mmhg;

/// Tolerance for times rounded to microseconds, in frame periods: a closer sample is used without
/// interpolation.
constexpr double same_instant = 1e-3;

/// Returns the pressure at a time between two samples [Pa]; NaN in gaps.
double pressure_at(const Recording& recording, std::size_t after, double time, double longest) {
  const double begin = recording.time[after - 1];
  const double end = recording.time[after];
  const double share = (time - begin) / (end - begin);
  const double near = same_instant / (link::frames_per_second * (end - begin));
  if (share < near) { return recording.pressure[after - 1]; }
  if (share > 1.0 - near) { return recording.pressure[after]; }
  if (end - begin > longest) { return std::numeric_limits<double>::quiet_NaN(); }
  return std::lerp(recording.pressure[after - 1], recording.pressure[after], share);
}

}  // namespace

std::optional<link::Frame> frame_of(double pressure, std::size_t place) {
  if (!std::isfinite(pressure)) { return std::nullopt; }
  using Limits = std::numeric_limits<std::int16_t>;
  const double counts = std::round(pressure / pascals_per_count);
  const double sent = std::clamp(counts, double{Limits::min()}, double{Limits::max()});
  return link::Frame{.sequence = static_cast<std::uint8_t>(place),
                     .over_range = sent != counts,
                     .pressure = static_cast<std::int16_t>(sent)};
}

LinkRecording recording_of_link(std::span<const std::uint8_t> bytes, std::size_t most_samples) {
  LinkRecording result{.recording = {.sample_rate = link::frames_per_second}};
  Recording& recording = result.recording;
  link::FrameReader reader;
  std::int64_t place = -1;
  std::vector<char> over_range;
  for (const std::uint8_t byte : bytes) {
    if (recording.time.size() > most_samples) { break; }
    const auto received = reader.take(byte);
    if (!received) { continue; }
    place += 1 + received->missing_before;
    recording.time.push_back(static_cast<double>(place) / link::frames_per_second);
    recording.pressure.push_back(received->frame.pressure * pascals_per_count);
    over_range.push_back(received->frame.over_range ? 1 : 0);
  }
  reader.finish();
  result.counts = reader.counts();
  count_defects(recording, over_range);
  RecordingDefects& defects = recording.defects;
  defects.bad_frames = static_cast<std::size_t>(result.counts.bad_frames);
  defects.missing = static_cast<std::size_t>(result.counts.missing);
  defects.gaps = static_cast<std::size_t>(result.counts.gaps);
  defects.battery_low = static_cast<std::size_t>(result.counts.battery_low);
  return result;
}

LinkFrames link_frames(const Recording& recording) {
  LinkFrames frames;
  if (recording.time.size() < 2) { return frames; }
  const double longest = DefectRules::gap_periods * sampling_of(recording.time).period;
  const double begin = recording.time.front();
  const double span = recording.time.back() - begin;
  const auto places =
      static_cast<std::size_t>(std::floor(span * link::frames_per_second + same_instant)) + 1;
  std::size_t after = 1;
  for (std::size_t place = 0; place < places; ++place) {
    const double time = begin + static_cast<double>(place) / link::frames_per_second;
    while (after + 1 < recording.time.size() && recording.time[after] < time) { ++after; }
    frames.push_back(frame_of(pressure_at(recording, after, time, longest), place));
  }
  return frames;
}

std::vector<std::uint8_t> link_bytes(const LinkFrames& frames) {
  std::vector<std::uint8_t> bytes;
  for (const auto& frame : frames) {
    if (!frame) { continue; }
    const link::FrameBytes encoded = link::encode(*frame);
    bytes.insert(bytes.end(), encoded.begin(), encoded.end());
  }
  return bytes;
}

}  // namespace palpate

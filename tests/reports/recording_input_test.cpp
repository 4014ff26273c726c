// SPDX-License-Identifier: MIT

#include "reports/recording_input.hpp"

#include <set>
#include <sstream>

#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/comparison/link_recording.hpp"

namespace PALPATE_FILE {

using namespace palpate;

namespace fs = std::filesystem;

const fs::path recordings = scratch::source_folder() / "fixtures" / "recordings";

struct Damage {
  std::size_t offset = 0;  ///< in the clean stream
  std::string change{};    ///< "lost", "doubled" or "changed"
  unsigned mask = 0;
};

std::vector<Damage> stored_damage() {
  std::istringstream lines(scratch::text_of(recordings / "link-damage.csv"));
  std::vector<Damage> damage;
  for (std::string line; std::getline(lines, line);) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream fields(line);
    Damage one;
    if (fields >> one.offset >> one.change >> one.mask) { damage.push_back(one); }
  }
  return damage;
}

TEST("the damaged stream is the clean one with exactly the listed damage") {
  const std::string clean = scratch::text_of(recordings / "link-clean.bin");
  const std::vector<Damage> damage = stored_damage();
  CHECK(damage.size() == 60);
  std::string damaged;
  std::size_t at = 0;
  for (const Damage& each : damage) {
    damaged += clean.substr(at, each.offset - at);
    const char byte = clean[each.offset];
    if (each.change == "doubled") { damaged += {byte, byte}; }
    if (each.change == "changed") {
      damaged += static_cast<char>(static_cast<unsigned char>(byte) ^ each.mask);
    }
    at = each.offset + 1;
  }
  damaged += clean.substr(at);
  CHECK(damaged == scratch::text_of(recordings / "link-damaged.bin"));
}

TEST("of the damaged stream exactly the hit frames are lost, and every other sample is right") {
  std::set<std::size_t> hit;
  for (const Damage& each : stored_damage()) { hit.insert(each.offset / 8); }
  const InputRecording clean = read_any_recording(recordings / "link-clean.bin");
  const InputRecording damaged = read_any_recording(recordings / "link-damaged.bin");
  for (const InputRecording* each : {&clean, &damaged}) {
    CHECK(each->format == RecordingFormat::raw);
  }
  const std::size_t sent = clean.recording.time.size();
  CHECK(hit.size() == 43);
  REQUIRE(damaged.recording.time.size() == sent - hit.size());
  CHECK(damaged.frames->missing == static_cast<std::int64_t>(hit.size()));
  CHECK(damaged.recording.defects.missing == hit.size());
  Recording expected;
  for (std::size_t frame = 0; frame < sent; ++frame) {
    if (hit.contains(frame)) { continue; }
    expected.time.push_back(clean.recording.time[frame]);
    expected.pressure.push_back(clean.recording.pressure[frame]);
  }
  CHECK(damaged.recording.time == expected.time);
  CHECK(damaged.recording.pressure == expected.pressure);
}

TEST("the clean stream is the recording that it was made of") {
  const Recording heard = read_any_recording(recordings / "link-clean.bin").recording;
  const Recording made = io::read_recording_hdf5(recordings / "bmi-25-continuous-01.h5").recording;
  REQUIRE(heard.pressure.size() == made.pressure.size());
  CHECK(clinical::largest_difference(heard.pressure, made.pressure) <= 1e-9 * 6e4);  // of products
}

TEST("the format follows from the content, whatever the name") {
  const scratch::Folder folder;
  const Recording sample =
      io::read_recording_hdf5(recordings / "porcine-continuous-01.h5").recording;
  io::write_recording_hdf5(folder.path() / "a.csv", sample);
  io::write_recording_csv(folder.path() / "b.h5", sample);
  CHECK(format_of(folder.path() / "a.csv") == RecordingFormat::hdf5);
  CHECK(format_of(folder.path() / "b.h5") == RecordingFormat::csv);
  const std::string noise(1000, '\xA5');
  const fs::path raw =
      folder.file("c.csv", noise + scratch::text_of(recordings / "link-clean.bin"));
  CHECK(format_of(raw) == RecordingFormat::raw);
  std::string moved(512, 'M');  // the block that MATLAB puts first
  CHECK(format_of(folder.file("m", moved + "\x89HDF\r\n\x1a\n")) == RecordingFormat::hdf5);
  CHECK(read_any_recording(folder.path() / "b.h5").recording.pressure == sample.pressure);
}

TEST("a file that is no recording is refused with a reason") {
  const scratch::Folder folder;
  const std::vector<std::uint8_t> bytes = link_bytes({device::pressure_link::Frame{}});
  const std::string frame(bytes.begin(), bytes.end());
  const fs::path big = folder.file("big", frame);
  fs::resize_file(big, std::uintmax_t{2} << 30U);
  const std::pair<fs::path, const char*> rows[] = {
      {folder.file("e", ""), "is empty"},
      {folder.path(), "not a regular file"},
      {folder.path() / "none", "no such file"},
      {folder.file("o.mat", "MATLAB 5.0 MAT-file, ..."), "-v7.3"},
      {folder.file("b", "\x01\x02\xFF\n"), "is no text, no HDF5 and has no"},
      {folder.file("u", std::string("t\0i\0", 4)),
       "CSV as UTF-8, or UTF-16 with a byte order mark"},
      {folder.file("1", frame), "has one sample; at least two are needed"},
      {big, "bytes long; at most"}};
  for (const auto& [file, reason] : rows) { CHECK_THROWS(read_any_recording(file), reason); }
  CHECK_THROWS(read_any_recording(folder.file("n", "abc"), RecordingFormat::raw), "no frame");
  CHECK_THROWS(read_any_recording(recordings / "link-clean.bin", RecordingFormat::automatic,
                                  {.sample_rate = 100.0}),
               "--column and --rate are for CSV and HDF5");
}

TEST("constant pressure is a recording, with a warning") {
  LinkFrames frames;
  for (int n = 0; n < 300; ++n) {
    frames.push_back({{.sequence = static_cast<std::uint8_t>(n), .pressure = 2000}});
  }
  const std::vector<std::uint8_t> bytes = link_bytes(frames);
  const scratch::Folder folder;
  const InputRecording read =
      read_any_recording(folder.file("c", std::string(bytes.begin(), bytes.end())));
  CHECK(read.recording.time.size() == 300);
  REQUIRE(read.warnings.size() == 1);
  CHECK(read.warnings[0].starts_with("pressure is constant"));
}

TEST("a depth that is constant, or longer than a needle, is read with a warning") {
  const scratch::Folder folder;
  for (const auto& [depth, warning] :
       {std::pair{"5", "depth is constant, 0.005 m"},
        std::pair{"300", "the largest depth is 0.3 m, more than a needle is long"}}) {
    std::string text = "time_s,pressure_mmHg,depth_mm\n0,100,5\n";
    for (int n = 1; n < 20; ++n) {
      text += std::to_string(0.01 * n) + "," + std::to_string(100 + n) + "," + depth + "\n";
    }
    const InputRecording read = read_any_recording(folder.file("d.csv", text));
    REQUIRE(read.warnings.size() == 1);
    CHECK(read.warnings[0].starts_with(warning));
  }
}

}  // namespace PALPATE_FILE

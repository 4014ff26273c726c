// SPDX-License-Identifier: MIT

#include "reports/recording_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/hdf5_file.hpp"
#include "model/problem/input_error.hpp"
#include "validation/comparison/link_recording.hpp"
#include "validation/comparison/reconstruction.hpp"

namespace palpate {
namespace {

namespace link = device::pressure_link;

constexpr std::size_t first_look = 64 * 1024;
/// Size limit of a raw link file, with as many damaged bytes as sample bytes.
constexpr std::size_t most_raw_bytes = 2 * link::frame_bytes * io::most_samples;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

bool has_frames(const std::string& bytes) {
  link::FrameReader reader;
  for (const std::uint8_t byte : bytes_of(bytes)) {
    if (reader.take(byte)) { return true; }
  }
  return false;
}

/// Returns true for text: no control characters except white space.
bool is_text(std::string_view bytes) {
  return std::ranges::all_of(bytes, [](char c) {
    return static_cast<unsigned char>(c) >= ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
  });
}

void refuse_columns(const std::filesystem::path& path, const io::ReadOptions& options) {
  if (options.columns.empty() && !options.sample_rate) { return; }
  throw InputError(path.string() +
                   ": the raw link has neither columns nor another rate; --column and --rate are "
                   "for CSV and HDF5");
}

InputRecording read_raw(const std::filesystem::path& path, const io::ReadOptions& options) {
  refuse_columns(path, options);
  const std::string text = io::read_bytes(path, most_raw_bytes);
  LinkRecording heard = recording_of_link(bytes_of(text), io::most_samples);
  if (heard.counts.frames > static_cast<std::int64_t>(io::most_samples)) {
    io::refuse_length(path.string());
  }
  if (heard.counts.frames == 0) {
    throw InputError(path.string() +
                     ": no frame of the raw link; frames of 8 bytes that begin with A5 5A and pass "
                     "their checksum are needed");
  }
  InputRecording read;
  read.recording = std::move(heard.recording);
  read.frames = heard.counts;
  io::check_usable(read.recording, path);
  io::add_warnings(read);
  if (heard.counts.gaps > 0) {
    read.warnings.emplace_back(
        "sequence numbers wrap at 256: a gap of more than 2.1 s looks shorter by multiples of "
        "that");
  }
  if (heard.counts.battery_low > 0) {
    read.warnings.push_back("battery low in " + std::to_string(heard.counts.battery_low) +
                            " frames");
  }
  return read;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) { return {path}; }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() == ".h5") { files.push_back(entry.path()); }
  }
  if (files.empty()) {
    throw InputError(path.string() + ": has no .h5 file; a folder of recordings has some");
  }
  std::ranges::sort(files);
  return files;
}

using Technique = InsertionOutline::Technique;

constexpr std::size_t subjects = 5;
constexpr double metres_per_millimetre = 1e-3;

struct BmiGroup {
  const char* id;    ///< row of the table
  const char* name;  ///< name of the group
  const char* file;
  double middle;  ///< mean BMI [kg/m^2]
};
constexpr std::array bmi_groups{
    BmiGroup{"P01", "BMI 18-24.9", "bmi-18", 22.0}, BmiGroup{"P02", "BMI 25-34.9", "bmi-25", 30.0},
    BmiGroup{"P03", "BMI 35-44.9", "bmi-35", 40.0}, BmiGroup{"P04", "BMI >= 45", "bmi-45", 47.0}};

/// Standard scores of one group; each quantity varies independently.
struct Scores {
  explicit Scores(std::uint64_t seed)
      : peak(even_scores(subjects, seed)),
        floor(even_scores(subjects, seed + 1)),
        body_mass_index(even_scores(subjects, seed + 2)),
        depth(even_scores(subjects, seed + 3)),
        flavum(even_scores(subjects, seed + 4)),
        fall(even_scores(subjects, seed + 5)) {}
  std::vector<double> peak, floor, body_mass_index, depth, flavum, fall;
};

/// Maps scores linearly so that their extremes become `least` and `largest`.
double between(double least, double largest, double score) {
  const double extreme =
      0.5 * double(subjects - 1) / std::sqrt(2.5);  // SD of -2 ... 2 is sqrt(2.5)
  return std::lerp(least, largest, 0.5 * (1.0 + score / extreme));
}

class Builder {
 public:
  explicit Builder(const io::PublishedValues& table) : table_(table) {}

  std::vector<Recording> build() {
    std::uint64_t seed = 100;
    for (const BmiGroup& group : bmi_groups) { add_group(group, seed += 100); }
    add_porcine(seed += 100);
    add_pump(seed += 100);
    return std::move(recordings_);
  }

 private:
  [[nodiscard]] double number(const char* id, const char* unit) const {
    return table_.of(id, unit).value;
  }
  [[nodiscard]] double spread(const char* id, const char* unit) const {
    return table_.of(id, unit).spread.value_or(0.0);
  }
  [[nodiscard]] double pascals(const char* id) const {
    return number(id, "mmHg") * pascals_per_mmhg;
  }
  [[nodiscard]] double metres(const char* id) const {
    return number(id, "mm") * metres_per_millimetre;
  }

  /// Properties common to all recordings: the timing of the hand. Depth begins at 0 if none is
  /// published.
  [[nodiscard]] InsertionOutline outline(const Scores& scores, std::size_t n) const {
    InsertionOutline o;
    o.speed = number("X10", "mm/s") * metres_per_millimetre;
    o.flavum_speed = number("X11", "mm/s") * metres_per_millimetre;
    o.largest_advance = metres("X12");
    o.pressure_left = number("X13", "1");
    o.fall = between(number("X14", "s"), number("X15", "s"), scores.fall[n]);
    o.hold = number("X16", "s");
    o.tremor = number("X17", "1");
    o.noise = pascals("X18");
    o.flavum_begin = metres("X09");
    const double flavum = number("A12", "mm") + spread("A12", "mm") * scores.flavum[n];
    o.flavum_end = o.flavum_begin + flavum * metres_per_millimetre;
    return o;
  }

  void set_pressures(InsertionOutline& o, double peak, double floor) const {
    o.peak = peak;
    o.floor = floor;
    o.plateau = peak * number("F10", "N") / number("F11", "N");
  }

  /// Depth from the skin. BMI affects only the fat layer; unexplained variation is assigned to the
  /// interspinous ligament.
  [[nodiscard]] double flavum_depth(double body_mass_index, double score) const {
    const double epidural = number("A01a", "mm") + number("A01b", "mm m^2/kg") * body_mass_index;
    const double beyond_fat =
        number("X06", "mm") + number("X07", "mm") + number("X08", "mm") + number("A12", "mm");
    const double fat = epidural - beyond_fat;
    const double residual = 0.5 * number("A10", "mm") * score;  // "within" is two SD
    return (number("X06", "mm") + fat + number("X07", "mm") + number("X08", "mm") + residual) *
           metres_per_millimetre;
  }

  void add(InsertionOutline o, Recording facts, const std::string& stem, std::uint64_t seed) {
    o.seed = seed;
    Recording drawn = draw_insertion(o);
    facts.time = std::move(drawn.time);
    facts.pressure = std::move(drawn.pressure);
    if (facts.body_mass_index) { facts.depth = std::move(drawn.depth); }
    facts.kind = drawn.kind;
    facts.technique = drawn.technique;
    facts.sample_rate = drawn.sample_rate;
    facts.plunger_area = number("X01", "m^2");
    const std::string number_of_subject = "-0" + std::to_string(seed / 2 % 10 + 1);
    facts.subject = stem + number_of_subject;
    facts.name = stem + "-" + drawn.technique + number_of_subject;
    facts.note = std::string(io::reconstruction_note) + "; seed " + std::to_string(seed);
    count_defects(facts);
    recordings_.push_back(std::move(facts));
  }

  void add_both(InsertionOutline o, const Recording& facts, const std::string& stem,
                std::uint64_t seed) {
    for (const Technique technique : {Technique::continuous, Technique::intermittent}) {
      o.technique = technique;
      add(o, facts, stem, seed++);
    }
  }

  void add_group(const BmiGroup& group, std::uint64_t seed) {
    const Scores scores(seed);
    const double mean = pascals(group.id);
    for (std::size_t n = 0; n < subjects; ++n) {
      InsertionOutline o = outline(scores, n);
      set_pressures(o, mean * (1.0 + number("X02", "1") * scores.peak[n]),
                    pascals("P16") + spread("P16", "mmHg") * pascals_per_mmhg * scores.floor[n]);
      const double half = number("X05", "kg/m^2");
      const double bmi =
          between(group.middle - half, group.middle + half, scores.body_mass_index[n]);
      const double shift = flavum_depth(bmi, scores.depth[n]) - o.flavum_begin;
      for (double* depth : {&o.start, &o.flavum_begin, &o.flavum_end}) { *depth += shift; }
      add_both(o,
               {.source = table_.of(group.id, "mmHg").source,
                .group = group.name,
                .body_mass_index = bmi},
               group.file, seed + 2 * n);
    }
  }

  void add_porcine(std::uint64_t seed) {
    const Scores scores(seed);
    for (std::size_t n = 0; n < subjects; ++n) {
      InsertionOutline o = outline(scores, n);
      set_pressures(o, between(pascals("P05"), pascals("P06"), scores.peak[n]), pascals("X04"));
      add_both(o, {.source = table_.of("P05", "mmHg").source, .group = "porcine"}, "porcine",
               seed + 2 * n);
    }
  }

  /// Adds the pump recordings. The published supraspinous value is used for all layers before the
  /// ligamentum flavum, since no other value is published.
  void add_pump(std::uint64_t seed) {
    const Scores scores(seed);
    for (std::size_t n = 0; n < subjects; ++n) {
      InsertionOutline o = outline(scores, n);
      const double factor = 1.0 + number("X02", "1") * scores.peak[n];
      o.peak = pascals("P08") * factor;
      o.plateau = pascals("P07") * factor;
      // The SD of the floor is two thirds of its mean, so values are limited to zero.
      o.floor = std::fmax(pascals("P09") + pascals("X03") * scores.floor[n], 0.0);
      add(o,
          {.regime = Recording::Regime::pump,
           .source = table_.of("P07", "mmHg").source,
           .group = "pump"},
          "pump", seed + 2 * n);
    }
  }

  const io::PublishedValues& table_;
  std::vector<Recording> recordings_{};
};

}  // namespace

std::string_view name_of(RecordingFormat format) {
  switch (format) {
    case RecordingFormat::csv: return "csv";
    case RecordingFormat::raw: return "raw";
    case RecordingFormat::hdf5: return "hdf5";
    case RecordingFormat::automatic: break;
  }
  return "auto";
}

RecordingFormat format_of(const std::filesystem::path& path) {
  const std::string beginning = io::read_beginning(path, first_look);
  if (beginning.empty()) { throw InputError(path.string() + ": is empty; a recording is needed"); }
  if (io::is_hdf5(beginning)) { return RecordingFormat::hdf5; }
  if (beginning.starts_with("MATLAB 5.0")) {
    throw InputError(path.string() + ": is a MATLAB file of an older kind; save it with -v7.3");
  }
  if (has_frames(beginning)) { return RecordingFormat::raw; }
  if (is_text(beginning) || io::is_utf16(beginning)) { return RecordingFormat::csv; }
  throw InputError(path.string() +
                   ": is no text, no HDF5 and has no frames of the raw link; one of these is "
                   "needed (CSV as UTF-8, or UTF-16 with a byte order mark)");
}

InputRecording read_any_recording(const std::filesystem::path& path, RecordingFormat format,
                                  const io::ReadOptions& options) {
  if (format == RecordingFormat::automatic) { format = format_of(path); }
  InputRecording read;
  if (format == RecordingFormat::raw) {
    read = read_raw(path, options);
  } else {
    static_cast<io::ReadRecording&>(read) = format == RecordingFormat::hdf5
                                                ? io::read_recording_hdf5(path, options)
                                                : io::read_recording_csv(path, options);
  }
  read.format = format;
  return read;
}

RecordingFormat format_named(const std::string& option, const std::string& name) {
  for (const RecordingFormat format : {RecordingFormat::automatic, RecordingFormat::csv,
                                       RecordingFormat::raw, RecordingFormat::hdf5}) {
    if (name == name_of(format)) { return format; }
  }
  throw InputError(option + " " + name + "; must be auto, csv, raw or hdf5");
}

std::string hash_of_file(const std::filesystem::path& file) {
  constexpr std::size_t most_bytes = std::size_t{4} << 30U;
  return io::content_hash(io::read_bytes(file, most_bytes));
}

namespace {

/// True if two recordings have the same signal, which is not constant, at the same times after
/// their first sample, within 1e-6: one is an export of the other.
bool has_samples_of(const Recording& one, const Recording& other) {
  const auto& a = one.signal();
  const auto& b = other.signal();
  if (a.size() != b.size() || one.pressure.empty() != other.pressure.empty() || a.empty()) {
    return false;
  }
  constexpr double digits = 1e-6;
  const double length = one.time.back() - one.time.front();
  double largest = 0.0;
  bool constant = true;
  for (const double value : a) {
    largest = std::max(largest, std::abs(value));  // not NaN
    constant = constant && value == a.front();
  }
  if (constant) { return false; }
  for (std::size_t n = 0; n < a.size(); ++n) {
    const double apart = (one.time[n] - one.time[0]) - (other.time[n] - other.time[0]);
    const bool both_nan = std::isnan(a[n]) && std::isnan(b[n]);
    if (!(std::abs(apart) <= digits * length) ||
        !(both_nan || std::abs(a[n] - b[n]) <= digits * largest)) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::vector<RecordingFile> read_recordings(const std::vector<std::filesystem::path>& paths,
                                           const std::function<void(const RecordingFile&)>& check) {
  std::vector<RecordingFile> recordings;
  std::string problems;
  const auto gather = [&problems](auto&& read) {
    try {
      read();
    } catch (const InputError& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  };
  const auto read_one = [&](const std::filesystem::path& file) {
    RecordingFile one{.file = file, .hash = {}, .input = read_any_recording(file)};
    one.hash = hash_of_file(file);
    const auto twin = std::ranges::find(recordings, one.hash, &RecordingFile::hash);
    if (twin != recordings.end()) {
      throw InputError(file.string() + ": the same bytes as " + twin->file.string() +
                       "; every recording once");
    }
    const auto same = std::ranges::find_if(recordings, [&](const RecordingFile& other) {
      return has_samples_of(one.input.recording, other.input.recording);
    });
    if (same != recordings.end()) {
      throw InputError(file.string() + ": the same samples as " + same->file.string() +
                       "; every recording once");
    }
    if (one.input.recording.name.empty()) { one.input.recording.name = file.stem().string(); }
    check(one);
    recordings.push_back(std::move(one));
  };
  for (const std::filesystem::path& path : paths) {
    gather([&] {
      for (const auto& file : files_in(path)) {
        gather([&] { read_one(file); });
      }
    });
  }
  if (!problems.empty()) { throw InputError(problems); }
  return recordings;
}

std::vector<Recording> reconstructed_recordings(const io::PublishedValues& table) {
  return Builder(table).build();
}

}  // namespace palpate

// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <set>

#include "fixtures/io/recording_file.hpp"
#include "model/problem/recording.hpp"
#include "reports/recording_input.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"

namespace {

using namespace palpate;

namespace fs = std::filesystem;

const fs::path fixtures = scratch::source_folder() / "fixtures";

const io::PublishedValues& table() {
  static const io::PublishedValues values =
      io::read_published_values(fixtures / "clinical" / "published_values.csv");
  return values;
}

const std::vector<Recording>& all() {
  static const std::vector<Recording> recordings = reconstructed_recordings(table());
  return recordings;
}

std::vector<Recording> of(const std::string& group, const std::string& technique) {
  std::vector<Recording> some;
  std::ranges::copy_if(all(), std::back_inserter(some), [&](const Recording& r) {
    return r.group == group && r.technique == technique;
  });
  return some;
}

double peak_mmhg(const Recording& recording) {
  return std::ranges::max(recording.pressure) / pascals_per_mmhg;
}

struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};
template <class Value>
Statistics statistics(const std::vector<Recording>& recordings, Value value) {
  Statistics s;
  for (const Recording& r : recordings) { s.mean += value(r) / double(recordings.size()); }
  for (const Recording& r : recordings) { s.deviation += std::pow(value(r) - s.mean, 2); }
  s.deviation = std::sqrt(s.deviation / double(recordings.size() - 1));
  return s;
}

const std::array bmi_groups{std::pair{"BMI 18-24.9", 461.0}, std::pair{"BMI 25-34.9", 430.0},
                            std::pair{"BMI 35-44.9", 415.0}, std::pair{"BMI >= 45", 376.0}};

TEST("either technique of one subject says that it is the same subject, and nobody else does") {
  for (const auto& [group, peak] : bmi_groups) {
    std::set<std::string> subjects;
    for (const char* technique : {"continuous", "intermittent"}) {
      for (const Recording& one : of(group, technique)) { subjects.insert(one.subject); }
    }
    CHECK(subjects.size() == 5);
    CHECK(!subjects.contains(""));
  }
}

TEST("the stored recordings are what the table gives, sample by sample") {
  std::size_t stored = 0;
  for (const auto& entry : fs::directory_iterator(fixtures / "recordings")) {
    stored += entry.path().extension() == ".h5" ? 1 : 0;
  }
  CHECK(stored == all().size());
  for (const Recording& made : all()) {
    const Recording kept = io::read_recording(fixtures / "recordings" / (made.name + ".h5"));
    CHECK(kept.time == made.time);
    CHECK(kept.technique == made.technique);
    CHECK(kept.group == made.group);
    CHECK(kept.subject == made.subject);
    CHECK(kept.note == made.note);
    CHECK(kept.source == made.source);
    CHECK(kept.regime == made.regime);
    CHECK(kept.body_mass_index == made.body_mass_index);
    CHECK(kept.defects == made.defects);
    REQUIRE(kept.pressure.size() == made.pressure.size());
    REQUIRE(kept.depth.size() == made.depth.size());
    double worst_pressure = 0.0, worst_depth = 0.0;
    for (std::size_t n = 0; n < std::min(kept.pressure.size(), made.pressure.size()); ++n) {
      worst_pressure = std::fmax(worst_pressure, std::abs(kept.pressure[n] - made.pressure[n]));
    }
    for (std::size_t n = 0; n < std::min(kept.depth.size(), made.depth.size()); ++n) {
      worst_depth = std::fmax(worst_depth, std::abs(kept.depth[n] - made.depth[n]));
    }
    // One unit of rounding: the sine of another library may differ in its last bit.
    CHECK_NEAR(worst_pressure, 0.0, 0.1001 * pascals_per_mmhg);
    CHECK_NEAR(worst_depth, 0.0, 1.001e-5);
  }
}

TEST("every one says that it is reconstructed, from what, and with which seed") {
  std::set<std::string> names;
  for (const Recording& r : all()) {
    CHECK(r.kind == Recording::Kind::reconstructed);
    CHECK(r.note.starts_with(io::reconstruction_note));
    CHECK_CONTAINS(r.note, "seed ");
    CHECK(!r.source.empty());
    CHECK(!r.group.empty());
    CHECK(r.sample_rate == 120.0);
    CHECK((r.defects == RecordingDefects{}));
    CHECK(names.insert(r.name).second);
  }
}

TEST("mean peaks of the BMI groups are the published ones, and fall with BMI") {
  // Noise raises a maximum by two of its SD over some dozens of samples, never by seven.
  const double noise = 7.0 * table().of("X18", "mmHg").value;
  for (const char* technique : {"continuous", "intermittent"}) {
    double before = 1000.0;
    for (const auto& [group, mean] : bmi_groups) {
      const Statistics peaks = statistics(of(group, technique), peak_mmhg);
      CHECK(of(group, technique).size() == 5);
      CHECK_NEAR(peaks.mean, mean, noise);
      CHECK_NEAR(peaks.deviation, 0.22 * mean, noise);
      CHECK(peaks.mean < before);
      before = peaks.mean;
    }
  }
}

TEST("the spread between subjects follows from the pump's confidence interval") {
  // Student's t with 19 degrees of freedom at 97.5 %: 2.093.
  const io::PublishedValue& flavum = table().of("P08", "mmHg");
  const double deviation = *flavum.spread * std::sqrt(20.0) / 2.093;
  CHECK_NEAR(deviation / flavum.value, table().of("X02", "1").value, 0.005);  // given to two digits
  const double floor = *table().of("P09", "mmHg").spread * std::sqrt(20.0) / 2.093;
  CHECK_NEAR(floor, table().of("X03", "mmHg").value, 0.05);
}

TEST("porcine peaks lie in the published range and reach both its ends") {
  for (const char* technique : {"continuous", "intermittent"}) {
    const auto recordings = of("porcine", technique);
    const auto [least, largest] = std::ranges::minmax(recordings, {}, peak_mmhg);
    const double noise = 7.0 * table().of("X18", "mmHg").value;
    CHECK_NEAR(peak_mmhg(least), 470.0, noise);
    CHECK_NEAR(peak_mmhg(largest), 500.0, noise);
    for (const Recording& r : recordings) {
      REQUIRE(r.depth.empty());
      CHECK(!r.body_mass_index);
    }
  }
}

TEST("thumb and pump are kept apart, and the pump's pressures are its own") {
  const auto pump = of("pump", "continuous");
  CHECK(pump.size() == 5);
  CHECK_NEAR(statistics(pump, peak_mmhg).mean, 92.0, 7.0 * table().of("X18", "mmHg").value);
  for (const Recording& r : all()) {
    CHECK((r.regime == Recording::Regime::pump) == (r.group == "pump"));
  }
}

double depth_of_peak(const Recording& r) {
  const auto peak = std::ranges::max_element(r.pressure) - r.pressure.begin();
  return 1e3 * r.depth[static_cast<std::size_t>(peak)];
}

TEST("depth follows the published regression on BMI, and nothing else does") {
  for (const auto& [group, ignored] : bmi_groups) {
    const auto recordings = of(group, "continuous");
    const double bmi =
        statistics(recordings, [](const Recording& r) { return *r.body_mass_index; }).mean;
    const double expected = 17.7966 + 0.9777 * bmi;
    // The peak is sought among noisy samples of a ramp: within the noise over the ramp's slope, and
    // a group's own flavum and residual have mean zero.
    CHECK_NEAR(statistics(recordings, depth_of_peak).mean, expected, 0.05);
  }
}

/// Duration of the final part of a recording in which the pressure is below half its peak [s].
double low_for(const Recording& r) {
  std::size_t n = r.time.size();
  while (n > 0 && r.pressure[n - 1] < 0.5 * std::ranges::max(r.pressure)) { --n; }
  return r.time.back() - r.time[n];
}

TEST("resistance is lost within 50 to 200 ms and stays lost for more than 5 s") {
  for (const Recording& r : all()) {
    CHECK(low_for(r) > 5.0);  // the rule of Vaira et al. 2019
    const double peak = std::ranges::max(r.pressure);
    const double floor = r.pressure.back();
    std::size_t high = 0, low = r.time.size() - 1;
    for (std::size_t n = 0; n < r.time.size(); ++n) {
      if (r.pressure[n] > floor + 0.9 * (peak - floor)) { high = n; }
    }
    while (low > high && r.pressure[low - 1] < floor + 0.1 * (peak - floor)) { --low; }
    // A linear decrease is between 90 and 10 % for 0.8 of its time; each end is accurate to a
    // sample.
    CHECK_NEAR(r.time[low] - r.time[high], 0.8 * 0.125, 0.8 * 0.075 + 2.0 / 120.0);
  }
}

TEST("the intermittent technique releases the plunger between advances; the other never does") {
  const auto releases = [](const Recording& r) {
    const auto peak = std::ranges::max_element(r.pressure) - r.pressure.begin();
    const double half = 0.5 * r.pressure[std::size_t(120)];  // the plateau, a second in
    int count = 0;
    for (std::ptrdiff_t n = 121; n < peak; ++n) {
      const auto at = static_cast<std::size_t>(n);
      count += r.pressure[at] < half && r.pressure[at - 1] >= half ? 1 : 0;
    }
    return count;
  };
  for (const Recording& r : all()) {
    if (r.technique == "continuous") { CHECK(releases(r) == 0); }
    if (r.technique == "intermittent") { CHECK(releases(r) >= 7); }  // 12 mm or more by 1.5 mm
  }
}

TEST("a table with a hole in it is refused by file, line and id") {
  const scratch::Folder folder;
  const auto read = [&](const std::string& rows) {
    return io::read_published_values(
        folder.file("t.csv", "id,value,spread,unit,status,source\n" + rows));
  };
  CHECK_THROWS(read("P01,abc,,mmHg,V,x\n"), "t.csv:2: value = \"abc\"; must be a finite number");
  CHECK_THROWS(read("P01,1,,mmHg,V,\n"), "every value must have both");
  CHECK_THROWS(read("P01,1,,mmHg,Q,x\n"), "must be V, C, D, X or M");
  CHECK_THROWS(read("P01,1,,mmHg,V,x\nP01,1,,mmHg,V,x\n"), "t.csv:3: id P01 twice");
  CHECK_THROWS(read(""), "has no rows");
  CHECK_THROWS(reconstructed_recordings(read("P01,1,,mmHg,V,x\n")), "no row ");
  CHECK_THROWS(read("P01,1,,kPa,V,x\n").of("P01", "mmHg"),
               "t.csv:2: P01 is in kPa; must be in mmHg");
}

}  // namespace

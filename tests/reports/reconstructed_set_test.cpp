// SPDX-License-Identifier: MIT

#include <set>

#include "fixtures/io/recording_file.hpp"
#include "reports/recording_input.hpp"
#include "tests/check.hpp"
#include "tests/fixtures/scratch_folder.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/statistics.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using comparison::deviation_of;
using comparison::mean_of;

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

template <class Value>
std::vector<double> values_of(const std::vector<Recording>& recordings, Value value) {
  std::vector<double> values;
  std::ranges::transform(recordings, std::back_inserter(values), value);
  return values;
}

/// Peak pressures [mmHg].
std::vector<double> peaks_of(const std::vector<Recording>& recordings) {
  return values_of(recordings, [](const Recording& one) {
    return std::ranges::max(one.pressure) / pascals_per_mmhg;
  });
}

/// Noise raises a maximum by two of its standard deviations over some dozens of samples, never by
/// seven [mmHg].
double noise() { return 7.0 * table().of("X18", "mmHg").value; }

const std::array bmi_groups{std::pair{"BMI 18-24.9", 461.0}, std::pair{"BMI 25-34.9", 430.0},
                            std::pair{"BMI 35-44.9", 415.0}, std::pair{"BMI >= 45", 376.0}};

TEST("recordings of one subject with either technique have its name, and no others do") {
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
    const Recording kept =
        io::read_recording_hdf5(fixtures / "recordings" / (made.name + ".h5")).recording;
    CHECK(kept.time == made.time);
    for (const auto text : {&Recording::technique, &Recording::group, &Recording::subject,
                            &Recording::note, &Recording::source}) {
      CHECK(kept.*text == made.*text);
    }
    CHECK(kept.regime == made.regime);
    CHECK(kept.body_mass_index == made.body_mass_index);
    CHECK(kept.defects == made.defects);
    REQUIRE(kept.pressure.size() == made.pressure.size());
    REQUIRE(kept.depth.size() == made.depth.size());
    // One unit of rounding: the sine of another library may differ in its last bit.
    CHECK(clinical::largest_difference(kept.pressure, made.pressure) <= 0.1001 * pascals_per_mmhg);
    if (!made.depth.empty()) {
      CHECK(clinical::largest_difference(kept.depth, made.depth) <= 1.001e-5);
    }
  }
}

TEST("every reconstructed recording has its kind, source and seed") {
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
  for (const char* technique : {"continuous", "intermittent"}) {
    double before = 1000.0;
    for (const auto& [group, mean] : bmi_groups) {
      const std::vector<double> peaks = peaks_of(of(group, technique));
      CHECK(peaks.size() == 5);
      CHECK_NEAR(mean_of(peaks), mean, noise());
      CHECK_NEAR(deviation_of(peaks), 0.22 * mean, noise());
      CHECK(mean_of(peaks) < before);
      before = mean_of(peaks);
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

TEST("porcine peaks have both ends of the published range, and a pump has pressures of its own") {
  for (const char* technique : {"continuous", "intermittent"}) {
    const auto recordings = of("porcine", technique);
    CHECK_NEAR(std::ranges::min(peaks_of(recordings)), 470.0, noise());
    CHECK_NEAR(std::ranges::max(peaks_of(recordings)), 500.0, noise());
    for (const Recording& r : recordings) {
      CHECK(r.depth.empty());
      CHECK(!r.body_mass_index);
    }
  }
  const std::vector<double> pump = peaks_of(of("pump", "continuous"));
  CHECK(pump.size() == 5);
  CHECK_NEAR(mean_of(pump), 92.0, noise());
  for (const Recording& r : all()) {
    CHECK((r.regime == Recording::Regime::pump) == (r.group == "pump"));
  }
}

std::size_t peak_index(const Recording& r) {
  return static_cast<std::size_t>(std::ranges::max_element(r.pressure) - r.pressure.begin());
}

TEST("the depth of the peak follows the published regression on BMI") {
  for (const auto& [group, ignored] : bmi_groups) {
    const auto recordings = of(group, "continuous");
    const double bmi =
        mean_of(values_of(recordings, [](const Recording& r) { return *r.body_mass_index; }));
    const auto depth = [](const Recording& r) { return 1e3 * r.depth[peak_index(r)]; };
    // The peak is sought among noisy samples of a ramp: within the noise over the ramp's slope, and
    // a group's own flavum and residual have mean zero.
    CHECK_NEAR(mean_of(values_of(recordings, depth)), 17.7966 + 0.9777 * bmi, 0.05);
  }
}

/// First sample of the final part of a recording in which the pressure is below a level [Pa].
std::size_t last_fall(const Recording& r, double level) {
  std::size_t n = r.time.size();
  while (n > 0 && r.pressure[n - 1] < level) { --n; }
  return n;
}

TEST("resistance is lost within 50 to 200 ms and stays lost for more than 5 s") {
  for (const Recording& r : all()) {
    const double peak = std::ranges::max(r.pressure);
    const double floor = r.pressure.back();
    // The rule of Vaira et al. 2019.
    CHECK(r.time.back() - r.time[last_fall(r, 0.5 * peak)] > 5.0);
    const std::size_t high = last_fall(r, floor + 0.9 * (peak - floor)) - 1;
    const std::size_t low = last_fall(r, floor + 0.1 * (peak - floor));
    // A linear decrease is between 90 and 10 % for 0.8 of its time; each end is accurate to a
    // sample.
    CHECK_NEAR(r.time[low] - r.time[high], 0.8 * 0.125, 0.8 * 0.075 + 2.0 / 120.0);
  }
}

TEST("the intermittent technique releases the plunger between advances; the other never does") {
  const auto releases = [](const Recording& r) {
    const double half = 0.5 * r.pressure[120];  // the plateau, a second in
    int count = 0;
    for (std::size_t n = 121; n < peak_index(r); ++n) {
      count += r.pressure[n] < half && r.pressure[n - 1] >= half ? 1 : 0;
    }
    return count;
  };
  for (const Recording& r : all()) {
    if (r.technique == "continuous") { CHECK(releases(r) == 0); }
    if (r.technique == "intermittent") { CHECK(releases(r) >= 7); }  // 12 mm or more by 1.5 mm
  }
}

TEST("an incomplete table is refused by file, line and id") {
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

}  // namespace PALPATE_FILE

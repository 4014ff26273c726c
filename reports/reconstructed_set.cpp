// SPDX-License-Identifier: MIT

#include "reports/reconstructed_set.hpp"

#include <array>
#include <cmath>

#include "fixtures/io/recording_file.hpp"
#include "model/problem/recording.hpp"
#include "validation/comparison/reconstruction.hpp"

namespace palpate {
namespace {

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

std::vector<Recording> reconstructed_recordings(const io::PublishedValues& table) {
  return Builder(table).build();
}

}  // namespace palpate

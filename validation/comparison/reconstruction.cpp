// SPDX-License-Identifier: MIT

#include "validation/comparison/reconstruction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "validation/random.hpp"

namespace palpate {
namespace {

using Technique = InsertionOutline::Technique;

// Assumed technique of the hand; none of these values is published.
constexpr double rise_time = 1.0;      // until full thumb pressure [s]
constexpr double reaction_time = 0.2;  // from the fall to the stop of the needle [s]
constexpr double advance_time = 0.5;   // of one step of the intermittent technique [s]
constexpr double press_time = 0.3;     // [s]
constexpr double test_time = 0.5;      // under full pressure [s]

constexpr double pressure_step = 0.1 * pascals_per_mmhg;  // [Pa]
constexpr double depth_step = 1e-5;                       // [m]

/// Segment with linear pressure and depth to these values.
struct Leg {
  double duration = 0.0;  ///< [s]
  double pressure = 0.0;  ///< at its end [Pa]
  double depth = 0.0;     ///< at its end [m]
};

/// Returns the pressure under a full press of the thumb at a depth [Pa].
double pressed(const InsertionOutline& o, double depth) {
  const double share = (depth - o.flavum_begin) / (o.flavum_end - o.flavum_begin);
  return std::lerp(o.plateau, o.peak, std::clamp(share, 0.0, 1.0));
}

void loss_of_resistance(const InsertionOutline& o, double speed, std::vector<Leg>& legs) {
  double depth = o.flavum_end + speed * o.fall;
  legs.push_back({o.fall, o.floor, depth});
  depth += speed * reaction_time;
  legs.push_back({reaction_time, o.floor, depth});
  legs.push_back({o.hold, o.floor, depth});
}

std::vector<Leg> continuous(const InsertionOutline& o) {
  std::vector<Leg> legs{{rise_time, o.plateau, o.start},
                        {(o.flavum_begin - o.start) / o.speed, o.plateau, o.flavum_begin},
                        {(o.flavum_end - o.flavum_begin) / o.flavum_speed, o.peak, o.flavum_end}};
  loss_of_resistance(o, o.flavum_speed, legs);
  return legs;
}

std::vector<Leg> intermittent(const InsertionOutline& o) {
  const double length = o.flavum_end - o.start;
  const double count = std::ceil(length / o.largest_advance);
  std::vector<Leg> legs{{rise_time, o.plateau, o.start}};
  for (double n = 1.0; n <= count; ++n) {
    const double depth = o.start + length * n / count;
    const double pressure = pressed(o, depth);
    legs.push_back({advance_time, o.pressure_left * pressure, depth});
    legs.push_back({press_time, pressure, depth});
    legs.push_back({test_time, pressure, depth});
  }
  loss_of_resistance(o, length / count / advance_time, legs);
  return legs;
}

/// Adds two slow waves; zero at the peak, so that its value is exact.
class Tremor {
 public:
  Tremor(double share, double peak, device::Seeded& chance) : share_(share), peak_(peak) {
    for (Wave& wave : waves_) {
      wave = {.rate = 2.0 * std::numbers::pi * chance.uniform(0.7, 3.0),
              .phase = chance.uniform(0.0, 2.0 * std::numbers::pi)};
    }
  }
  [[nodiscard]] double at(double time, double pressure) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) { sum += std::sin(wave.rate * time + wave.phase); }
    return share_ * pressure * (1.0 - pressure / peak_) * sum;
  }

 private:
  struct Wave {
    double rate = 0.0;   ///< [rad/s]
    double phase = 0.0;  ///< [rad]
  };
  double share_;
  double peak_;
  std::array<Wave, 2> waves_{};
};

double rounded(double value, double step) { return std::round(value / step) * step; }

}  // namespace

Recording draw_insertion(const InsertionOutline& outline) {
  const bool in_steps = outline.technique == Technique::intermittent;
  const std::vector<Leg> legs = in_steps ? intermittent(outline) : continuous(outline);
  device::Seeded chance(outline.seed);
  const Tremor tremor(outline.tremor, outline.peak, chance);
  Recording recording{.kind = Recording::Kind::reconstructed,
                      .technique = in_steps ? "intermittent" : "continuous",
                      .sample_rate = outline.sample_rate};
  Leg before{.depth = outline.start};
  double begin = 0.0;
  std::size_t sample = 0;
  for (const Leg& leg : legs) {
    const double end = begin + leg.duration;
    for (double time = 0.0; (time = double(sample) / outline.sample_rate) < end; ++sample) {
      const double share = (time - begin) / leg.duration;
      const double pressure = std::lerp(before.pressure, leg.pressure, share);
      const double shaken = pressure + tremor.at(time, pressure) + outline.noise * chance.normal();
      recording.time.push_back(time);
      recording.pressure.push_back(rounded(shaken, pressure_step));
      recording.depth.push_back(rounded(std::lerp(before.depth, leg.depth, share), depth_step));
    }
    before = leg;
    begin = end;
  }
  return recording;
}

std::vector<double> even_scores(std::size_t count, std::uint64_t seed) {
  std::vector<double> scores(count, 0.0);
  if (count < 2) { return scores; }
  double squares = 0.0;
  for (std::size_t n = 0; n < count; ++n) {
    scores[n] = double(n) - 0.5 * double(count - 1);
    squares += scores[n] * scores[n];
  }
  const double deviation = std::sqrt(squares / double(count - 1));
  for (double& score : scores) { score /= deviation; }
  Random(seed).shuffle(scores);
  return scores;
}

}  // namespace palpate

// SPDX-License-Identifier: MIT
/// Energy that a virtual wall adds, by frequency.

#include <algorithm>
#include <cmath>
#include <complex>

#include "device/servo_loop.hpp"
#include "reference/haptic_loop.hpp"
#include "validation/case.hpp"
#include "validation/claims/haptic_fixture.hpp"

namespace palpate::haptics {

/// Damping that dissipates this energy, measured over whole cycles and compared with the first
/// harmonic of the held force and the condition of Colgate and Schenkel.
void measure_wall_passivity(const CaseContext& context, Outcome& outcome);

namespace {

/// Grip with a prescribed sine motion, independent of the force on it.
class Shaker final : public device::HapticDevice {
 public:
  explicit Shaker(double phase_step) : phase_step_(phase_step) {}
  device::DeviceSample exchange(const Eigen::Vector3d&) noexcept override {
    return {.position = {place(), 0.0, 0.0}};
  }
  void advance() noexcept { ++ticks_; }
  [[nodiscard]] double place() const { return std::sin(phase_step_ * ticks_); }  ///< [m]

 private:
  double phase_step_;
  int ticks_ = 0;
};

struct HeldWall {
  double stiffness = 1000.0;
  double damping = 0.0;
  double period = 1e-3;
};

/// Returns the damping of device and hand that dissipates the energy of the wall for a sine of
/// `cycles` in `ticks`, from the energy of whole cycles [N s/m].
double measured_need(const CaseContext& context, const HeldWall& held, int cycles, int ticks) {
  const double phase_step = 2.0 * M_PI * cycles / ticks;
  Shaker shaker(phase_step);
  Wall wall(held.stiffness, held.damping, held.period);
  wall.touch(std::sin(-phase_step));
  device::ServoLoop servo(shaker, extra_delay(context));
  device::PassivityObserver port;
  for (int tick = 0; tick <= 2 * ticks; ++tick) {
    const Eigen::Vector3d last = servo.sent();
    port.observe(tick * held.period, {shaker.place(), 0.0, 0.0}, last);
    if (tick == ticks) {
      port = {};
      port.observe(0.0, {shaker.place(), 0.0, 0.0}, last);
    }
    servo.tick([&](const device::DeviceSample& sample) { return wall.force(sample); });
    shaker.advance();
  }
  const double omega = phase_step / held.period;
  return -port.energy() / (0.5 * omega * omega * ticks * held.period);
}

/// -Im(H Z) / w, H the wall and Z the zero-order hold at frequency w: the same from the first
/// harmonic of the held force.
double harmonic_need(const HeldWall& held, double omega) {
  using Complex = std::complex<double>;
  const Complex z = std::polar(1.0, -omega * held.period);
  const Complex wall = held.stiffness + held.damping * (1.0 - z) / held.period;
  const Complex hold = (1.0 - z) / Complex(0.0, omega * held.period);
  return -(wall * hold).imag() / omega;
}

/// Returns the damping that the condition of Colgate & Schenkel requires at this frequency.
double passive_need(const HeldWall& held, double omega) {
  using Complex = std::complex<double>;
  const Complex z = std::polar(1.0, -omega * held.period);
  const Complex wall = held.stiffness + held.damping * (1.0 - z) / held.period;
  return 0.5 * held.period / (1.0 - std::cos(omega * held.period)) * ((1.0 - z) * wall).real();
}

}  // namespace

void measure_wall_passivity(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "needed-damping",
                .title = "Damping that takes what a wall feeds in",
                .caption =
                    "A grip shaken on a wall of 1 N/mm at 1 kHz: from the energy of whole "
                    "cycles, from the first harmonic of the held force, and the condition "
                    "of Colgate and Schenkel, which holds for every motion.",
                .x = {.label = "frequency (Hz)"},
                .y = {.label = "needed viscosity (N s/m)"}};
  double worst = 0.0;
  double beyond = -unbounded;
  double most = 0.0;
  for (const double damping : {0.0, 0.4}) {
    const HeldWall held{.damping = damping};
    const std::string name = damping == 0.0 ? "B = 0" : "B = 0.4 N s/m";
    Series points{.label = "measured, " + name, .style = Series::Style::points};
    Series line{.label = "first harmonic, " + name};
    Series limit{.label = "passive, " + name, .style = Series::Style::dashed};
    constexpr int ticks = 1000;
    for (int cycles = 12; cycles < ticks / 2; cycles += 12) {
      const double omega = 2.0 * M_PI * cycles / (ticks * held.period);
      const double need = measured_need(context, held, cycles, ticks);
      const double theory = harmonic_need(held, omega);
      const double error = std::abs(need - theory);
      worst = std::isnan(error) ? error : std::max(worst, error);
      beyond = std::max(beyond, need - passive_need(held, omega));
      most = std::max(most, passive_need(held, omega));
      points.x.push_back(cycles);
      points.y.push_back(need);
      line.x.push_back(cycles);
      line.y.push_back(theory);
      limit.x.push_back(cycles);
      limit.y.push_back(passive_need(held, omega));
    }
    figure.series.push_back(std::move(line));
    figure.series.push_back(std::move(points));
    figure.series.push_back(std::move(limit));
  }
  outcome.judge({.name = "largest_error_of_the_needed_damping",
                 .value = worst,
                 .unit = "N s/m",
                 .upper = 1e-9,
                 .bound_from = "theory: first harmonic of a held force; rounding of 1000 ticks"});
  outcome.judge({.name = "needed_beyond_colgate_and_schenkel",
                 .value = beyond,
                 .unit = "N s/m",
                 .upper = 1e-9,
                 .bound_from = "theory: their condition holds for every motion"});
  const double sum = 0.5 * 1000.0 * 1e-3 + 0.4;
  outcome.judge({.name = "most_that_they_ask_for",
                 .value = most,
                 .unit = "N s/m",
                 .lower = sum * (1.0 - 1e-2),
                 .upper = sum * (1.0 + 1e-12),
                 .bound_from = "theory: K T / 2 + |B|, reached at half the sampling rate"});
  outcome.figures.push_back(std::move(figure));
}

// Virtual walls in a sampled loop: limits of stability and of passivity in the time domain,
// compared with theory.

namespace {

using reference::WallLoop;

/// Largest excursion over two windows of equal length, far enough on for all but the slowest motion
/// to have died: their ratio tells growth from decay.
bool grows(const CaseContext& context, const WallLoop& loop, double stiffness) {
  const int window = context.quick ? 20000 : 60000;
  Rail rail({.mass = loop.mass, .viscosity = loop.viscosity, .period = loop.period});
  rail.put(1e-3, 0.0);
  Wall wall(stiffness, loop.damping, loop.period);
  wall.touch(1e-3);
  device::ServoLoop servo(rail, loop.delay + extra_delay(context));
  double early = 0.0;
  double late = 0.0;
  for (int tick = 0; tick < 3 * window; ++tick) {
    servo.tick([&](const device::DeviceSample& sample) { return wall.force(sample); });
    rail.advance();
    const double size = std::abs(rail.place());
    if (!(size < 1e3)) { return true; }
    if (tick < window) { continue; }
    double& largest = tick < 2 * window ? early : late;
    largest = std::max(largest, size);
  }
  return late > early;
}

/// Finds the limit by bisection in the logarithm of K.
double measured_boundary(const CaseContext& context, const WallLoop& loop) {
  double low = 1.0;
  double high = 1e6;
  if (grows(context, loop, low)) { return 0.0; }
  while (high / low > 1.0 + 2e-6) {
    const double middle = std::sqrt(low * high);
    (grows(context, loop, middle) ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

std::vector<WallLoop> loops(bool quick) {
  std::vector<WallLoop> all;
  for (const double mass : {0.1, 0.2}) {
    for (const double viscosity : {0.5, 2.0}) {
      for (const double damping : {0.0, 1.0}) {
        for (const int delay : {0, 1, 2}) {
          if (quick && mass == 0.2) { continue; }
          all.push_back({mass, viscosity, damping, delay});
        }
      }
    }
  }
  return all;
}

void measure_boundary(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "boundaries",
              .title = "Largest stable stiffness of a wall at 1 kHz",
              .columns = {"m (kg)", "b (N s/m)", "B (N s/m)", "delay (ticks)", "measured (N/m)",
                          "exact (N/m)", "linear rule (N/m)", "passive below (N/m)"}};
  double worst = 0.0;
  double least_drop = unbounded;
  double without_delay = 0.0;
  for (const WallLoop& loop : loops(context.quick)) {
    const double measured = measured_boundary(context, loop);
    const double exact = reference::critical_stiffness(loop);
    const double passive = reference::passive_stiffness(loop);
    const double error = std::abs(measured / exact - 1.0);
    worst = std::isnan(error) ? error : std::max(worst, error);
    if (loop.delay == 0) { without_delay = measured; }
    if (loop.delay == 1) { least_drop = std::min(least_drop, without_delay / measured); }
    const Cell passive_cell = loop.delay > 0  ? Cell("-")
                              : passive > 0.0 ? Cell(passive)
                                              : Cell("none");
    table.rows.push_back({loop.mass, loop.viscosity, loop.damping, static_cast<double>(loop.delay),
                          measured, exact, reference::linear_rule(loop), passive_cell});
  }
  outcome.judge({.name = "largest_error_of_the_boundary",
                 .value = worst,
                 .upper = 1e-4,
                 .bound_from =
                     "theory: roots of the exact z transform; bisected to 2e-6, growth over "
                     "tens of thousands of ticks"});
  outcome.judge({.name = "least_loss_by_one_tick_of_delay",
                 .value = least_drop,
                 .lower = 2.5,
                 .bound_from = "theory: about three times; a tick more or less cannot hide"});
  outcome.tables.push_back(std::move(table));
}

void add_lines(const CaseContext& context, Figure& figure, int delay) {
  const std::string late = delay == 0 ? "no delay" : std::to_string(delay) + " tick late";
  Series points{.label = "measured, " + late, .style = Series::Style::points};
  Series exact{.label = "exact, " + late};
  Series rule{.label = "linear rule, " + late, .style = Series::Style::dashed};
  const int steps = context.quick ? 4 : 8;
  for (int n = 0; n <= 40; ++n) {
    WallLoop loop{.mass = 0.1, .viscosity = 0.5, .damping = 2.0 * n / 40.0, .delay = delay};
    exact.x.push_back(loop.damping);
    exact.y.push_back(1e-3 * reference::critical_stiffness(loop));
    rule.x.push_back(loop.damping);
    rule.y.push_back(1e-3 * reference::linear_rule(loop));
    if (n % (40 / steps) == 0) {
      points.x.push_back(loop.damping);
      points.y.push_back(1e-3 * measured_boundary(context, loop));
    }
  }
  figure.series.push_back(std::move(exact));
  figure.series.push_back(std::move(points));
  figure.series.push_back(std::move(rule));
}

void measure_width(const CaseContext& context, Outcome& outcome) {
  Figure figure{.id = "z-width",
                .title = "Z-width of a free device at 1 kHz",
                .caption =
                    "Stiffest stable wall over its damping, m = 0.1 kg and b = 0.5 N s/m: "
                    "lines from the roots of the loop, points from the time domain, dashed "
                    "the linear rule. Below the lowest line every wall is passive.",
                .x = {.label = "B of the wall (N s/m)", .minimum = 0.0, .maximum = 2.0},
                .y = {.label = "K of the wall (N/mm)", .minimum = 0.0}};
  add_lines(context, figure, 0);
  add_lines(context, figure, 1);
  figure.series.push_back({.label = "passive below (Colgate and Schenkel)",
                           .style = Series::Style::line,
                           .x = {0.0, 0.5},
                           .y = {1.0, 0.0}});
  double worst = 0.0;
  for (std::size_t n = 0; n + 2 < figure.series.size(); n += 3) {
    const Series& exact = figure.series[n];
    const Series& points = figure.series[n + 1];
    for (std::size_t i = 0; i < points.x.size(); ++i) {
      const auto at = static_cast<std::size_t>(std::lround(points.x[i] * 20.0));
      const double error = std::abs(points.y[i] / exact.y[at] - 1.0);
      worst = std::isnan(error) ? error : std::max(worst, error);
    }
  }
  outcome.judge({.name = "largest_error_of_the_points",
                 .value = worst,
                 .upper = 1e-4,
                 .bound_from = "theory: roots of the exact z transform"});
  outcome.figures.push_back(std::move(figure));
}

struct Plant {
  const char* name;
  double mass;
  double viscosity;
};
constexpr Plant plants[] = {{"free device", 0.13, 0.5}, {"held by a medium hand", 0.28, 6.5}};

void measure_rates(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "rates",
              .title = "Stiffest stable wall by the rate of the loop",
              .caption =
                  "Without wall damping and delay, and with the one tick of delay of a loop "
                  "that sends and reads in a single exchange.",
              .columns = {"grip", "rate (Hz)", "no delay (N/m)", "one tick late (N/m)"}};
  double worst = 0.0;
  for (const Plant& plant : plants) {
    double slow = 0.0;
    double ratio = 0.0;
    for (const double rate : {300.0, 500.0, 1000.0, 2000.0}) {
      if (context.quick && rate != 300.0 && rate != 1000.0) { continue; }
      std::vector<Cell> row{std::string(plant.name), rate};
      for (const int delay : {0, 1}) {
        const WallLoop loop{plant.mass, plant.viscosity, 0.0, delay, 1.0 / rate};
        const double measured = measured_boundary(context, loop);
        const double error = std::abs(measured / reference::critical_stiffness(loop) - 1.0);
        worst = std::isnan(error) ? error : std::max(worst, error);
        if (delay == 0 && rate == 300.0) { slow = measured; }
        if (delay == 0 && rate == 1000.0) { ratio = measured / slow; }
        row.emplace_back(measured);
      }
      table.rows.push_back(std::move(row));
    }
    outcome.judge({.name = std::string("gain_of_1000_over_300_hz_") +
                           (plant.viscosity < 1.0 ? "free" : "held"),
                   .value = ratio,
                   .lower = 3.1,
                   .upper = 10.0 / 3.0 + 1e-3,
                   .bound_from =
                       "theory: K ~ 2 b / T where T is short against m / b, less where it "
                       "is not"});
  }
  outcome.judge({.name = "largest_error_of_a_boundary",
                 .value = worst,
                 .upper = 1e-4,
                 .bound_from = "theory: roots of the exact z transform"});
  outcome.tables.push_back(std::move(table));
}

/// Returns the remaining oscillation after ten seconds on a wall with an encoder [m].
double limit_cycle(const CaseContext& context, const Rail::Settings& settings, double stiffness) {
  Rail rail(settings);
  rail.put(3.3 * settings.encoder_step, 0.0);
  Wall wall(stiffness, 0.0, settings.period);
  device::ServoLoop servo(rail, extra_delay(context));
  double swing = 0.0;
  for (int tick = 0; tick < 10000; ++tick) {
    servo.tick([&](const device::DeviceSample& sample) { return wall.force(sample); });
    rail.advance();
    if (tick >= 9000) { swing = std::max(swing, std::abs(rail.velocity()) * settings.period); }
    if (!(std::abs(rail.place()) < 1.0)) { return 1.0; }
  }
  return swing;
}

void measure_quantisation(const CaseContext& context, Outcome& outcome) {
  // K <= min(2 b / T, 2 f / D): below it every encoder step falls to rest.
  const Rail::Settings settings{
      .mass = 0.1, .viscosity = 2.0, .encoder_step = 5e-5, .coulomb_friction = 0.05};
  const WallLoop loop{.mass = settings.mass, .viscosity = settings.viscosity};
  const double limit =
      reference::quantised_stiffness(loop, settings.encoder_step, settings.coulomb_friction);
  Figure figure{.id = "limit-cycle",
                .title = "Swing that remains on a quantised wall",
                .caption =
                    "Encoder of 0.05 mm, 0.05 N of Coulomb friction, 2 N s/m: beyond 2 f / D "
                    "= 2 N/mm friction no longer holds an encoder step.",
                .x = {.label = "K of the wall (N/mm)"},
                .y = {.label = "fastest motion in the last second (um a tick)"},
                .marks = {{.label = "2 f / D", .x = 1e-3 * limit}}};
  Series swings{.label = "swing", .style = Series::Style::line_and_points};
  double below = 0.0;
  for (int n = 1; n <= 30; ++n) {
    const double stiffness = 100.0 * n;
    const double swing = limit_cycle(context, settings, stiffness);
    swings.x.push_back(1e-3 * stiffness);
    swings.y.push_back(1e6 * swing);
    if (stiffness <= limit) { below = std::max(below, swing); }
  }
  outcome.judge({.name = "swing_within_the_rule",
                 .value = below,
                 .unit = "m",
                 .upper = 0.0,
                 .bound_from = "Abbott and Okamura: K <= min(2 b / T, 2 f / D) comes to rest"});
  figure.series.push_back(std::move(swings));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> wall_cases() {
  return {
      {.name = "haptics/wall/boundary",
       .suite = "haptics",
       .claim = "The stiffest stable virtual wall is that of the loop's exact z transform, with "
                "and without wall damping and delay.",
       .measure = measure_boundary,
       .weight = 10.0},
      {.name = "haptics/wall/z-width",
       .suite = "haptics",
       .claim = "Over the damping of the wall the stable region has the borders that theory "
                "draws.",
       .measure = measure_width,
       .weight = 8.0},
      {.name = "haptics/wall/rates",
       .suite = "haptics",
       .claim = "A loop at 1000 Hz renders a wall more than three times as stiff as one at "
                "300 Hz.",
       .measure = measure_rates,
       .weight = 4.0},
      {.name = "haptics/wall/passivity",
       .suite = "haptics",
       .claim = "What a wall feeds in at a frequency is what a zero-order hold makes of it, and "
                "never more "
                "than the passivity condition allows for.",
       .measure = measure_wall_passivity,
       .weight = 0.2},
      {.name = "haptics/wall/quantisation",
       .suite = "haptics",
       .claim = "Friction holds an encoder's steps up to K = 2 f / D.",
       .measure = measure_quantisation,
       .weight = 0.2}};
}

}  // namespace palpate::haptics

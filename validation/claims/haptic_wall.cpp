// SPDX-License-Identifier: MIT
/// Energy that a virtual wall adds, by frequency.

#include <algorithm>
#include <complex>

#include "device/haptic_device.hpp"
#include "device/servo_loop.hpp"
#include "reference/haptic_loop.hpp"
#include "validation/claims/groups.hpp"

namespace palpate::haptics {

namespace {

/// Device with m x'' + b x' = F along the rail (x of the device), F constant within a tick and
/// exact motion between ticks; optionally with an encoder and Coulomb friction.
class Rail final : public device::HapticDevice {
 public:
  struct Settings {
    double mass = 0.1;              ///< [kg]
    double viscosity = 0.5;         ///< [N s/m]
    double period = 1e-3;           ///< [s]
    double encoder_step = 0.0;      ///< [m]; 0: exact
    double coulomb_friction = 0.0;  ///< [N]
  };

  explicit Rail(const Settings& settings) : settings_(settings) {}

  void put(double place, double velocity) {
    place_ = place;
    velocity_ = velocity;
  }

  device::DeviceSample exchange(const Eigen::Vector3d& force) noexcept override {
    force_ = force.x();
    const double step = settings_.encoder_step;
    return {.position = {step > 0.0 ? step * std::round(place_ / step) : place_, 0.0, 0.0}};
  }

  /// Advances by one period. With friction a glide ends at zero velocity and starts only above the
  /// friction.
  void advance() noexcept {
    const double friction = settings_.coulomb_friction;
    double left = settings_.period;
    for (int stretch = 0; stretch < 3 && left > 0.0; ++stretch) {
      if (friction == 0.0) { return glide(force_, left); }
      const bool rests = velocity_ == 0.0;
      if (rests && std::abs(force_) <= friction) { return; }
      const double against =
          rests ? std::copysign(friction, force_) : std::copysign(friction, velocity_);
      const double net = force_ - against;
      // v(t) = e + (v - e) exp(-t / tau) with e = net / b; it ends where that is zero.
      const double tau = settings_.mass / settings_.viscosity;
      const double end_velocity = net / settings_.viscosity;
      const bool stops = !rests && end_velocity * velocity_ < 0.0;
      const double stop = stops ? tau * std::log1p(-velocity_ / end_velocity) : left;
      const double time = std::min(left, stop);
      glide(net, time);
      if (stops && stop <= left) { velocity_ = 0.0; }
      left -= time;
    }
  }

  [[nodiscard]] double place() const { return place_; }        ///< [m]
  [[nodiscard]] double velocity() const { return velocity_; }  ///< [m/s]

 private:
  /// The exact motion under a constant force for a while.
  void glide(double force, double time) noexcept {
    const double tau = settings_.mass / settings_.viscosity;
    const double decay = -std::expm1(-time / tau);
    const double end_velocity = force / settings_.viscosity;
    place_ += end_velocity * time + (velocity_ - end_velocity) * tau * decay;
    velocity_ += (end_velocity - velocity_) * decay;
  }

  Settings settings_;
  double force_ = 0.0;
  double place_ = 0.0;
  double velocity_ = 0.0;
};

/// Two-sided virtual wall at 0 with damping from a backward difference.
class Wall {
 public:
  Wall(double stiffness, double damping, double period)
      : stiffness_(stiffness), damping_(damping / period) {}
  [[nodiscard]] Eigen::Vector3d force(const device::DeviceSample& sample) noexcept {
    const double place = sample.position.x();
    const double pull = stiffness_ * place + damping_ * (place - last_);
    last_ = place;
    return {-pull, 0.0, 0.0};
  }
  void touch(double place) { last_ = place; }

 private:
  double stiffness_;
  double damping_;
  double last_ = 0.0;
};

/// Returns the delay [ticks] that a mutation of the loop adds.
int extra_delay(const CaseContext& context) {
  return context.mutation != nullptr ? context.mutation->loop_delay : 0;
}

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

/// -Im(H Z) / w, with H the wall and Z the zero-order hold: from the first harmonic of the force.
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

/// Compares the damping that dissipates the energy of a wall, measured over whole cycles, with the
/// first harmonic of the held force and the condition of Colgate and Schenkel.
void measure_wall_passivity(const CaseContext& context, Outcome& outcome) {
  Figure& figure = outcome.plot("needed-damping", "Damping that takes what a wall feeds in",
                                "A grip shaken on a wall of 1 N/mm at 1 kHz: from the energy of "
                                "whole cycles, from the first harmonic of the held force, and the "
                                "condition of Colgate and Schenkel, which holds for every motion.",
                                {"frequency (Hz)"}, {"needed viscosity (N s/m)"});
  Largest worst;
  Largest beyond(-unbounded);
  Largest most;
  for (const double damping : {0.0, 0.4}) {
    const HeldWall held{.damping = damping};
    const std::string name = damping == 0.0 ? "B = 0" : "B = 0.4 N s/m";
    Series& line = figure.add("first harmonic, " + name);
    Series& points = figure.add("measured, " + name, Series::Style::points);
    Series& limit = figure.add("passive, " + name, Series::Style::dashed);
    constexpr int ticks = 1000;
    for (int cycles = 12; cycles < ticks / 2; cycles += 12) {
      const double omega = 2.0 * M_PI * cycles / (ticks * held.period);
      const double need = measured_need(context, held, cycles, ticks);
      const double theory = harmonic_need(held, omega);
      worst.add(std::abs(need - theory));
      beyond.add(need - passive_need(held, omega));
      most.add(passive_need(held, omega));
      points.add(cycles, need);
      line.add(cycles, theory);
      limit.add(cycles, passive_need(held, omega));
    }
  }
  outcome.judge_at_most("largest_error_of_the_needed_damping", worst.value(), 1e-9,
                        "theory: first harmonic of a held force; rounding of 1000 ticks", "N s/m");
  outcome.judge_at_most("needed_beyond_colgate_and_schenkel", beyond.value(), 1e-9,
                        "theory: their condition holds for every motion", "N s/m");
  const double sum = 0.5 * 1000.0 * 1e-3 + 0.4;
  outcome.judge_between("most_that_they_ask_for", most.value(), sum * (1.0 - 1e-2),
                        sum * (1.0 + 1e-12),
                        "theory: K T / 2 + |B|, reached at half the sampling rate", "N s/m");
}

// Virtual walls in a sampled loop: limits of stability and passivity in the time domain.

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
  Table& table =
      outcome.table("boundaries", "Largest stable stiffness of a wall at 1 kHz", "",
                    {"m (kg)", "b (N s/m)", "B (N s/m)", "delay (ticks)", "measured (N/m)",
                     "exact (N/m)", "linear rule (N/m)", "passive below (N/m)"});
  Largest worst;
  Smallest least_drop;
  double without_delay = 0.0;
  for (const WallLoop& loop : loops(context.quick)) {
    const double measured = measured_boundary(context, loop);
    const double exact = reference::critical_stiffness(loop);
    const double passive = reference::passive_stiffness(loop);
    worst.add(std::abs(measured / exact - 1.0));
    if (loop.delay == 0) { without_delay = measured; }
    if (loop.delay == 1) { least_drop.add(without_delay / measured); }
    const Cell passive_cell = loop.delay > 0  ? Cell("-")
                              : passive > 0.0 ? Cell(passive)
                                              : Cell("none");
    table.rows.push_back({loop.mass, loop.viscosity, loop.damping, loop.delay, measured, exact,
                          reference::linear_rule(loop), passive_cell});
  }
  outcome.judge_at_most("largest_error_of_the_boundary", worst.value(), 4e-6,
                        "theory: roots of the exact z transform; bisection to 2e-6");
  outcome.judge_at_least("least_loss_by_one_tick_of_delay", least_drop.value(), 2.5,
                         "theory: about three times; a tick more or less cannot hide");
}

void add_lines(const CaseContext& context, Figure& figure, int delay) {
  const std::string late = delay == 0 ? "no delay" : std::to_string(delay) + " tick late";
  Series& exact = figure.add("exact, " + late);
  Series& points = figure.add("measured, " + late, Series::Style::points);
  Series& rule = figure.add("linear rule, " + late, Series::Style::dashed);
  const int steps = context.quick ? 4 : 8;
  for (int n = 0; n <= 40; ++n) {
    WallLoop loop{.mass = 0.1, .viscosity = 0.5, .damping = 2.0 * n / 40.0, .delay = delay};
    exact.add(loop.damping, 1e-3 * reference::critical_stiffness(loop));
    rule.add(loop.damping, 1e-3 * reference::linear_rule(loop));
    if (n % (40 / steps) == 0) {
      points.add(loop.damping, 1e-3 * measured_boundary(context, loop));
    }
  }
}

void measure_width(const CaseContext& context, Outcome& outcome) {
  Figure& figure =
      outcome.plot("z-width", "Z-width of a free device at 1 kHz",
                   "Stiffest stable wall over its damping, m = 0.1 kg and b = 0.5 N s/m: lines "
                   "from the roots of the loop, points from the time domain, dashed the linear "
                   "rule. Below the lowest line every wall is passive.",
                   {.label = "B of the wall (N s/m)", .minimum = 0.0, .maximum = 2.0},
                   {.label = "K of the wall (N/mm)", .minimum = 0.0});
  add_lines(context, figure, 0);
  add_lines(context, figure, 1);
  figure.add("passive below (Colgate and Schenkel)", {0.0, 0.5}, {1.0, 0.0}, Series::Style::line);
  Largest worst;
  for (std::size_t n = 0; n + 2 < figure.series.size(); n += 3) {
    const Series& exact = figure.series[n];
    const Series& points = figure.series[n + 1];
    for (std::size_t i = 0; i < points.x.size(); ++i) {
      const auto at = static_cast<std::size_t>(std::lround(points.x[i] * 20.0));
      worst.add(std::abs(points.y[i] / exact.y[at] - 1.0));
    }
  }
  outcome.judge_at_most("largest_error_of_the_points", worst.value(), 4e-6,
                        "theory: roots of the exact z transform");
}

struct Plant {
  const char* name;
  double mass;
  double viscosity;
};
constexpr Plant plants[] = {{"free device", 0.13, 0.5}, {"held by a medium hand", 0.28, 6.5}};

void measure_rates(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table("rates", "Stiffest stable wall by the rate of the loop",
                               "Without wall damping and delay, and with the one tick of delay of "
                               "a loop that sends and reads in a single exchange.",
                               {"grip", "rate (Hz)", "no delay (N/m)", "one tick late (N/m)"});
  Largest worst;
  for (const Plant& plant : plants) {
    double slow = 0.0;
    double ratio = 0.0;
    for (const double rate : {300.0, 500.0, 1000.0, 2000.0}) {
      if (context.quick && rate != 300.0 && rate != 1000.0) { continue; }
      std::vector<Cell> row{plant.name, rate};
      for (const int delay : {0, 1}) {
        const WallLoop loop{plant.mass, plant.viscosity, 0.0, delay, 1.0 / rate};
        const double measured = measured_boundary(context, loop);
        worst.add(std::abs(measured / reference::critical_stiffness(loop) - 1.0));
        if (delay == 0 && rate == 300.0) { slow = measured; }
        if (delay == 0 && rate == 1000.0) { ratio = measured / slow; }
        row.emplace_back(measured);
      }
      table.rows.push_back(std::move(row));
    }
    outcome.judge_between(
        std::string("gain_of_1000_over_300_hz_") + (plant.viscosity < 1.0 ? "free" : "held"), ratio,
        3.1, 10.0 / 3.0 + 1e-3,
        "theory: K ~ 2 b / T where T is short against m / b, less where it is not");
  }
  outcome.judge_at_most("largest_error_of_a_boundary", worst.value(), 4e-6,
                        "theory: roots of the exact z transform");
}

/// Returns the remaining oscillation after ten seconds on a wall with an encoder [m].
double limit_cycle(const CaseContext& context, const Rail::Settings& settings, double stiffness) {
  Rail rail(settings);
  rail.put(3.3 * settings.encoder_step, 0.0);
  Wall wall(stiffness, 0.0, settings.period);
  device::ServoLoop servo(rail, extra_delay(context));
  Largest swing;
  for (int tick = 0; tick < 10000; ++tick) {
    servo.tick([&](const device::DeviceSample& sample) { return wall.force(sample); });
    rail.advance();
    if (tick >= 9000) { swing.add(std::abs(rail.velocity()) * settings.period); }
    if (!(std::abs(rail.place()) < 1.0)) { return 1.0; }
  }
  return swing.value();
}

void measure_quantisation(const CaseContext& context, Outcome& outcome) {
  // K <= min(2 b / T, 2 f / D): below it every encoder step falls to rest.
  const Rail::Settings settings{
      .mass = 0.1, .viscosity = 2.0, .encoder_step = 5e-5, .coulomb_friction = 0.05};
  const WallLoop loop{.mass = settings.mass, .viscosity = settings.viscosity};
  const double limit =
      reference::quantised_stiffness(loop, settings.encoder_step, settings.coulomb_friction);
  Figure& figure =
      outcome.plot("limit-cycle", "Swing that remains on a quantised wall",
                   "Encoder of 0.05 mm, 0.05 N of Coulomb friction, 2 N s/m: beyond 2 f / D = 2 "
                   "N/mm friction no longer holds an encoder step.",
                   {"K of the wall (N/mm)"}, {"fastest motion in the last second (um a tick)"});
  figure.marks = {{.label = "2 f / D", .x = 1e-3 * limit}};
  Series& swings = figure.add("swing", Series::Style::line_and_points);
  Largest below;
  for (int n = 1; n <= 30; ++n) {
    const double stiffness = 100.0 * n;
    const double swing = limit_cycle(context, settings, stiffness);
    swings.add(1e-3 * stiffness, 1e6 * swing);
    if (stiffness <= limit) { below.add(swing); }
  }
  outcome.judge_at_most("swing_within_the_rule", below.value(), 0.0,
                        "Abbott and Okamura: K <= min(2 b / T, 2 f / D) comes to rest", "m");
}

}  // namespace

std::vector<Case> wall_cases() {
  return {{"haptics/wall/boundary", "haptics",
           "The stiffest stable virtual wall is that of the loop's exact z transform, with and "
           "without wall damping and delay.",
           measure_boundary, 10.0},
          {"haptics/wall/z-width", "haptics",
           "Over the damping of the wall the stable region has the borders that theory draws.",
           measure_width, 8.0},
          {"haptics/wall/rates", "haptics",
           "A loop at 1000 Hz renders a wall more than three times as stiff as one at 300 Hz.",
           measure_rates, 4.0},
          {"haptics/wall/passivity", "haptics",
           "What a wall feeds in at a frequency is what a zero-order hold makes of it, and never "
           "more than the passivity condition allows for.",
           measure_wall_passivity, 0.2},
          {"haptics/wall/quantisation", "haptics",
           "Friction holds an encoder's steps up to K = 2 f / D.", measure_quantisation, 0.2}};
}

}  // namespace palpate::haptics

// SPDX-License-Identifier: MIT
#include "validation/cases/wall_passivity.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "device/passivity.hpp"
#include "device/servo_loop.hpp"
#include "validation/cases/haptic_rig.hpp"

namespace palpate::haptics {

namespace {

/// A grip that is shaken along a sine, whatever the force on it.
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

/// Damping of device and hand that takes what the wall gives to a sine of `cycles` in `ticks`, from
/// the energy of whole cycles [N s/m].
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
    if (tick == ticks) { port = {}; port.observe(0.0, {shaker.place(), 0.0, 0.0}, last); }
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

/// Colgate & Schenkel: what every motion together may need at this frequency.
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
                .caption = "A grip shaken on a wall of 1 N/mm at 1 kHz: from the energy of whole "
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
  outcome.judge({.name = "largest_error_of_the_needed_damping", .value = worst, .unit = "N s/m",
                 .upper = 1e-9,
                 .bound_from = "theory: first harmonic of a held force; rounding of 1000 ticks"});
  outcome.judge({.name = "needed_beyond_colgate_and_schenkel", .value = beyond, .unit = "N s/m",
                 .upper = 1e-9, .bound_from = "theory: their condition holds for every motion"});
  const double sum = 0.5 * 1000.0 * 1e-3 + 0.4;
  outcome.judge({.name = "most_that_they_ask_for", .value = most, .unit = "N s/m",
                 .lower = sum * (1.0 - 1e-2), .upper = sum * (1.0 + 1e-12),
                 .bound_from = "theory: K T / 2 + |B|, reached at half the sampling rate"});
  outcome.figures.push_back(std::move(figure));
}

}  // namespace palpate::haptics

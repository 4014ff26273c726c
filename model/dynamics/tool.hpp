// SPDX-License-Identifier: MIT
#pragma once
/// What a person writes about the tool of a scene: needle or probe, what drives it, the syringe.
/// Plain data with documented defaults, SI units.

#include <array>
#include <optional>

#include <Eigen/Core>

namespace palpate {

/// Rigid needle with a sharp tip on the line entry + s direction; s = 0 on the undeformed skin.
struct Needle {
  double diameter = 1.651e-3;                  ///< [m] outer; 16 gauge. Reported, not mechanical
  Eigen::Vector2d entry{0.0, 0.0};             ///< x and y where the line meets z = 0 [m]
  Eigen::Vector3d direction{0.0, 0.0, 1.0};    ///< of insertion; made a unit vector
  double mass = 0.02;                          ///< [kg] of needle and syringe; drive by force
};

/// Outer diameter [m] of a Stubs needle gauge (ISO 9626), or nothing for one that is not made.
std::optional<double> diameter_of_gauge(int gauge);

/// A grid of places on the skin that a probe feels in turn, its middle at the probe's entry.
struct PalpationGrid {
  std::array<int, 2> sites{9, 9};  ///< along x and y
  double spacing = 0.004;          ///< [m]

  [[nodiscard]] Eigen::Vector2d half_span() const {
    return 0.5 * spacing * Eigen::Vector2d(sites[0] - 1, sites[1] - 1);
  }
};

/// Blunt tool that presses on the skin: the force is spread over its footprint, nothing is cut.
struct Probe {
  enum class Shape { fingertip, ultrasound } shape = Shape::fingertip;
  Eigen::Vector2d size{0.015, 0.015};  ///< [m] fingertip: diameter; ultrasound: along x and y
  Eigen::Vector2d entry{0.0, 0.0};     ///< centre of the footprint [m]
  double mass = 0.1;                   ///< [kg] drive by force
  std::optional<PalpationGrid> map{};  ///< of the stiffness that it feels, beside the run
};

struct Drive {
  enum class Kind { trajectory, force, falcon } kind = Kind::trajectory;
  enum class Technique { continuous, intermittent } technique = Technique::continuous;
  double start = 0.0;              ///< [s] before it the tool rests
  double from = 0.0;               ///< tip on its line before the start [m]; 0: at the skin
  // Kind::trajectory
  double speed = 0.005;            ///< [m/s] while advancing
  double advance = 0.002;          ///< [m] of one advance, intermittent
  double pause = 0.5;              ///< [s] between two advances or two pushes, intermittent
  std::optional<double> depth{};   ///< [m] where the advance ends; empty: it does not
  double hold = 0.5;               ///< [s] at that depth, or at full force, before the withdrawal
  double withdraw_speed = 0.0;     ///< [m/s]; 0: the tool stays
  double grip_stiffness = 5000.0;  ///< [N/m] between hand and tool where bone stops the tool
  // Kind::force
  double force = 10.0;             ///< [N] of the hand when fully on
  double rise = 1.0;               ///< [s] from none to full
  double push = 0.2;               ///< [s] of one push, intermittent
  double withdraw_force = 0.0;     ///< [N] after hold; 0: the push goes on for ever
  double hand_viscosity = 50.0;    ///< [N s/m] of the hand, against the tool's velocity
};

/// Fluid between thumb and needle tip (model/EQUATIONS.md, "Syringe"); saline by default.
struct Syringe {
  double plunger_area = 1.767e-4;       ///< [m^2]
  double compliance = 2.0e-12;          ///< C [m^3/Pa] of the wall and any air
  double thumb_force = 11.0;            ///< largest force of the thumb [N]
  double thumb_flow = 1.0e-7;           ///< largest flow that the thumb keeps up [m^3/s]
  double tissue_resistance = 2.0e12;    ///< R to flow into solid tissue [Pa s/m^3]
  double epidural_resistance = 2.0e10;  ///< R into the epidural space [Pa s/m^3]
  double open_resistance = 1.0e9;       ///< R of the needle itself, tip in air [Pa s/m^3]
};

/// 10 ml of air instead: C = V / p0, and flows 55 times those of saline, the ratio of viscosities.
Syringe air_syringe();

}  // namespace palpate

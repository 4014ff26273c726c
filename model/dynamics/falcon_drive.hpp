// SPDX-License-Identifier: MIT
#pragma once
/// What a person writes about a tool that a hand holds through a haptic device: `[falcon]` of a scene.
/// Plain data with documented defaults, SI units; the device itself is of no concern here.

namespace palpate {

struct FalconDrive {
  /// How the hand on the grip resists: presets of mass, viscosity and stiffness.
  enum class Hand { light, medium, firm, two_stage } hand = Hand::medium;
  /// Published lengths of the device's legs.
  enum class Geometry { libnifalcon, martin_hillier } geometry = Geometry::libnifalcon;
  /// The driver between loop and wire: exact, or with the defects of the common open one.
  enum class Profile { correct, stock } profile = Profile::correct;
  /// What the loop takes for the tool's place between two steps of slower tissue.
  enum class Between { hold, extrapolate } between = Between::hold;

  double rate = 1000.0;               ///< of the haptic loop [Hz]
  int delay = 0;                      ///< whole ticks from a position to the force it leads to
  double coupling_stiffness = 2000.0; ///< between grip and tool [N/m]
  double coupling_viscosity = 20.0;   ///< [N s/m]
  double start_height = 0.16;         ///< of the grip along the device's z where the tip is on the skin [m]
  double tremor = 0.0;                ///< amplitude of the hand's tremor [m]
  double reaction_delay = 0.175;      ///< from a loss of resistance to the hand's answer [s]
  bool quantised = true;              ///< whole encoder counts and motor words
  bool friction = true;               ///< in the device's joints
  bool passivity_controller = false;  ///< damps what the rendering would feed in
  int seed = 1;                       ///< of everything random
};

}  // namespace palpate
